"""Explore: filters by histogram and by a cell of the confusion matrix."""

import pytest

from .gestures import MAP, TOOLS, pixels, settle

pytestmark = pytest.mark.browser

TITLE = ".explore [data-panel=step] .map-title"


def drag_over(page, name):
    """Drag over the middle of a histogram."""
    histogram = page.locator(f'.explore .histograms [data-name="{name}"] svg')
    histogram.scroll_into_view_if_needed()
    box = histogram.bounding_box()
    middle = box["y"] + box["height"] / 2
    page.mouse.move(box["x"] + 0.3 * box["width"], middle)
    page.mouse.down()
    page.mouse.move(box["x"] + 0.7 * box["width"], middle, steps=4)
    page.mouse.up()


def test_a_range_is_dragged_or_moved_by_keys_named_kept_in_the_address_and_put_aside_elsewhere(
    visit,
):
    page = visit(TOOLS, ".explore .histograms svg")
    drag_over(page, "cosine")
    page.wait_for_selector(f"{TITLE}:has-text('photo–touch cosine')")
    pixels(page)  # the last move of the mouse is drawn
    settle(page)
    assert "range=" in page.url
    found = page.inner_text(".explore .finder .found")
    page.reload()
    page.wait_for_selector(f".explore .finder .found:has-text('{found}')")
    page.click('.explore [data-chapter="order"]')
    page.wait_for_selector(".explore .title:visible")
    assert "range=" not in page.url
    page.click('.explore [data-chapter="analyse"]')
    page.wait_for_selector(f".explore .finder .found:has-text('{found}')")
    page.focus(".explore .histograms [data-name=confidence] svg")
    for _ in range(8):
        page.keyboard.press("ArrowRight")
    assert page.inner_text(".explore .finder .found") != found
    page.click(".explore .histograms [data-name=confidence] button")
    assert page.inner_text(".explore .finder .found") == found


def test_a_link_to_a_cell_of_the_confusion_matrix_shows_its_pairs(visit):
    page = visit("?chapter=fooled", MAP)
    page.click(".explore .confusion .hit button:not([disabled])")
    page.wait_for_function("location.search.includes('cell=')")
    found = page.inner_text(".explore .pictures h4")
    assert "points selected" in found
    page.reload()
    page.wait_for_selector(f".explore .pictures h4:has-text('{found}')")
    page.click(".explore .confusion [aria-pressed=true]")
    page.wait_for_selector(".explore .pictures h4:has-text('look like another class')")
