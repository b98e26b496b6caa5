"""Figures: every value is in the picture, bad input is one sentence, and no page names a host."""

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from omnivat import figures
from omnivat.figures.drawing import Picture, Shape, png
from omnivat.figures.maps import grouped
from omnivat.figures.page import POLICY, cell
from omnivat.figures.still import svg_of
from omnivat.figures.theme import CONFIG
from omnivat.kit.errors import DataError, SettingsError, ShapeError
from tests.golden.make_figures import FIGURES, FOLDER, frames


def some_map(columns=2, **more):
    places = np.random.default_rng(0).normal(size=(12, columns))
    return figures.map_figure(places, [0, 1, 2] * 2, ["a", "<b>", "c"], title="t", **more)


@pytest.mark.parametrize("name", FIGURES)
def test_the_still_picture_of_a_figure_is_the_one_that_was_looked_at(name):
    found = FIGURES[name]()
    assert svg_of(found) == (FOLDER / f"{name}.svg").read_text(encoding="utf-8")
    assert json.loads(found.to_json())["data"]


def test_a_png_shows_the_shapes():
    red, blue = "#ff0000", "#0000ff"
    shapes = (
        Shape(kind="circle", points=((10, 10),), colour=red, size=5),
        Shape(kind="area", points=((20, 5), (30, 5), (30, 15), (20, 15)), colour=blue, opacity=0.4),
        Shape(kind="line", points=((0, 18), (40, 18)), colour=blue, size=2, dashed=True),
        Shape(kind="line", points=((34, 3), (34, 11)), colour=blue, size=2, dashed=True),
    )
    picture = Picture(width=40, height=20, shapes=shapes, title="a < b")
    image = png(picture)
    assert image.size == (80, 40)
    assert image.getpixel((20, 20)) == (255, 0, 0)
    assert image.getpixel((50, 20)) == (153, 153, 255)
    assert image.getpixel((70, 20)) == (255, 255, 255)
    pixels = np.asarray(image)[..., 0] < 128
    across = 4 * (10 * [True] + 10 * [False])  # dashes and gaps of five units
    assert np.mean(pixels[36] == across) > 0.9
    assert np.flatnonzero(pixels[:30, 68]) == pytest.approx(range(6, 16), abs=1)


@pytest.mark.parametrize(
    ("stage", "order", "stated", "frame"),
    [("f_hat", 0.4, 0.0, 0), ("f_hat", 0.6, 1.0, 1), ("raw", 0.4, 0.5, 0)],
)
def test_a_map_states_its_own_order_and_one_of_every_order_the_stop_asked_for(
    stage, order, stated, frame
):
    found = figures.frames_map(frames(), order=order, stage=stage, colour="modality")
    assert found.layout.title.text.endswith(f", p = {stated:.2f}")
    photos, touches = (np.stack([trace.x, trace.y], 1) for trace in found.data)
    places = frames().maps[f"pca/{stage}"].places(frame)
    np.testing.assert_allclose(np.concatenate([photos, touches]), places, atol=1e-4)


def test_what_is_predicted_is_that_of_the_nearest_stop():
    found = figures.frames_map(frames(), order=0.7, stage="raw", colour="correctness")
    right, wrong = (trace.text for trace in found.data[:2])
    assert right == ("VIS · TAG · steel · predicted steel", "VIS · HCT · glass · predicted glass")
    assert wrong == ("VIS · TAG · wood · predicted felt",)


def test_bins_of_confidence_divide_what_lies_between_chance_and_certainty():
    levels = np.array([0, 64, 120, 255], np.uint8)
    four = replace(
        frames(), confidence=np.tile(levels[1:], (5, 1)), classes=("wood", "steel", "glass", "felt")
    )
    found = figures.frames_map(four, order=0.5, colour="confidence")
    edges = np.linspace(1 / 4, 1, 8)
    bins = np.digitize(levels[1:] / 255, edges[:-1]) - 1
    wanted = [f"≥ {100 * edges[k]:.0f} %" for k in bins]
    assert [trace.name for trace in found.data if trace.showlegend] == wanted


def test_no_figure_has_the_name_of_the_module_that_holds_it():
    modules = {file.stem for file in Path(figures.__file__).parent.glob("*.py")}
    # an import of the module would take the figure's place
    assert not modules & set(figures.__all__)


def test_a_page_holds_its_library_and_may_load_nothing_else(tmp_path):
    text = figures.html_page("one", [some_map(), "<p>words</p>", FIGURES["gaps"]()])
    assert f'content="{POLICY}"' in text and "default-src 'none'" in text
    assert not re.findall(r'(?:src|href)="[^"]', text)
    assert json.loads(re.search(r"config = (\{.*?\});", text)[1]) == CONFIG
    assert (CONFIG["showSendToCloud"], CONFIG["displaylogo"], CONFIG["plotlyServerURL"]) == (
        False,
        False,
        "",
    )
    assert text.count('class="plot"') == 2 and "<p>words</p>" in text
    assert "<title>t</title>" in figures.write(tmp_path / "t.html", some_map()).read_text("utf-8")


def test_a_cell_is_a_frame_that_cannot_reach_the_notebook():
    shown = some_map()._repr_mimebundle_()["text/html"]
    assert shown == cell(some_map())
    assert 'title="t"' in shown
    assert 'sandbox="allow-scripts allow-downloads"' in shown and "<script" not in shown


def test_of_more_values_than_colours_the_most_frequent_have_one_each_as_on_the_page():
    names, colours, group = grouped([*"abcdefghij", "j", "i"])  # as in tests/web/colours.test.js
    assert names == ["a", "b", "c", "d", "e", "i", "j", "3 other values"]
    assert len(colours) == len(names)
    assert group[[0, 9, 10, 5]].tolist() == [0, 6, 6, 7]


def test_pictures_travel_as_one_sheet_and_each_point_names_its_photo_and_touch(tmp_path):
    sheet = tmp_path / "s.webp"
    assert figures.pictures(sheet) is None
    sheet.write_bytes(b"RIFF")
    sheet.with_suffix(".json").write_text('{"tile": 64, "columns": 4, "count": 12}')
    tiles = figures.pictures(sheet)
    assert tiles == {"sheet": "data:image/webp;base64,UklGRg==", "columns": 4}
    found = some_map(pictures=tiles)
    assert found.layout.meta["pictures"] == tiles
    assert sorted(map(tuple, np.concatenate([t.customdata for t in found.data]))) == sorted(
        2 * [(i, i + 6) for i in range(6)]
    )


def test_bad_input_is_one_sentence(tmp_path):
    with pytest.raises(ShapeError, match=r"places has shape \(12, 4\)"):
        some_map(4)
    with pytest.raises(SettingsError, match="'f.gif' ends in '.gif'; choose .html, .svg"):
        figures.write(tmp_path / "f.gif", some_map())
    with pytest.raises(
        SettingsError, match="'scatter3d' has no SVG or PNG; name a file that ends in .html"
    ):
        figures.write(tmp_path / "f.svg", some_map(3))
    with pytest.raises(DataError, match="There is no value to draw for 'x'"):
        figures.dots([{"row": "a", "value": None}], title="x", across="y")
    assert not list(tmp_path.iterdir())
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        _ = figures.nothing


def test_a_dot_tells_its_value_interval_and_note_in_words():
    record = {"row": "a", "series": "b", "value": 0.6, "low": 0.5, "high": None, "note": "of 9"}
    found = figures.dots([record], title="t", across="", percent=True)
    assert found.data[0].text == ("a b: 60.0 % [50.0 %, 60.0 %] of 9",)


def test_the_curves_of_a_training_leave_out_what_is_not_measured_and_show_guessing():
    epochs = [{"loss": 2.0, "cross_entropy": 1.5, "order": 0.5}, {"loss": 1.0, "order": 0.51}]
    plain = figures.training_curves(epochs, total=40)
    assert [trace.name for trace in plain.data] == ["total", "cross-entropy", "p"]
    assert plain.layout.xaxis.range == (1, 40)
    more = [epochs[0], epochs[1] | {"accuracy/unseen": 0.3, "accuracy/source_test": float("nan")}]
    found = figures.training_curves(more, classes=5, columns=1)
    assert {trace.name: trace.mode for trace in found.data}["unseen domains"] == "markers"
    assert found.layout.shapes[0].y0 == 0.2
    words = [note.text for note in found.layout.annotations]
    assert words[1].startswith("<b>Accuracy</b>") and "30.0 %" in words[1]
    assert "source test</span> –" in words[1]
