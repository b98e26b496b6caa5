"""Explore on a projector, on a phone and as a saved page, in a real Chromium."""

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from omnivat.heads import EXAMPLES

from .gestures import MAP, MOVED

pytestmark = pytest.mark.browser


PHONE = {"viewport": {"width": 400, "height": 800}, "has_touch": True, "is_mobile": True}


def test_letters_of_charts_are_large_enough_on_a_projector(open_page: Callable[..., Any]) -> None:
    page = open_page(MOVED, viewport={"width": 1280, "height": 720})
    page.wait_for_selector(MAP)
    small = page.evaluate(
        """() => [...document.querySelectorAll('.explore svg text')].filter((t) => t.checkVisibility())
          .map((t) => parseFloat(getComputedStyle(t).fontSize) * t.ownerSVGElement.getScreenCTM().a)
          .filter((size) => size < 11.4)"""
    )
    assert small == []
    cut = page.evaluate(
        """() => [...document.querySelectorAll('.explore .filters .source')].filter((mark) =>
          mark.getBoundingClientRect().right > mark.parentElement.getBoundingClientRect().right + 1)"""
    )
    assert cut == []


def test_on_a_phone_the_hint_covers_nothing_goes_by_itself_and_no_keys_are_named(
    new_page: Callable[..., Any], address: str
) -> None:
    page = new_page(**PHONE)
    page.clock.install()
    page.goto(address + MOVED, wait_until="commit")
    page.wait_for_selector(MAP)
    assert page.locator(".explore .coach").is_visible()
    over = page.evaluate(
        """() => {
          const hint = document.querySelector('.explore .coach').getBoundingClientRect();
          return [...document.querySelectorAll('.explore [data-stage], .explore .modes button, .explore .learned')]
            .filter((e) => e.checkVisibility()).map((e) => e.getBoundingClientRect())
            .filter((b) => b.left < hint.right && b.right > hint.left && b.top < hint.bottom && b.bottom > hint.top).length;
        }"""
    )
    assert over == 0
    assert not page.locator(".explore .card kbd").first.is_visible()
    page.clock.fast_forward(10_000)
    page.wait_for_selector(".explore .coach", state="hidden")


def test_on_a_phone_each_step_of_the_tour_brings_its_subject_into_view(
    new_page: Callable[..., Any], address: str
) -> None:
    page = new_page(**PHONE)
    page.goto(address, wait_until="commit")
    page.wait_for_selector(MAP)
    page.click(".tour-start")
    for subject in (".maps", ".maps", ".toy", ".staircase", ".curves", ".strangers"):
        page.wait_for_selector(".tour [data-option]")
        page.wait_for_function(
            """subject => {
              const { top } = document.querySelector(`.explore ${subject}`).getBoundingClientRect();
              const bar = document.querySelector('.explore .order-bar').getBoundingClientRect();
              const box = document.querySelector('.tour').getBoundingClientRect();
              return top >= bar.bottom - 1 && top < box.top - 150;
            }""",
            arg=subject,
        )
        page.keyboard.press("Enter")
        page.wait_for_selector(".tour .next")
        page.keyboard.press("Enter")


def test_the_saved_page_works_from_disk_with_its_toy_and_tour(
    chromium: Any, tmp_path: Path
) -> None:
    from app.export import export_page, where_from

    where = where_from(None, None)
    export_page(where, EXAMPLES / "frames.bin", tmp_path / "page.html")
    page = chromium.new_page(viewport={"width": 1440, "height": 900})
    failed: list[str] = []
    page.on("pageerror", lambda error: failed.append(str(error)))
    page.on(
        "request", lambda r: None if r.url.startswith(("file:", "data:")) else failed.append(r.url)
    )
    page.goto((tmp_path / "page.html").as_uri())
    page.wait_for_selector(MAP)
    page.wait_for_selector(".explore .score b")
    page.click('.explore [data-part="toy"]')
    page.wait_for_selector(".explore .toy .plane path")
    page.click(".tour-start")
    page.wait_for_selector(".tour h3:has-text('1 of 6')")
    page.keyboard.press("Enter")
    assert re.search(r"\d\.\d\d", page.locator(".tour p").inner_text())
    page.close()
    assert failed == []
