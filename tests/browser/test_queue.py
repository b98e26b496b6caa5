"""Train here: two visitors, each with a browser profile of their own."""

import pytest

from .conftest import DESK
from .gestures import train

pytestmark = pytest.mark.browser


def shows(page, words):
    """Wait until the state of the training contains these words."""
    page.wait_for_selector(f"#view-train .status:has-text('{words}')")


def test_a_second_visitor_waits_keeps_the_place_through_a_reload_and_is_next_when_one_cancels(
    open_page,
):
    first, second = open_page("?view=train"), open_page("?view=train", **DESK)
    train(first, 150, lang=False)
    shows(first, "Training: epoch")
    train(second, 150, lang=False)
    shows(second, "place 1 in the queue")
    second.reload()
    shows(second, "place 1")
    assert second.locator("#view-train .go").is_disabled()
    first.click("#view-train .stop")
    shows(first, "Cancelled after")
    assert first.locator("#view-train .go").is_enabled()
    shows(second, "Training: epoch")
    second.click("#view-train .stop")
    shows(second, "Cancelled")
