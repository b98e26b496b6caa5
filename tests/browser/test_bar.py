"""The control of a chapter and its chart are in view at once, and the thumb stands under its
value.
"""

import pytest

from .gestures import MAP, READY

pytestmark = pytest.mark.browser

LONG = pytest.mark.long
SIZES = [(1280, 720), pytest.param((1440, 900), marks=LONG), (1024, 768), (400, 800)]
OUTSIDE = """selectors => selectors.filter((one) => {
  const { top, bottom, height } = document.querySelector(`.explore ${one}`).getBoundingClientRect();
  return !height || top < 0 || bottom > innerHeight;
})"""

# true if the button to the next chapter hides a part of the sentence that replies to the title
COVERED = """() => {
  const [remark, onward] = ['.remark',
    '.onward'].map((one) => document.querySelector(`.explore .stage ${one}`));
  return remark.getBoundingClientRect().bottom > onward.getBoundingClientRect().top + 1;
}"""


LOW, READINGS = ([], [".order", ".together svg"]), ([], [".readings"])  # a phone shows them below


@pytest.mark.parametrize("size", SIZES, ids=str)
def test_map_chart_and_control_of_each_chapter_need_no_scrolling(open_page, size):
    page = open_page("?chapter=order", MAP, size=size)
    assert page.evaluate(OUTSIDE, [".map", ".over svg", ".order", ".stage .title"]) == []
    page.click('.explore .chapters [data-chapter="where"]')
    page.wait_for_selector(".explore .together path")
    assert (
        page.evaluate(OUTSIDE, [".threads", ".places", ".stage .title", *LOW[size[0] > 400]]) == []
    )
    assert size[0] == 400 or page.evaluate(COVERED) is False
    page.click('.explore .chapters [data-chapter="fooled"]')
    page.wait_for_selector(".explore .lookers .thumb:visible")
    assert (
        page.evaluate(
            OUTSIDE, [".stage .map", ".lookers", ".stage .title", *READINGS[size[0] > 400]]
        )
        == []
    )
    assert page.evaluate(COVERED) is False


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
