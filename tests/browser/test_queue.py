"""Train here: two visitors, each with a browser profile of their own."""

import pytest

from .conftest import DESK
from .gestures import plan

pytestmark = pytest.mark.browser


def shows(page, words):
    """Wait until the state of the training contains these words."""
    page.wait_for_selector(f"#view-train .status:has-text('{words}')")


def test_a_second_visitor_waits_and_is_next_when_the_first_one_cancels(open_page):
    first, second = open_page("?view=train"), open_page("?view=train", **DESK)
    for page in (first, second):
        plan(page, 150)
    first.click("#view-train .go")
    shows(first, "Training: epoch")
    second.click("#view-train .go")
    shows(second, "place 1 in the queue")
    assert second.locator("#view-train .go").is_disabled()
    first.click("#view-train .stop")
    shows(second, "Training: epoch")
    second.click("#view-train .stop")
    shows(second, "Cancelled after")
    assert second.locator("#view-train .go").is_enabled()
