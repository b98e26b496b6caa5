"""The second map, nodes and limits: one journey for each action."""

import re

import pytest

from .gestures import READY, pixels

pytestmark = pytest.mark.browser


def test_the_nodes_of_the_pinned_pair_follow_p_and_tell_which_are_constant(visit):
    page = visit("?chapter=analyse&mode=moved&pin=0")
    page.click(".explore [data-panel=nodes] summary")
    page.wait_for_selector(".explore .worth:has-text('nodes')")
    assert page.locator(".explore .nodes .disc").count() == 7
    told = page.inner_text(".explore .worth")
    number = re.search(r"(\d) of 7 nodes \(dashed\)", told)
    assert page.locator(".explore .nodes .disc.fixed").count() == (int(number[1]) if number else 0)
    assert "its learned p is" in page.inner_text(".explore .nodes p")
    before = page.text_content(".explore .tree-view")
    page.focus(".explore .order")
    for _ in range(20):
        page.keyboard.press("ArrowRight")
    page.wait_for_selector(".explore .nodes p:has-text('grows at p = 0.7')")
    assert page.text_content(".explore .tree-view") != before


def test_a_second_map_moves_with_the_first_and_has_a_step_a_method_and_a_p_of_its_own(visit):
    page = visit("?chapter=analyse&mode=moved")
    page.click(".explore .second")
    page.wait_for_selector(".explore .beside .map[data-order]")
    for pane in (".now", ".beside"):
        told = page.inner_text(f".explore {pane} .pane")
        assert "modality gap" in told
        assert "domain gap" in told
    assert page.is_hidden(".explore .changed")  # one head at one p predicts the same
    before = [pixels(page, f".explore {pane} .map") for pane in (".now", ".beside")]
    page.focus(".explore .beside .map canvas + canvas")
    page.keyboard.press("+")
    assert all(
        pixels(page, f".explore {p} .map") != old
        for p, old in zip((".now", ".beside"), before, strict=True)
    )
    page.select_option(".explore .beside .step", "f_hat")
    page.focus(".explore .beside .its-p")
    for _ in range(200):
        page.keyboard.press("ArrowRight")
    page.wait_for_function("location.search.includes('p2=')")
    of_p = counts(page)
    page.select_option(".explore .beside .by", "method:nearest_mean")
    page.wait_for_selector(".explore .beside .its-p:disabled")
    assert counts(page) != of_p
    page.click(".explore .second")
    assert page.is_hidden(".explore .beside")


@pytest.mark.parametrize(("window", "least"), [(1440, 700), (900, 480)])
def test_charts_that_a_wide_window_drew_scroll_in_a_narrow_one(open_page, window, least):
    page = open_page("?view=train", READY["train"], size=(window, 800))
    page.wait_for_selector("#train-charts .js-plotly-plot")
    page.set_viewport_size({"width": 400, "height": 800})
    wide = page.locator("#train-charts .js-plotly-plot").bounding_box()["width"]
    assert wide >= least > page.locator("#train-charts").bounding_box()["width"]
    assert page.evaluate("document.scrollingElement.scrollWidth <= innerWidth")


def counts(page):
    """Return what the page counts of changed predictions, and check that it adds up."""
    page.wait_for_selector(".explore .changed:has-text('predictions change')")
    text = page.inner_text(".explore .changed").replace(",", "")
    changed, everything = (int(n) for n in re.search(r"(\d+) of (\d+)", text).groups())
    ends = page.evaluate(
        """() => { const told = document.createRange();
          told.selectNodeContents(document.querySelector('.explore .changed'));
          return [told.getBoundingClientRect().bottom,
            ...[...document.querySelectorAll('.explore .corner > *')]
            .filter((e) => e.textContent && e.checkVisibility())
            .map((e) => e.getBoundingClientRect().top)]; }"""
    )
    assert ends[0] <= min(ends[1:])  # it lies on nothing
    parts = [int(n) for n in re.findall(r"(\d+) (?:corrected|broken|still)", text)]
    assert changed == sum(parts) > 0
    assert everything > changed
    return parts


DEFINED = """() => {
  const [text, box] = [document.querySelector('.explore .provenance'),
    document.querySelector('.definition')]
    .map((one) => one.getBoundingClientRect());
  return !(box.top < text.bottom && text.top < box.bottom && box.left < text.right
    && text.left < box.right);
}"""


def test_a_word_of_the_field_has_its_sentence_where_it_stands_and_not_over_the_text(visit):
    page = visit("?chapter=analyse", READY["explore"])
    word = page.locator(".explore .provenance dfn:has-text('head')")
    for way in (word.hover, word.focus):
        way()
        page.wait_for_selector(
            ".definition:has-text('the small network that learns here') >> visible=true"
        )
        assert page.evaluate(DEFINED)
        page.keyboard.press("Escape")
        assert page.is_hidden(".definition")
        page.evaluate("document.activeElement.blur()")
        page.mouse.move(1, 1)


def test_a_set_of_signals_offers_neither_camera_nor_sensor(open_page):
    page = open_page("?set=chirps&view=pair", ".pair .of-signals:visible")
    page.wait_for_selector(".pair .slot .where:visible")
    for gone in (".slot .camera", ".cameras", ".panel.sensor"):
        assert page.locator(f".pair {gone}").count()
        assert not page.locator(f".pair {gone} >> visible=true").count()
