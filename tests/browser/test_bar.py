"""The bar of p stays in view: whoever reads further down can still drag it."""

from collections.abc import Callable
from typing import Any

import pytest

from .gestures import MAP

pytestmark = pytest.mark.browser

PROJECTOR = {"viewport": {"width": 1280, "height": 720}}
BAR_IN_VIEW = """() => {
  const { top, bottom } = document.querySelector('.explore .order-bar').getBoundingClientRect();
  return top >= 0 && bottom <= innerHeight;
}"""


def test_the_bar_of_p_stays_at_the_top_while_the_page_scrolls(
    open_page: Callable[..., Any],
) -> None:
    page = open_page(**PROJECTOR)
    page.wait_for_selector(MAP)
    page.evaluate("scrollTo(0, 500)")
    assert page.evaluate("scrollY") > 100
    assert page.evaluate(BAR_IN_VIEW)


def test_the_tour_shows_the_bar_where_it_wants_p_dragged(open_page: Callable[..., Any]) -> None:
    page = open_page(**PROJECTOR)
    page.wait_for_selector(".explore.ready")
    page.click(".tour-start")
    for _ in range(6):
        question = page.locator(".tour").inner_text()
        if "Drag p" in question:
            assert page.evaluate(BAR_IN_VIEW), question
        page.locator(".tour [data-option]").first.click()
        page.click(".tour .next")
