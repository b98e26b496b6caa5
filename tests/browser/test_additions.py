"""Additions of docs/extend.md, made in a temporary plug-in, are found on the screen."""

import json
import re
from dataclasses import replace
from pathlib import Path
from urllib.parse import quote

import pytest

from omnivat.data.domains import DOMAINS
from omnivat.data.store import load_embeddings
from omnivat.head.heads import EXAMPLES, default_embeddings
from omnivat.maps.frames import read_frames, write_frames

from .conftest import ROOT, Server, watched
from .gestures import go, open_tab, pixels, settle, texture

pytestmark = pytest.mark.browser
PAGE = (ROOT / "docs" / "extend.md").read_text(encoding="utf-8")
PLUG_IN = """
import json, sys
from pathlib import Path
from omnivat.measure import rungs
RUNGS, rungs.DRAWS = rungs.RUNGS, 2  # before what takes them is imported
# others take long to measure
RUNGS[:] = [row for row in RUNGS if row.get("pairs", 0) in (0, 20) and not row.get("labels")]
from app.serving.server import main
from app.shared.tables import tables
from omnivat.measure.gaps import GAPS, NAMES

folder = Path(__file__).parent
for kind, row in json.loads((folder / "rows.json").read_text()).items():
    (RUNGS if kind == "RUNGS" else tables()[kind]).append(row)
GAPS["medians"], NAMES["medians"] = "medians:median_gap", "distance of medians"
raise SystemExit(main())
"""


def row(kind):
    """Return the row that the page of additions shows for a kind of table."""
    found = re.search(rf"row in `{kind}`.*?```json\n(.*?)```", PAGE, re.DOTALL)
    assert found, f"docs/extend.md shows no row of {kind}"
    return dict(json.loads(found[1]))


@pytest.fixture(scope="module")
def rows(tmp_path_factory):
    """Return the folder of the plug-in, and its rows: a mode with its frames, a colour, a rung.

    Curves of the frames are those that `build_frames` makes: none are over several trainings.
    """
    folder = tmp_path_factory.mktemp("plug_in")
    made = {kind: row(kind) for kind in ("modes", "colours", "RUNGS")}
    frames = read_frames(EXAMPLES / "retrained.bin")
    curves = {name: curve for name, curve in frames.curves.items() if not name.startswith("seeds:")}
    curves["medians/f_hat"] = [0.25] * len(frames.orders)
    head = {**frames.head, "kind": made["modes"]["id"], "seeds": []}
    made["modes"]["file"] = str(folder / made["modes"]["file"])
    write_frames(made["modes"]["file"], replace(frames, head=head, curves=curves))
    (folder / "rows.json").write_text(json.dumps(made), encoding="utf-8")
    (folder / "plug_in.py").write_text(PLUG_IN, encoding="utf-8")
    return folder, made


@pytest.fixture(scope="module")
def page(chromium, rows):
    """Return the page of a server with the plug-in."""
    folder, _ = rows
    problems = []
    server = Server(folder)
    server.script = folder / "plug_in.py"
    page = watched(chromium.new_page(), server.address, problems)
    try:
        server.start()
        page.goto(server.address + "?chapter=analyse", wait_until="commit")
        page.wait_for_selector(".explore .score .provenance")
        settle(page)
        yield page
    finally:
        page.close()
        server.stop()
    assert problems == []


def test_a_mode_has_its_words_its_accuracy_and_the_gap_of_its_frames(page, rows):
    mode = rows[1]["modes"]
    frames = read_frames(mode["file"])
    page.click(f".explore .modes button:has-text('{mode['title']}')")
    page.wait_for_selector(f".explore[data-kind='{mode['id']}']")
    line = page.inner_text(".explore .score .provenance")
    assert line.startswith("Measured with " + mode["who"].partition("{")[0].strip())
    stop = float(page.get_attribute(".explore .map", "data-order"))
    right = frames.curves["accuracy/unseen"][frames.orders.index(stop)]
    assert page.inner_text(".explore .score b.large").split() == [f"{100 * right:.0f}", "%"]
    words = mode["lead"] + mode["words"].replace("{source}", DOMAINS["TAG"].title)
    assert page.text_content(".explore .mode-words") == words
    page.select_option(".explore .of-steps", label="Distance of medians")
    stair = page.locator(".explore .stair[data-name=medians] output.open")
    assert stair.inner_text() == "0.25"


def test_with_one_domain_left_a_gap_is_that_of_all_domains_and_says_so(page, rows):
    mode = rows[1]["modes"]["id"]
    hidden = "~".join(read_frames(rows[1]["modes"]["file"]).domains[1:])
    go(page, f"?chapter=analyse&mode={mode}&domain={quote(hidden)}")
    page.wait_for_selector(f".explore[data-kind='{mode}']")
    chart = page.locator(".explore figure[data-name=medians]")
    chart.wait_for(state="attached")
    assert chart.locator(".of").text_content() == "all domains"
    assert chart.locator("output").text_content() == "0.250"


def test_a_colour_of_a_column_paints_the_map_names_its_values_and_is_saved(page, rows):
    row = rows[1]["colours"]
    values = {
        value or "none" for value in load_embeddings(default_embeddings()).rows[row["column"]]
    }
    address = "?chapter=analyse&mode=moved&stage=projection"
    go(page, address)
    page.wait_for_selector(f".explore .colouring option[value={row['id']}]", state="attached")
    settle(page)
    before = pixels(page)
    page.select_option(".explore .colouring", label=row["title"])
    settle(page)
    assert pixels(page) != before
    go(page, f"{address}&colour={row['id']}")
    legend = page.locator(".explore .filters .legend .key")
    legend.first.wait_for(state="attached")
    assert set(legend.all_text_contents()) == values
    page.click(".explore .save summary")
    with page.expect_download() as saved:
        page.click(".explore .save [data-save=figure]")
    text = Path(saved.value.path()).read_text(encoding="utf-8")
    assert all(f'"name":"{value}"' in text for value in values)


def test_a_rung_is_named_with_its_gain_in_the_line_of_own_pictures(page, rows):
    open_tab(page, "pair")
    page.wait_for_selector(".pair .slots input[type=file]", state="attached")
    page.set_input_files(".pair .slots input[type=file] >> nth=0", texture(1))
    page.click(".pair .reader-switch")  # the rungs are those of the head of the chapters
    gain = page.locator(f".pair .line:has-text('{rows[1]['RUNGS']['words']} raise')")
    gain.wait_for()  # the ladder is climbed again, as its file lacks the rung
    gains = re.findall(r"(\d+ pairs) .*? raise accuracy by (-?\d+\.\d) points", gain.inner_text())
    few, many = (float(dict(gains)[f"{count} pairs"]) for count in (3, 20))
    assert 0 < few < many
