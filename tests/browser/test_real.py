"""The shelf of real pairs, beside a server that runs where a set was fetched."""

import csv

import numpy as np
import pytest
from PIL import Image

from omnivat.cli import main
from omnivat.data.store import load_embeddings
from omnivat.head.checkpoint import load_head
from omnivat.measure.known import at_home, measured
from omnivat.measure.rungs import NOTHING, labels, pairs

from .conftest import Server, watched
from .gestures import ANSWERED, SLOT, choose, holds

pytestmark = pytest.mark.browser

PRESSED = ".pair .real button[aria-pressed=true]"


@pytest.fixture
def opened(chromium, tmp_path, fetched):
    """Return a function that starts a server in the folder of a fetched set, with arguments, and
    gives an empty page; afterwards neither has failed.
    """
    servers = []
    problems = []

    def start(*more):
        servers.append(Server(tmp_path, more=more, where=fetched.parent))
        servers[0].start()
        page = watched(chromium.new_page(), servers[0].address, problems)
        page.address = servers[0].address
        return page

    yield start
    for server in servers:
        server.stop()
        assert "Traceback" not in server.log(), server.log()
    assert problems == []


@pytest.fixture
def two_sensors(tmp_path):
    """Return embeddings and a head of a set as it is fetched: two sensors, two classes, a split."""
    random, folder = np.random.default_rng(0), tmp_path / "pairs"
    folder.mkdir()
    columns = ("vis", "tac", "domain", "material", "object", "split")
    with (folder / "pairs.csv").open("w", newline="") as table:
        rows = csv.writer(table)
        rows.writerow(columns)
        for sensor, shade in (("GelSight", 60), ("DIGIT", 120)):
            for material, colour in (("steel", 0), ("wood", 2)):
                for k in range(8):
                    picture = random.integers(0, 60, (32, 32, 3), dtype=np.uint8)
                    picture[..., colour] += np.uint8(shade)
                    name = f"{sensor}-{material}-{k}"
                    Image.fromarray(picture).save(folder / f"{name}.png")
                    half = ("train", "test")[k % 2]
                    rows.writerow([f"{name}.png"] * 2 + [sensor, material, name, half])
    file, head = tmp_path / "set.safetensors", tmp_path / "head"
    assert main(["embed", str(folder), "--out", str(file)]) == 0
    learn = ["train", "--embeddings", str(file), "--source", "GelSight", "--out", str(head)]
    assert main([*learn, "--no-calibration", "--set", "width=16", "--set", "epochs=3"]) == 0
    return file, head


def test_a_real_pair_is_read_as_if_it_had_been_dropped_and_names_its_authors(opened, fetched):
    page = opened()
    away = fetched.rename(fetched.parent / ".away")
    page.goto(page.address + "?view=pair")
    page.wait_for_selector(".pair .real:has-text('python -m omnivat fetch touch-and-go')")
    away.rename(fetched)
    page.reload()
    page.wait_for_selector(".pair .real button:has-text('tree')")
    shown = page.inner_text(".pair .real")
    assert "Andrew Owens" in shown and "CC BY 4.0" in shown and "each still is cut" in shown
    page.click(".pair .real button:has-text('tree')")
    page.wait_for_selector(PRESSED)
    page.wait_for_selector(ANSWERED)
    for half in ("vis", "tac"):
        words = page.inner_text(f"{SLOT.format(half)} .what")
        assert words.startswith("tree, Touch and Go · 60 × 40") and "Fengyu Yang" in words
    clicked = [page.inner_text(f".pair .{part}") for part in ("verdict", "familiar")]
    page.goto(page.address + "?view=pair")
    page.wait_for_selector(ANSWERED)
    for half in ("vis", "tac"):
        choose(page, half, fetched / f"tree_{half}.png")
        holds(page, half, f"tree_{half}.png")
    page.wait_for_selector(ANSWERED)
    dropped = [page.inner_text(f".pair .{part}") for part in ("verdict", "familiar")]
    assert dropped == clicked and "guess" in dropped[0]


def test_two_real_sensors_open_chapter_two_with_home_away_pictures_and_labels(opened, two_sensors):
    file, head = two_sensors
    page = opened("--embeddings", str(file), "--head", str(head))
    page.goto(page.address + "?chapter=where")
    page.wait_for_selector(".explore .split.own .provenance:has-text('3 labelled pairs')")
    steps = ((NOTHING, True), (NOTHING, False), (pairs(8), False), (labels(3), False))
    loaded = load_head(head), load_embeddings(file)
    found = [(measured(*loaded, known, draws=3), home) for known, home in steps]
    wanted = [at_home(one) if home else one for one, home in found]
    shares = page.locator(".explore .split.own output").all_inner_texts()
    assert [one.replace("\xa0", " ") for one in shares] == [
        f"{int(100 * one['accuracy'] + 0.5)} %" for one in wanted
    ]
    words = page.inner_text(".explore .split.own .provenance")
    assert (
        "trained on GelSight and tested on 8 pairs of DIGIT. The model was given nothing from the"
        " new sensor, then 8 pairs without" in words
    )
    assert "the project’s simulated touches" in page.inner_text(".explore .lead")
