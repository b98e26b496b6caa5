"""The shelf of real pairs, beside a server that runs where a set was fetched."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from .conftest import Server, watched
from .gestures import ANSWERED

pytestmark = pytest.mark.browser

SLOT = '.pair .slot[data-modality="{}"]'
PRESSED = ".pair .real button[aria-pressed=true]"


@pytest.fixture
def page(chromium: Any, tmp_path: Path, fetched: Path) -> Iterator[Any]:
    """Return the page of a server in the folder of a fetched set; neither fails."""
    server, problems = Server(tmp_path, where=fetched.parent), []
    server.start()
    page = watched(chromium.new_page(), server.address, problems)
    page.address = server.address
    yield page
    page.close()
    server.stop()
    assert problems == [] and "Traceback" not in server.log(), (problems, server.log())


def test_a_real_pair_is_read_as_if_it_had_been_dropped_and_names_its_authors(
    page: Any, fetched: Path
) -> None:
    away = fetched.rename(fetched.parent / ".away")
    page.goto(page.address + "?view=pair")
    page.wait_for_selector(".pair .real:has-text('python -m omnivat fetch touch-and-go')")
    away.rename(fetched)
    page.reload()
    page.wait_for_selector(".pair .real button:has-text('tree')")
    shown = page.locator(".pair .real").inner_text()
    assert "Andrew Owens" in shown and "CC BY 4.0" in shown and "each still is cut" in shown
    page.click(".pair .real button:has-text('tree')")
    page.wait_for_selector(PRESSED)
    page.wait_for_selector(ANSWERED)
    for half in ("vis", "tac"):
        words = page.locator(f"{SLOT.format(half)} .what").inner_text()
        assert words.startswith("tree, Touch and Go · 60 × 40") and "Fengyu Yang" in words
    clicked = [page.locator(f".pair .{part}").inner_text() for part in ("verdict", "familiar")]
    page.goto(page.address + "?view=pair")
    page.wait_for_selector(ANSWERED)
    for half in ("vis", "tac"):
        page.set_input_files(f"{SLOT.format(half)} input[type=file]", fetched / f"tree_{half}.png")
        page.wait_for_selector(f"{SLOT.format(half)} .what:has-text('tree_{half}.png')")
    page.wait_for_selector(ANSWERED)
    dropped = [page.locator(f".pair .{part}").inner_text() for part in ("verdict", "familiar")]
    assert dropped == clicked and "guess" in dropped[0]
