"""Letters of every tab can be read: none is smaller than 10 pixels, no title is cut off."""

import pytest

from app.shared.components import VIEWS

from .gestures import READY, open_tab, settle

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


@pytest.mark.parametrize("width", [400, pytest.param(1024, marks=pytest.mark.long)])
def test_no_letter_of_a_drawing_is_too_small_and_no_title_is_cut(open_page, width):
    page = open_page(PAIR, size=(width, 800))
    for view in VIEWS:
        if view != "explore":
            open_tab(page, view)
        page.wait_for_selector(READY[view])
        assert page.evaluate(SMALL) == [], view
        assert page.evaluate(CUT) == [], view


@pytest.mark.parametrize("name", ["sensors", "chirps"])
@pytest.mark.parametrize("width", [400, 1440])
def test_no_part_of_explore_is_wider_than_the_window(open_page, name, width):
    page = open_page(f"?set={name}&chapter=analyse", ".explore .score b", size=(width, 800))
    assert page.evaluate("document.documentElement.scrollWidth - innerWidth") <= 0
    box = page.locator(".explore .score").bounding_box()
    assert box["width"] > 200, "the score has room beside the map"


def test_a_student_can_read_what_a_gap_lies_between_and_what_is_dashed(open_page):
    page = open_page("?chapter=analyse", READY["explore"])
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
