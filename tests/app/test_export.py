"""Pictures and the page as one file, made without a browser."""

import json
import re

import pytest

from app.shared.components import WEB
from app.site.export import export_page, export_picture
from omnivat.cli import main
from omnivat.figures import maps, theme
from omnivat.kit.errors import SettingsError


@pytest.fixture
def frames(framed):
    return framed.frames


def test_colours_are_those_of_the_page():
    text = (WEB / "shared/palette.js").read_text(encoding="utf-8")
    for name, colours in (
        ("OKABE_ITO", theme.DOMAINS),
        ("TOL_BRIGHT", theme.CLASSES),
        ("CIVIDIS", maps.CIVIDIS),
    ):
        listed = re.search(rf"const {name} = \[(.*?)\]", text, re.S)
        assert listed
        assert re.findall(r"#\w{6}", listed[1]) == colours


def test_the_curves_are_those_of_the_stage_and_say_what_is_a_what_if(framed, tmp_path):
    out = tmp_path / "curves.svg"
    look = {"what": "curves", "order": None, "stage": "relu", "kind": "pca", "colour": "domain"}
    export_picture(framed, framed.frames, out, **look)
    text = out.read_text(encoding="utf-8")
    assert "what-if" in text
    assert "trained on TAG-sim" in text
    assert "F after ReLU" in text


def test_a_map_that_is_not_there_is_refused(framed, tmp_path):
    look = {"what": "map", "order": 0, "stage": "relu", "kind": "umap", "colour": "class"}
    with pytest.raises(SettingsError, match="There is no map 'umap/relu'"):
        export_picture(framed, framed.frames, tmp_path / "x.svg", **look)


def test_the_saved_page_asks_nothing_of_outside_and_holds_its_frames(
    small_places, frames, tmp_path
):
    out = tmp_path / "page.html"
    export_page(small_places, frames, out)
    text = out.read_text(encoding="utf-8")
    assert not re.search(r'(src|href)="(?!data:)', text)
    assert "https://" not in text
    assert "data:application/octet-stream;base64,T1ZGUkFNRV" in text  # OVFRAMES
    assert "simulated" in text
    held = json.loads(re.search(r'id="omnivat-held">(.*?)</script>', text)[1])
    assert {"/frames", "/modes", "/pairs", "/toy", "/unseen"} <= set(held["files"])
    assert "tour-start" in text


def test_the_command_writes_a_map_of_every_point_that_says_simulated(frames, tmp_path, capsys):
    out = tmp_path / "map.svg"
    assert main(["export", "--frames", str(frames), "--out", str(out), "--colour", "class"]) == 0
    text = out.read_text(encoding="utf-8")
    assert text.count("<circle") == text.count("<polygon") == 80 and "simulated data" in text
    assert "map written to" in capsys.readouterr().out


def test_the_command_refuses_an_ending_that_it_cannot_write(tmp_path, capsys):
    assert main(["export", "--what", "page", "--out", str(tmp_path / "x.png")]) == 1
    assert "for the page it ends in .html" in capsys.readouterr().err
