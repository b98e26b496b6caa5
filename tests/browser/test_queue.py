"""Train here: three visitors, each with a browser profile of their own."""

import pytest

from .conftest import DESK
from .gestures import train

pytestmark = pytest.mark.browser


def shows(page, words):
    """Wait until the state of the training contains these words."""
    page.wait_for_selector(f"#view-train .status:has-text('{words}')")


def test_three_visitors_see_their_places_and_cancelling_frees_one(open_page):
    pages = [open_page("?view=train", **DESK) for _ in range(3)]
    for number, page in enumerate(pages):
        train(page, 100, lang=False)
        shows(page, f"place {number} in the queue" if number else "Training: epoch")
    pages[1].click("#view-train .stop")
    shows(pages[1], "Cancelled")
    shows(pages[2], "place 1")
    pages[2].reload()  # a visitor who reloads keeps the place
    shows(pages[2], "place 1")
    assert pages[2].locator("#view-train .go").is_disabled()
    pages[0].click("#view-train .stop")
    shows(pages[2], "Training: epoch")
    pages[2].click("#view-train .stop")
    shows(pages[2], "Cancelled after")
    assert pages[2].locator("#view-train .go").is_enabled()
