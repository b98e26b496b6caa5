"""Figures: every value is in the picture, bad input is one sentence, and no page names a host."""

import json
import math
import re
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import plotly.graph_objects as go
import pytest

from omnivat import figures
from omnivat.figures.drawing import GRID, INK
from omnivat.figures.maps import grouped
from omnivat.figures.page import POLICY, cell
from omnivat.figures.still import svg_of
from omnivat.figures.theme import CONFIG, THEMES
from omnivat.kit.errors import DataError, SettingsError, ShapeError

SVG = "{http://www.w3.org/2000/svg}"
FULL = THEMES["omnivat"]["full"]


def some_map(columns=2, **more):
    places = np.random.default_rng(0).normal(size=(12, columns))
    return figures.map_figure(places, [0, 1, 2] * 2, ["a", "<b>", "c"], title="t", **more)


def table():
    apart = {"A": {"A": 0.0, "B": 0.2}, "B": {"A": 0.2, "B": 0.0}}
    return {
        "measure": "centroid",
        "stage": "raw",
        "pairs": 8,
        "modality_gap": {"all": 0.5},
        "floor": {"vis": 0.1, "tac": None},
        "domain_gap": {"vis": apart, "tac": apart},
    }


RUNG = {"known": "nothing", "n": 0, "accuracy": 0.5, "low": 0.4, "high": 0.6, "method": "m"}
EVERY = {
    "map": some_map,
    "lines": lambda: figures.lines({"a": ([0, 1], [1, math.nan], [0.1, math.nan])}, title="t"),
    "ladder": lambda: figures.ladder([RUNG]),
    "gaps": lambda: figures.gap_tables(table()),
}


@pytest.mark.parametrize("name", EVERY)
def test_every_figure_is_plotlys_and_has_a_still_picture_of_valid_svg(name, tmp_path):
    found = EVERY[name]()
    assert isinstance(found, go.Figure)
    root = ElementTree.fromstring(svg_of(found))
    assert root.find(f"{SVG}title").text
    assert json.loads(found.to_json())["data"]
    figures.write(tmp_path / "f.png", found)
    assert (tmp_path / "f.png").stat().st_size > 1000


def test_no_figure_has_the_name_of_the_module_that_holds_it():
    modules = {file.stem for file in Path(figures.__file__).parent.glob("*.py")}
    # an import of the module would take the figure's place
    assert not modules & set(figures.__all__)


def test_a_map_has_a_mark_for_every_point_and_one_name_a_group():
    root = ElementTree.fromstring(svg_of(some_map()))
    tags = [element.tag.removeprefix(SVG) for element in root.iter()]
    assert (tags.count("circle"), tags.count("polygon")) == (6, 6)
    texts = [element.text for element in root.iter(f"{SVG}text")]
    assert [t for t in texts if t in ("a", "<b>", "c", "&lt;b&gt;")] == ["a", "<b>", "c"]
    assert "Circle: photo (VIS); triangle: touch (TAC)." in texts


def test_higher_values_are_higher_and_bars_reach_as_far_as_their_error():
    found = figures.lines({"s": ([0, 2], [50, 60], [2, 0])}, title="p & q")
    assert found.layout.xaxis.range == pytest.approx((-0.06, 2.06))
    root = ElementTree.fromstring(svg_of(found))
    low, high = (float(e.get("cy")) for e in root.iter(f"{SVG}circle"))
    assert high < low
    unit = (low - high) / 10
    ends = [
        e.get("points").split() for e in root.iter(f"{SVG}polyline") if e.get("stroke") == "#3b82f6"
    ]
    bar = next(e for e in ends if len({point.split(",")[0] for point in e}) == 1)
    y = sorted(float(point.split(",")[1]) for point in bar)
    assert y == pytest.approx([low - 2 * unit, low + 2 * unit], abs=0.05)


def test_ticks_and_grid_lines_stand_at_their_values():
    found = figures.lines({"s": ([0, 1, 2], [50, 55, 60])}, title="t")
    root = ElementTree.fromstring(svg_of(found))
    labels = {text.text: text for text in root.iter(f"{SVG}text")}
    marks = [[float(c.get(axis)) for axis in ("cx", "cy")] for c in root.iter(f"{SVG}circle")]
    for k, (x, y) in enumerate(marks):
        assert float(labels[str(k)].get("x")) == pytest.approx(x, abs=0.01)
        assert float(labels[str(50 + 5 * k)].get("y")) == pytest.approx(y + 4, abs=0.01)
    grid = [e.get("points") for e in root.iter(f"{SVG}polyline") if e.get("stroke") == GRID]
    heights = [float(end.split(",")[1]) for line in grid for end in line.split()]
    assert heights == pytest.approx([y for _, y in marks for _ in range(2)], abs=0.01)


def test_a_cell_of_a_table_is_as_dark_as_its_share_of_the_largest_gap():
    record = table()
    record["domain_gap"] = {"tac": {"A": {"A": 0.0, "B": 0.4}, "B": {"A": 0.1, "B": 0.0}}}
    root = ElementTree.fromstring(svg_of(figures.gap_tables(record)))
    fills = [e.get("opacity") for e in root.iter(f"{SVG}rect") if e.get("fill") == FULL]
    assert fills == [None, "0.25"]
    words = {e.text: e.get("fill") for e in root.iter(f"{SVG}text")}
    assert (words["0.400"], words["0.100"]) == ("#ffffff", INK)


def test_a_page_holds_its_library_and_may_load_nothing_else():
    text = figures.html_page("one", [some_map(), "<p>words</p>", EVERY["gaps"]()])
    assert f'content="{POLICY}"' in text and "default-src 'none'" in text
    assert not re.findall(r'(?:src|href)="[^"]', text)
    assert json.loads(re.search(r"config = (\{.*?\});", text)[1]) == CONFIG
    assert (CONFIG["showSendToCloud"], CONFIG["displaylogo"], CONFIG["plotlyServerURL"]) == (
        False,
        False,
        "",
    )
    assert text.count('class="plot"') == 2 and "<p>words</p>" in text


def test_a_cell_is_a_frame_that_cannot_reach_the_notebook():
    shown = some_map()._repr_mimebundle_()["text/html"]
    assert shown == cell(some_map())
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


def test_the_cells_of_a_table_of_gaps_fill_its_axes_from_the_top():
    layout = EVERY["gaps"]().layout
    for across, down in ((layout.xaxis, layout.yaxis), (layout.xaxis2, layout.yaxis2)):
        assert (across.range, down.range) == ((-0.5, 1.5), (1.5, -0.5))


def test_strangers_have_a_row_for_each_domain_and_the_mean(head_folder):
    from omnivat.data.store import load_embeddings
    from omnivat.head.checkpoint import load_head
    from omnivat.measure.unseen import unseen_summary

    head, pairs = load_head(head_folder), load_embeddings(head_folder.parent / "set.safetensors")
    summary = unseen_summary(head, pairs)
    found = figures.strangers(summary)
    assert list(found.layout.yaxis.ticktext)[-1] == "mean of unseen"
    both = next(t for t in found.data if t.name == "both images")
    assert both.x[-1] == pytest.approx(summary["unseen"]["answers/fused"]["share"])
    assert all(
        x - low >= 0 and x + high <= 1
        for x, low, high in zip(both.x, both.error_x.arrayminus, both.error_x.array, strict=True)
    )
