"""The shelf of real pairs, beside a server that runs where a set was fetched."""

from dataclasses import replace
from shutil import rmtree

import pytest

from omnivat.cli import main
from omnivat.data.store import load_embeddings, save_embeddings
from omnivat.head.checkpoint import load_head
from omnivat.measure.known import at_home, measured
from omnivat.measure.rungs import NOTHING, labels, pairs

from .gestures import ANSWERED, SLOT, choose, holds

pytestmark = pytest.mark.browser

TWO = {"domains": ("GelSight", "DIGIT"), "classes": ("steel", "wood"), "split": True}
PRESSED = ".pair .real button[aria-pressed=true]"


def test_a_real_pair_is_read_as_if_it_had_been_dropped_and_names_its_authors(
    open_page, server, fetched
):
    here = fetched.rename(server.folder / fetched.name)  # where the server runs
    try:
        page = open_page("?view=pair", ".pair .real button:has-text('tree')")
        shown = page.inner_text(".pair .real")
        assert "Andrew Owens" in shown and "CC BY 4.0" in shown and "each still is cut" in shown
        page.click(".pair .real button:has-text('tree')")
        page.wait_for_selector(PRESSED)
        page.wait_for_selector(ANSWERED)
        for half in ("vis", "tac"):
            words = page.inner_text(f"{SLOT.format(half)} .what")
            assert words.startswith("tree, Touch and Go · 60\xa0×\xa040") and "Fengyu Yang" in words
        clicked = [page.inner_text(f".pair .{part}") for part in ("verdict", "familiar")]
        page.goto(server.address + "?view=pair")
        page.wait_for_selector(ANSWERED)
        for half in ("vis", "tac"):
            choose(page, half, here / f"tree_{half}.png")
            holds(page, half, f"tree_{half}.png")
        page.wait_for_selector(ANSWERED)
        dropped = [page.inner_text(f".pair .{part}") for part in ("verdict", "familiar")]
        assert dropped == clicked and "guess" in dropped[0]
    finally:
        rmtree(here)


def test_two_real_sensors_open_chapter_two_with_home_away_pictures_and_labels(
    open_page, loaded, tmp_path, make_embeddings
):
    """Of a set as it is fetched: two sensors and a split."""
    file, head = tmp_path / "embeddings.safetensors", tmp_path / "head"
    made = make_embeddings(**TWO)
    save_embeddings(file, replace(made, header=replace(made.header, simulated=False)))
    learn = ["train", "--embeddings", str(file), "--source", "GelSight", "--out", str(head)]
    assert main([*learn, "--no-calibration", "--set", "width=16", "--set", "epochs=3"]) == 0
    parts = ("weights.safetensors", "settings.json", "profile.safetensors")
    name = loaded(file, *(head / part for part in parts))
    page = open_page(f"?set={name}&chapter=where")
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
    page.wait_for_selector(".top .badge:has-text('simulated data')")
    page.click(".explore [data-chapter=analyse]")
    page.wait_for_selector(".top .badge:has-text('real pairs')")
    page.click(".explore [data-chapter=where]")
    page.wait_for_selector(".top .badge:has-text('simulated data')")
