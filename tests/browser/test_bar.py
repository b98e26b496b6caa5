"""The slider's thumb stands under its value, and tabs are a bar of large targets on a phone."""

import pytest

from .gestures import MAP, READY

pytestmark = pytest.mark.browser


def test_the_thumb_of_the_slider_stands_under_its_value_on_the_curve(open_page):
    page = open_page("?chapter=order", MAP)
    for key in ("Home", "End"):
        page.focus(".explore .order")
        page.keyboard.press(key)
        off = page.evaluate(
            """key => {
              const box = (of) => document.querySelector(`.explore ${of}`).getBoundingClientRect();
              const [mark, track] = [box('.over circle.now'), box('.order')];
              const thumb = key === 'Home' ? track.left + 8 : track.right - 8;
              return Math.abs(mark.left + mark.width / 2 - thumb);
            }""",
            key,
        )
        assert off <= 2


def test_on_a_phone_the_tabs_are_one_row_of_large_targets_and_each_can_be_reached(open_page):
    page = open_page("", READY["explore"], size=(400, 800), has_touch=True)
    tabs = page.locator("[role=tablist]:visible [role=tab]")
    boxes = [tabs.nth(i).bounding_box() for i in range(tabs.count())]
    assert len(boxes) == 3
    assert len({box["y"] for box in boxes}) == 1
    assert min(min(box["height"], box["width"]) for box in boxes) >= 43.5
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    for i in range(3):
        tabs.nth(i).tap()
        page.wait_for_function(
            "i => document.querySelectorAll('[role=tab]:not(.visually-hidden"
            " *)')[i].getAttribute('aria-selected') === 'true'",
            arg=i,
        )
        box = tabs.nth(i).bounding_box()
        assert box["x"] >= 0 and box["x"] + box["width"] <= 400
