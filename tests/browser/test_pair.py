"""Try a pair: one journey for each action."""

import re
from collections.abc import Callable
from typing import Any

import pytest

from .gestures import ANSWERED, texture

pytestmark = pytest.mark.browser


SLOT = '.pair .slot[data-modality="{}"]'


PAIR = "?view=pair&vis=row:0&tac=row:0"


def send(page: Any, modality: str, seed: int) -> None:
    """Choose a picture of noise as photo or touch and wait for its prediction."""
    slot = SLOT.format(modality)
    page.set_input_files(f"{slot} input[type=file]", texture(seed))
    page.wait_for_selector(f"{slot} .what:has-text('{seed}.png')")
    page.wait_for_selector(ANSWERED)


def said(page: Any, reading: str) -> str:
    """Return what one reading predicts, in the words of the page."""
    return str(page.locator(f".pair .reading[data-reading={reading}]").inner_text())


def test_pictures_unlike_anything_seen_are_called_a_guess(open_page: Callable[..., Any]) -> None:
    page = open_page("?view=pair")
    page.wait_for_selector(ANSWERED)
    for seed, modality in enumerate(("vis", "tac")):
        send(page, modality, seed)
    page.wait_for_selector(".pair .familiar .look")
    if "has no record" in page.locator(".pair .familiar").inner_text():
        pytest.skip("the head that is shipped holds no familiarity")
    page.wait_for_selector(".pair .reading[data-reading=fused] .guessed")
    for reading in ("fused", "vis", "tac"):
        assert "This is a guess" in said(page, reading)
        assert "%" not in said(page, reading)
    assert page.locator(".pair .nearest button").count() == 6


def test_touch_only_does_not_depend_on_the_photo(open_page: Callable[..., Any]) -> None:
    page = open_page(PAIR)
    page.wait_for_selector(ANSWERED)
    cells = page.locator(".pair .bars td[data-reading=tac] .share")
    before, both = (
        cells.all_text_contents(),
        page.locator(".pair .bars td[data-reading=fused] .share").all_text_contents(),
    )
    send(page, "vis", 7)
    assert cells.all_text_contents() == before
    assert page.locator(".pair .bars td[data-reading=fused] .share").all_text_contents() != both


def test_one_image_is_enough(open_page: Callable[..., Any]) -> None:
    page = open_page(PAIR)
    page.wait_for_selector(ANSWERED)
    page.click(f"{SLOT.format('vis')} .clear")
    page.wait_for_selector(".pair .reading.none[data-reading=vis]")
    assert "No photo here" in said(page, "vis")
    assert "Add the photo" in said(page, "fused")


def test_no_letter_of_the_chart_over_p_is_cut_off(open_page: Callable[..., Any]) -> None:
    page = open_page(PAIR, viewport={"width": 1280, "height": 720})
    page.wait_for_selector(ANSWERED)
    page.click(".pair .what-if-p summary")
    page.wait_for_selector(".pair .what-if-p .chart svg text")
    cut = page.evaluate(
        """() => [...document.querySelectorAll('.pair .what-if-p .chart text')].filter((text) => {
          const [own, all] = [text, text.ownerSVGElement].map((e) => e.getBoundingClientRect());
          return own.left < all.left - 1 || own.right > all.right + 1;
        }).map((text) => text.textContent)"""
    )
    assert cut == []


def test_p_is_moved_in_a_section_of_its_own_and_leaves_the_prediction(
    open_page: Callable[..., Any],
) -> None:
    page = open_page(PAIR)
    page.wait_for_selector(ANSWERED)
    prediction = said(page, "fused")
    page.click(".pair .what-if-p summary")
    page.wait_for_selector(".pair .lines svg .band")
    before = page.locator(".pair .at-p").inner_text()
    page.focus(".pair .order")
    for _ in range(10):
        page.keyboard.press("ArrowLeft")
    page.wait_for_function(
        "before => document.querySelector('.pair .at-p').innerText !== before", arg=before
    )
    assert said(page, "fused") == prediction
    assert "guessing" in page.locator(".pair .about-p").inner_text()


def test_own_pairs_are_counted_taught_and_saved(open_page: Callable[..., Any]) -> None:
    page = open_page("?view=pair")
    page.wait_for_selector(ANSWERED)
    for seed, label in ((20, "wood"), (21, "wood"), (22, "cork"), (23, "cork")):
        send(page, "vis", seed)
        send(page, "tac", seed + 10)
        own = page.locator(f".pair .labels button[data-label='{label}']")
        if own.count():
            own.click()
        else:
            page.fill(".pair .labels input", label)
            page.keyboard.press("Enter")
        page.wait_for_selector(f".pair .chips li:has-text('{seed}.png')")
    assert "of 4" in page.locator(".pair .tally").inner_text()
    page.click(".pair .teach")
    page.wait_for_selector(".pair .taught table")
    report = page.locator(".pair .taught p").first.inner_text()
    assert re.search(r"Right before: \d of 4\. After: \d of 4\.", report)
    page.click(".pair .use")
    page.wait_for_selector(".pair .taught-now")
    page.wait_for_selector(ANSWERED)
    assert page.locator(".pair .bars th:has-text('cork')").count() == 1
    for button in (".save-set", ".save-head", ".save-pictures"):
        with page.expect_download() as saved:
            page.click(f".pair {button}")
        assert saved.value.path().read_bytes()[:2] == b"PK"


def test_a_second_click_while_the_camera_opens_leaves_it_off(
    open_page: Callable[..., Any],
) -> None:
    page = open_page(PAIR, permissions=["camera"])
    page.wait_for_selector(ANSWERED)
    page.evaluate(
        """slot => {
          const open = navigator.mediaDevices.getUserMedia.bind(navigator.mediaDevices);
          window.streams = [];
          navigator.mediaDevices.getUserMedia = async (what) => {
            await new Promise((later) => setTimeout(later, 300));
            const stream = await open(what);
            window.streams.push(stream);
            return stream;
          };
          const live = document.querySelector(`${slot} .live`);
          live.click();
          live.click();
        }""",
        SLOT.format("tac"),
    )
    page.wait_for_function("window.streams.length === 1")
    page.wait_for_function(
        "window.streams.every((one) => one.getTracks().every((t) => t.readyState === 'ended'))"
    )
    button = page.locator(f"{SLOT.format('tac')} .live")
    assert button.get_attribute("aria-pressed") == "false"
    page.wait_for_selector(ANSWERED)


def test_buttons_stay_under_the_pointer_while_the_camera_runs(
    open_page: Callable[..., Any],
) -> None:
    page = open_page(PAIR, permissions=["camera"], viewport={"width": 1280, "height": 720})
    page.wait_for_selector(ANSWERED)
    button = page.locator(f"{SLOT.format('vis')} .live")
    button.dblclick()  # the second click arrives at the same place
    assert button.get_attribute("aria-pressed") == "false"
    assert page.locator(".pair video").count() == 0
    page.wait_for_selector(ANSWERED)


def test_where_tells_whether_any_part_matters(open_page: Callable[..., Any]) -> None:
    page = open_page("?view=pair&vis=row:0")
    page.wait_for_selector(ANSWERED)
    send(page, "tac", 3)
    slot = SLOT.format("tac")
    page.click(f"{slot} .where")
    page.wait_for_selector(f"{slot} .what:has-text('Hiding')")
    page.wait_for_function(
        "slot => !document.querySelector(slot + ' .what').innerText.includes('one part after')",
        arg=slot,
    )
    told = page.locator(f"{slot} .what").inner_text()
    shown = page.locator(f"{slot} .picture canvas").count()
    assert ("no single part matters" in told) == (shown == 0)


def test_a_pair_taken_away_leaves_nothing_behind(open_page: Callable[..., Any]) -> None:
    page = open_page(PAIR)
    page.wait_for_selector(ANSWERED)
    page.evaluate("document.querySelectorAll('.pair .slot .clear').forEach(one => one.click())")
    page.wait_for_selector(".pair .reading", state="detached")
    assert page.locator(".pair .familiar").is_hidden()
    assert page.locator(".pair .what-if-p").is_hidden()
