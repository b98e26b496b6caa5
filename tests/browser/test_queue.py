"""Train here: four visitors, each with a browser profile of their own."""

import pytest

from .conftest import DESK

pytestmark = pytest.mark.browser


def press_train(page):
    """Start a long training."""
    page.wait_for_selector(".train .go")
    page.click(".train .choices details summary")
    page.select_option(".train [name=width]", "16")
    page.uncheck(".train [name=lang]")
    page.fill(".train [name=epochs]", "100")
    page.click(".train .go")


def shows(page, words):
    """Wait until the state of the training contains these words."""
    page.wait_for_selector(f".train .status:has-text('{words}')")


def test_four_visitors_see_their_places_and_cancelling_frees_one(open_page):
    pages = [open_page("?view=train", **DESK) for _ in range(4)]
    for number, page in enumerate(pages):
        press_train(page)
        shows(page, f"place {number} in the queue" if number else "Training: epoch")
    pages[1].click(".train .stop")
    shows(pages[1], "Cancelled")
    shows(pages[2], "place 1")
    shows(pages[3], "place 2")
    pages[3].reload()  # a visitor who reloads keeps the place and can give it up
    shows(pages[3], "place 2")
    pages[3].click(".train .go")
    pages[3].wait_for_selector(".train .problem:has-text('cancel it first')")
    pages[3].click(".train .stop")
    shows(pages[3], "Cancelled")
    pages[0].click(".train .stop")
    shows(pages[2], "Training: epoch")
    pages[2].click(".train .stop")
    shows(pages[2], "Cancelled after")
    assert pages[2].locator(".train .go").is_enabled()
