"""Pictures and the page as one file, made without a browser."""

import re
from dataclasses import replace
from pathlib import Path

import pytest
from PIL import Image

from app import pictures
from app.components import WEB
from app.drawing import Picture, Shape, png, svg, write_picture
from app.export import export_page, export_picture, frames_file, modules
from omnivat.cli import main
from omnivat.errors import SettingsError


@pytest.fixture(scope="module")
def frames(small_places, tmp_path_factory) -> Path:
    """Return the frames of the small head, computed once."""
    return frames_file(replace(small_places, computed=tmp_path_factory.mktemp("frames")))


def test_colours_are_those_of_the_page():
    text = (WEB / "palette.js").read_text(encoding="utf-8")
    for name, colours in (("OKABE_ITO", pictures.DOMAINS), ("TOL_BRIGHT", pictures.CLASSES)):
        listed = re.search(rf"const {name} = \[(.*?)\]", text, re.S)
        assert listed
        assert re.findall(r"#\w{6}", listed[1]) == colours


@pytest.mark.parametrize("colour", pictures.COLOURS)
def test_the_map_holds_every_point_and_says_simulated(frames, tmp_path, colour):
    out = tmp_path / "map.svg"
    export_picture(frames, out, what="map", order=0.5, stage="f_hat", kind="pca", colour=colour)
    text = out.read_text(encoding="utf-8")
    assert text.count("<circle") == text.count("<polygon") == 80
    assert "simulated data" in text


def test_the_curves_say_what_is_a_what_if(frames, tmp_path):
    out = tmp_path / "curves.svg"
    export_picture(
        frames, out, what="curves", order=None, stage="relu", kind="pca", colour="domain"
    )
    text = out.read_text(encoding="utf-8")
    assert "what-if" in text
    assert text.count("<polyline") >= 4


def test_a_map_that_is_not_there_is_refused(frames, tmp_path):
    with pytest.raises(SettingsError, match="There is no map 'umap/relu'"):
        export_picture(
            frames,
            tmp_path / "x.svg",
            what="map",
            order=0,
            stage="relu",
            kind="umap",
            colour="class",
        )


def test_png_and_svg_show_the_same_shapes(tmp_path):
    shapes = (Shape(kind="circle", points=((10, 10),), fill="#ff0000", size=5),)
    picture = Picture(width=40, height=20, shapes=shapes, title="a < b")
    image = png(picture)
    assert image.size == (80, 40)
    assert image.getpixel((20, 20)) == (255, 0, 0)
    assert image.getpixel((70, 20)) == (255, 255, 255)
    assert "<title>a &lt; b</title>" in svg(picture)
    write_picture(tmp_path / "p.png", picture)
    with Image.open(tmp_path / "p.png") as kept:
        assert kept.size == (80, 40)
    with pytest.raises(SettingsError, match="choose .svg or .png"):
        write_picture(tmp_path / "p.gif", picture)


def test_every_script_of_the_saved_page_is_inside_and_names_no_file():
    import base64

    found = modules()
    assert {"omnivat-web/explore.js", "omnivat-web/store.js"} <= set(found)
    for name, address in found.items():
        text = base64.b64decode(address.partition("base64,")[2]).decode()
        assert '"./' not in text, name
        for wanted in re.findall(r'"(omnivat-web/[\w.]+)"', text):
            assert wanted in found, (name, wanted)


def test_the_saved_page_asks_nothing_of_outside_and_holds_its_frames(
    small_places, frames, tmp_path
):
    out = tmp_path / "page.html"
    export_page(small_places, frames, out)
    text = out.read_text(encoding="utf-8")
    assert not re.search(r'(src|href)="(?!data:)', text)
    assert "https://" not in text
    assert "data:application/octet-stream;base64,T1ZGUkFNRVM" in text  # OVFRAMES
    assert "simulated" in text


def test_the_command_writes_a_picture(frames, tmp_path, capsys):
    out = tmp_path / "map.png"
    assert main(["export", "--frames", str(frames), "--out", str(out), "--colour", "class"]) == 0
    with Image.open(out) as image:
        assert image.width == 1440
    assert "map written to" in capsys.readouterr().out


def test_the_command_refuses_an_ending_that_it_cannot_write(tmp_path, capsys):
    assert main(["export", "--what", "page", "--out", str(tmp_path / "x.png")]) == 1
    assert "for the page it ends in .html" in capsys.readouterr().err
