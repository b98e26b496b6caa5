"""Names that would be markup, in every kind of exported figure."""

import json
import re
import xml.etree.ElementTree as ET

import numpy as np
import pytest

from omnivat.figures import lines, map_figure
from omnivat.figures.page import html_page, write

EVIL = "<img src=x onerror=alert(1)></script><a href='javascript:alert(1)'>&lt;b>"


def figures():
    places = np.arange(16.0).reshape(8, 2)
    yield lines({EVIL: ([0, 1], [1.0, 2.0])}, title=EVIL, across=EVIL, up=EVIL, caption=EVIL)
    yield map_figure(places, np.zeros(4, int), [EVIL], hover=[EVIL] * 4, title=EVIL, caption=EVIL)


@pytest.mark.parametrize("figure", [*figures()], ids=["curves", "map"])
def test_a_name_is_text_in_every_export(figure, tmp_path):
    page = html_page(EVIL, [figure])
    assert "<img" not in page and page.count("</script>") == 1
    held = re.search(r"const figures = (\[.*?\]), templates = ", page, re.DOTALL)[1]
    for text in _texts(json.loads(held)[0], skipped=("meta",)):
        assert "<img" not in text and "<a" not in text, text
    drawn = write(tmp_path / "a.svg", figure).read_text(encoding="utf-8")
    tags = {one.tag.rpartition("}")[2] for one in ET.fromstring(drawn).iter()}
    assert not tags & {"script", "img", "image", "a", "foreignObject"}
    assert "onerror=alert" in drawn  # as text


def test_a_name_with_what_xml_cannot_hold_leaves_the_svg_readable(tmp_path):
    name = "a\x1bb\udcff\uffff\u200cc"
    figure = lines({name: ([0, 1], [1.0, 2.0])}, title=name, across=name, up=name, caption=name)
    drawn = ET.fromstring(write(tmp_path / "a.svg", figure).read_text(encoding="utf-8"))
    assert "a\ufffdb\ufffd\ufffd\u200cc" in [one.text for one in drawn.iter()]


def _texts(value, skipped=()):
    if isinstance(value, str):
        yield value
    elif isinstance(value, dict):
        for name, one in value.items():
            if name not in skipped:
                yield from _texts(one, skipped)
    elif isinstance(value, list):
        for one in value:
            yield from _texts(one, skipped)
