"""The control of a chapter and its chart are in view at once, and the thumb stands under its value."""

from collections.abc import Callable
from typing import Any

import pytest

from .gestures import MAP

pytestmark = pytest.mark.browser

LONG = pytest.mark.long
SIZES = [(1280, 720), pytest.param((1440, 900), marks=LONG), (1024, 768), (400, 800)]
OUTSIDE = """selectors => selectors.filter((one) => {
  const { top, bottom, height } = document.querySelector(`.explore ${one}`).getBoundingClientRect();
  return !height || top < 0 || bottom > innerHeight;
})"""


@pytest.mark.parametrize("size", SIZES, ids=str)
def test_map_chart_and_control_of_each_chapter_need_no_scrolling(
    open_page: Callable[..., Any], size: tuple[int, int]
) -> None:
    page = open_page("?chapter=order", viewport=dict(zip(("width", "height"), size, strict=True)))
    page.wait_for_selector(MAP)
    assert page.evaluate(OUTSIDE, [".map", ".over svg", ".order", ".title"]) == []
    page.click('.explore [data-chapter="failure"]')
    page.wait_for_selector(".explore .fall[data-rung=m2]")  # the whole ladder
    page.wait_for_selector(".explore .profiles button")
    assert page.evaluate(OUTSIDE, [".map", ".waterfall", ".title"]) == []
    page.click('.explore [data-chapter="fooled"]')
    page.wait_for_selector(".explore .bar-row:visible")
    assert page.evaluate(OUTSIDE, [".map", ".readings", ".title"]) == []


def test_the_thumb_of_the_slider_stands_under_its_value_on_the_curve(open_page: Callable[..., Any]) -> None:
    page = open_page("?chapter=order")
    page.wait_for_selector(MAP)
    for key in ("Home", "End"):
        page.focus(".explore .order")
        page.keyboard.press(key)
        off = page.evaluate(
            """key => {
              const mark = document.querySelector('.explore .over circle.now').getBoundingClientRect();
              const track = document.querySelector('.explore .order').getBoundingClientRect();
              const thumb = key === 'Home' ? track.left + 8 : track.right - 8;
              return Math.abs(mark.left + mark.width / 2 - thumb);
            }""",
            key,
        )
        assert off <= 2
