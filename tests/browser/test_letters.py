"""At every width letters can be read, no title is cut, and tabs are large; the slider's thumb."""

import pytest

from app.shared.components import VIEWS

from .conftest import DESK
from .gestures import MAP, MOVED, READY, go, open_tab, settle

pytestmark = pytest.mark.browser

PAIR = "?vis=row:0&tac=row:0"
SMALL = """() => [...document.querySelectorAll('.ov svg text')]
  .filter((text) => text.checkVisibility() && text.getBoundingClientRect().width)
  .map((text) => [parseFloat(getComputedStyle(text).fontSize) * text.getScreenCTM().a,
    text.textContent])
  .filter(([size]) => size < 10)"""
# A caption for screen readers alone is one pixel wide.
CUT = """() => [...document.querySelectorAll('.ov .map-title .where-at, .ov h3, .ov figcaption')]
  .filter((one) => one.checkVisibility() && one.clientWidth > 1
    && one.scrollWidth > one.clientWidth + 1)
  .map((one) => one.textContent)"""


WIDE = """wide => [...document.querySelectorAll('.ov *')].filter((e) => e.getClientRects().length
  && e.getBoundingClientRect().right > wide + 1
  && !e.closest('.gallery, .scroll, .chapters, pre, .sr, svg, .thumb'))
  .map((e) => e.outerHTML.slice(0, 90))"""


@pytest.fixture
def sized(visited):
    """Return a function that gives the page of the file another size, until the test ends."""

    def sized(width, height):
        visited.set_viewport_size({"width": width, "height": height})
        settle(visited)

    yield sized
    sized(*DESK["viewport"].values())


def test_no_letter_is_too_small_no_title_is_cut_and_nothing_needs_scrolling_sideways(visit, sized):
    page = visit(PAIR, READY["explore"])
    sized(400, 800)  # a phone
    assert page.evaluate(SMALL) == page.evaluate(CUT) == []
    go(page, f"{PAIR}&pin=3")  # the workbench
    for view in VIEWS:
        open_tab(page, view)
        page.wait_for_selector(READY[view])
        for wide in (400, 720, 1024):
            sized(wide, 800)
            assert page.evaluate(SMALL) == page.evaluate(CUT) == [], (view, wide)
            assert page.evaluate(WIDE, wide) == [], (view, wide)
            assert page.evaluate("document.scrollingElement.scrollWidth") <= wide, (view, wide)
        sized(400, 800)


def test_on_a_projector_letters_of_charts_are_large_enough_and_nothing_is_cut_even_in_a_lecture(
    visit, sized
):
    page = visit(MOVED, MAP)
    sized(1280, 720)
    small = page.evaluate(
        """() => [...document.querySelectorAll('.explore svg text')]
          .filter((t) => t.checkVisibility())
          .map((t) => parseFloat(getComputedStyle(t).fontSize) * t.ownerSVGElement.getScreenCTM().a)
          .filter((size) => size < 11.4)"""
    )
    assert small == []
    cut = page.evaluate(
        """() => {
          const right = (of) => of.getBoundingClientRect().right;
          return [...document.querySelectorAll('.explore .filters .source')]
            .filter((mark) => right(mark) > right(mark.parentElement) + 1);
        }"""
    )
    assert cut == []
    go(page, f"{MOVED}&beside=1")
    over = "(({ scrollWidth, clientWidth }) => scrollWidth - clientWidth)"
    assert page.evaluate(f"{over}(document.querySelector('.side'))") <= 0
    page.keyboard.press("f")
    page.wait_for_selector("body.lecturing")
    cut = """() => {
      const left = (of) => of.getBoundingClientRect().left;
      return [...document.querySelectorAll('.explore .over text')].filter((text) =>
        text.checkVisibility() && left(text) < left(document.querySelector('.side')))
        .map((text) => text.textContent);
    }"""
    assert page.evaluate(cut) == []
    page.keyboard.press("f")


def test_the_thumb_of_the_slider_stands_under_its_value_on_the_curve(visit):
    page = visit("?chapter=order", MAP)
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


def test_on_a_phone_the_tabs_are_one_row_of_large_targets_and_each_can_be_reached(visit, sized):
    page = visit("", READY["explore"])
    sized(400, 800)
    tabs = page.locator("[role=tablist]:visible [role=tab]")
    boxes = [tabs.nth(i).bounding_box() for i in range(tabs.count())]
    assert len(boxes) == 3
    assert len({box["y"] for box in boxes}) == 1
    assert min(min(box["height"], box["width"]) for box in boxes) >= 43.5
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    for i in range(3):
        tabs.nth(i).click()
        page.wait_for_function(
            "i => document.querySelectorAll('[role=tab]:not(.visually-hidden"
            " *)')[i].getAttribute('aria-selected') === 'true'",
            arg=i,
        )
        box = tabs.nth(i).bounding_box()
        assert box["x"] >= 0 and box["x"] + box["width"] <= 400
