"""Explore: filters by histogram and by a cell of the confusion matrix."""

from collections.abc import Callable
from typing import Any

import pytest

from .gestures import MAP

pytestmark = pytest.mark.browser

TITLE = ".explore .now .map-title"


def drag_over(page: Any, name: str) -> None:
    """Drag over the middle of a histogram."""
    histogram = page.locator(f'.explore .histograms [data-name="{name}"] svg')
    histogram.scroll_into_view_if_needed()
    box = histogram.bounding_box()
    middle = box["y"] + box["height"] / 2
    page.mouse.move(box["x"] + 0.3 * box["width"], middle)
    page.mouse.down()
    page.mouse.move(box["x"] + 0.7 * box["width"], middle, steps=4)
    page.mouse.up()


def test_a_range_is_named_in_the_title_kept_in_the_address_and_put_aside_by_the_tour(
    open_page: Callable[..., Any],
) -> None:
    page = open_page()
    page.wait_for_selector(".explore .histograms svg")
    drag_over(page, "cosine")
    page.wait_for_selector(f"{TITLE}:has-text('photo–touch cosine')")
    page.wait_for_function("location.search.includes('range=')")
    found = page.locator(".explore .finder .found").inner_text()
    page.reload()
    page.wait_for_selector(f".explore .finder .found:has-text('{found}')")
    page.click(".tour-start")
    page.wait_for_selector(".tour [data-option]")
    assert page.locator(".explore .finder .found").inner_text() == ""
    page.click(".tour .end")
    assert page.locator(".explore .finder .found").inner_text() == found


def test_a_link_to_a_cell_of_the_confusion_matrix_shows_its_pairs(
    open_page: Callable[..., Any],
) -> None:
    page = open_page("?part=strangers")
    page.wait_for_selector(MAP)
    page.click(".explore .confusion .hit button:not([disabled])")
    page.wait_for_selector(f"{TITLE}:has-text('predicted as')")
    page.wait_for_function("location.search.includes('cell=')")
    found = page.locator(".explore .finder .found").inner_text()
    page.reload()
    page.wait_for_selector(f".explore .finder .found:has-text('{found}')")
    page.click(".explore .confusion [aria-pressed=true]")
    assert page.locator(".explore .finder .found").inner_text() == ""
