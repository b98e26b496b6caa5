"""Letters of every tab can be read: none is smaller than 10 pixels, no title is cut off."""

import pytest

from app.shared.components import VIEWS

from .gestures import READY, go, open_tab, settle

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


@pytest.mark.parametrize(
    "options",
    [
        {"size": (400, 800)},
        pytest.param({"size": (720, 450), "device_scale_factor": 2}, marks=pytest.mark.long),
        pytest.param({"size": (1024, 800)}, marks=pytest.mark.long),
    ],
    ids=["a phone", "200 % zoom", "a small window"],
)
def test_no_letter_is_too_small_no_title_is_cut_and_nothing_needs_scrolling_sideways(
    open_page, options
):
    page = open_page(PAIR, READY["explore"], **options)
    wide = options["size"][0]
    assert page.evaluate(SMALL) == page.evaluate(CUT) == []
    go(page, f"{PAIR}&pin=3")  # the workbench
    for view in VIEWS:
        open_tab(page, view)
        page.wait_for_selector(READY[view])
        assert page.evaluate(SMALL) == page.evaluate(CUT) == [], view
        assert page.evaluate(WIDE, wide) == [], view
        assert page.evaluate("document.scrollingElement.scrollWidth") <= wide, view


def test_no_part_of_the_chirps_is_wider_than_the_window(open_page):
    page = open_page("?set=chirps&chapter=analyse", ".explore .score b", size=(1440, 800))
    for width in (1440, 400):
        page.set_viewport_size({"width": width, "height": 800})
        settle(page)
        assert page.evaluate("document.documentElement.scrollWidth - innerWidth") <= 0
        box = page.locator(".explore .score").bounding_box()
        assert box["width"] > 200, "the score has room beside the map"


def test_a_student_can_read_what_a_gap_lies_between_and_what_is_dashed(visit):
    page = visit("?chapter=analyse")
    for measure, between in (
        ("modality_gap", "photo to touch"),
        ("domain_gap", "domain to domain"),
    ):
        page.select_option(".explore .of-steps", measure)
        assert between in page.text_content(".explore .stair-name")
    assert "Dashed line: the raw embedding" in page.text_content(".explore .all.curves")


def test_analyse_is_no_wider_than_its_column_and_no_axis_of_a_lecture_is_cut(open_page):
    page = open_page("?chapter=analyse&mode=moved&beside=1", READY["explore"], size=(1280, 720))
    settle(page)
    assert (
        page.evaluate(
            "(({ scrollWidth, clientWidth }) => scrollWidth -"
            " clientWidth)(document.querySelector('.side'))"
        )
        <= 0
    )
    page.keyboard.press("f")
    page.wait_for_selector("body.lecturing")
    cut = """() => {
      const left = (of) => of.getBoundingClientRect().left;
      return [...document.querySelectorAll('.explore .over text')].filter((text) =>
        text.checkVisibility() && left(text) < left(document.querySelector('.side')))
        .map((text) => text.textContent);
    }"""
    assert page.evaluate(cut) == []
