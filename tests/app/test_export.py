"""Pictures and the page as one file, made without a browser."""

import json
import re
from dataclasses import replace

import pytest
from PIL import Image

from app.components import WEB
from app.export import export_page, export_picture, scripts
from omnivat.cli import main
from omnivat.figures import maps, theme
from omnivat.figures.curves import MEASURES, gap_curves
from omnivat.figures.drawing import Picture, Shape, png, svg
from omnivat.figures.still import svg_of
from omnivat.kit.errors import SettingsError
from omnivat.maps.frames import read_frames


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


@pytest.mark.parametrize("colour", maps.COLOURS)
def test_the_map_holds_every_point_and_says_simulated(framed, tmp_path, colour):
    out = tmp_path / "map.svg"
    look = {"what": "map", "order": 0.5, "stage": "f_hat", "kind": "pca", "colour": colour}
    export_picture(framed, framed.frames, out, **look)
    text = out.read_text(encoding="utf-8")
    assert text.count("<circle") == text.count("<polygon") == 80
    assert "simulated data" in text


def test_the_curves_say_what_is_a_what_if_and_shade_where_the_head_is_at_home(framed, tmp_path):
    out = tmp_path / "curves.svg"
    look = {"what": "curves", "order": None, "stage": "relu", "kind": "pca", "colour": "domain"}
    export_picture(framed, framed.frames, out, **look)
    text = out.read_text(encoding="utf-8")
    assert "what-if" in text
    assert "trained on TAG-sim" in text
    assert text.count("<polyline") >= 4
    assert text.count('fill="#3b82f6" opacity="0.2"') == 4


def test_curves_of_retrained_heads_have_dots_and_the_span_of_trainings(frames):
    found = read_frames(frames)
    stops = len(found.orders)
    spread = {
        f"seeds:accuracy/unseen/{end}": [0.5 + shift] * stops
        for end, shift in (("mean", 0.0), ("low", -0.1), ("high", 0.1))
    }
    head = {"kind": "retrained", "source": "TAG-sim", "learned_order": None}
    retrained = replace(found, head=head, curves={**found.curves, **spread})
    curves = gap_curves(retrained, stage="f_hat", order=0.5)
    tops = dict(zip(MEASURES, (axes.range[1] for axes in curves.select_yaxes()), strict=True))
    assert tops["accuracy"] == 1
    every = [values for name, values in found.curves.items() if name.startswith("modality_gap/")]
    assert tops["modality_gap"] == pytest.approx(1.02 * max(map(max, every)))  # one axis for all
    text = svg_of(curves)
    assert "each stop is a head trained at that p" in text
    assert text.count("<polygon points=") == 1
    assert text.count('opacity="0.2"') == 1  # the span, and no band of a learned p
    assert text.count("<circle") >= 4 * stops
    assert "50.0 %" in text


def test_accuracy_that_the_frames_do_not_hold_is_said_to_be_missing(frames):
    found = read_frames(frames)
    kept = {name: curve for name, curve in found.curves.items() if "unseen" not in name}
    assert "not measured" in svg_of(gap_curves(replace(found, curves=kept), order=0.5))


def test_a_map_that_is_not_there_is_refused(framed, tmp_path):
    look = {"what": "map", "order": 0, "stage": "relu", "kind": "umap", "colour": "class"}
    with pytest.raises(SettingsError, match="There is no map 'umap/relu'"):
        export_picture(framed, framed.frames, tmp_path / "x.svg", **look)


def test_png_and_svg_show_the_same_shapes():
    red, blue = "#ff0000", "#0000ff"
    shapes = (
        Shape(kind="circle", points=((10, 10),), colour=red, size=5),
        Shape(kind="area", points=((20, 5), (30, 5), (30, 15), (20, 15)), colour=blue, opacity=0.4),
        Shape(kind="line", points=((0, 18), (40, 18)), colour=blue, size=2, dashed=True),
    )
    picture = Picture(width=40, height=20, shapes=shapes, title="a < b")
    image = png(picture)
    assert image.size == (80, 40)
    assert image.getpixel((20, 20)) == (255, 0, 0)
    assert image.getpixel((50, 20)) == (153, 153, 255)
    assert image.getpixel((70, 20)) == (255, 255, 255)
    dashes = [image.getpixel((x, 36))[0] < 128 for x in range(5, 80, 10)]
    assert dashes == 4 * [True, False]  # of five units
    text = svg(picture)
    assert "<title>a &lt; b</title>" in text
    assert '<polygon points="20.00,5.00 30.00,5.00 30.00,15.00 20.00,15.00"' in text
    assert text.count('stroke-dasharray="4 3"') == 1


def test_every_script_of_the_saved_page_is_inside_and_names_no_file():
    import base64

    found = scripts()
    assert {"omnivat-web/explore/explore.js", "omnivat-web/shared/store.js"} <= set(found)
    for name, address in found.items():
        text = base64.b64decode(address.partition("base64,")[2]).decode()
        assert '"./' not in text and '"../' not in text, name
        for wanted in re.findall(r'"(omnivat-web/[\w./]+)"', text):
            assert wanted in found, (name, wanted)


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


def test_the_command_writes_a_picture(frames, tmp_path, capsys):
    out = tmp_path / "map.png"
    assert main(["export", "--frames", str(frames), "--out", str(out), "--colour", "class"]) == 0
    with Image.open(out) as image:
        assert image.width == 1520
    assert "map written to" in capsys.readouterr().out


def test_the_command_refuses_an_ending_that_it_cannot_write(tmp_path, capsys):
    assert main(["export", "--what", "page", "--out", str(tmp_path / "x.png")]) == 1
    assert "for the page it ends in .html" in capsys.readouterr().err
