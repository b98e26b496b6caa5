"""What a visitor does, in a real Chromium: one journey a tab, by mouse and by keyboard."""

import re
from collections.abc import Callable
from typing import Any

import pytest

from .gestures import MAP, grab, p_shown, pixels, place_of_a_point, pull, texture

pytestmark = pytest.mark.browser


def test_dragging_p_changes_the_map_and_the_figures(open_page: Callable[..., Any]) -> None:
    page = open_page()
    page.wait_for_selector(MAP)
    before, gap = pixels(page), page.locator(".explore .curves output").first.inner_text()
    pull(page, grab(page), 0.8, steps=5)
    page.mouse.up()
    assert pixels(page) != before
    assert page.locator(".explore .curves output").first.inner_text() != gap
    page.wait_for_function(f"location.search.includes('p={float(p_shown(page)):g}')")


def test_raw_stages_do_not_move_and_the_page_says_why(open_page: Callable[..., Any]) -> None:
    page = open_page("?stage=frft&p=0.2")
    page.wait_for_selector(MAP)
    assert "unitary" in page.locator(".explore .explain").inner_text()
    before = pixels(page)
    page.focus(".explore .order")
    for _ in range(5):
        page.keyboard.press("ArrowRight")
    assert page.locator(".explore .order-value").inner_text() == "0.25"
    assert pixels(page) == before


def test_a_point_shows_its_pair_and_pins_it_for_the_other_tabs(
    open_page: Callable[..., Any],
) -> None:
    page = open_page()
    page.wait_for_selector(MAP)
    at = place_of_a_point(page)
    page.mouse.click(*at)
    page.wait_for_selector(".explore .card .tag")
    page.wait_for_function("/pin=\\d+/.test(location.search)")
    page.click(".explore .card .open")
    page.wait_for_selector(".pair .bars table")
    assert re.search(r"pair \d+", page.locator(".pair .slot .what").first.inner_text())


def test_a_lasso_selects_points_and_saves_them_as_csv(open_page: Callable[..., Any]) -> None:
    page = open_page()
    page.wait_for_selector(MAP)
    page.click(".explore .tool.lasso")
    box = page.locator(".explore .map").bounding_box()
    page.mouse.move(box["x"] + 4, box["y"] + 4)
    page.mouse.down()
    for dx, dy in ((0.99, 0.01), (0.99, 0.99), (0.01, 0.99), (0.01, 0.05)):
        page.mouse.move(box["x"] + dx * box["width"], box["y"] + dy * box["height"], steps=3)
    page.mouse.up()
    heading = page.locator(".explore .selection h3").inner_text()
    count = int(heading.split()[0])
    assert count > 10
    with page.expect_download() as saved:
        page.click(".explore .selection .csv")
    lines = saved.value.path().read_text(encoding="utf-8").splitlines()
    assert lines[0].startswith("pair,modality,domain,class")
    assert len(lines) == count + 1
    page.focus(".explore .map canvas + canvas")
    page.keyboard.press("Escape")
    assert page.locator(".explore .selection").is_hidden()


def test_the_keyboard_selects_all_that_is_in_view(open_page: Callable[..., Any]) -> None:
    page = open_page()
    page.wait_for_selector(MAP)
    page.focus(".explore .map canvas + canvas")
    heading = page.locator(".explore .selection h3")
    counts = []
    for zooms in (0, 6):
        for _ in range(zooms):
            page.keyboard.press("+")
        page.evaluate(  # the next drawing settles what is in view
            "new Promise((drawn) => requestAnimationFrame(() => requestAnimationFrame(drawn)))"
        )
        page.keyboard.press("s")
        counts.append(int(heading.inner_text().split()[0]))
    assert counts[0] > counts[1] > 0


def test_the_map_works_by_keyboard_alone(open_page: Callable[..., Any]) -> None:
    page = open_page()
    page.wait_for_selector(MAP)
    page.focus(".explore .map canvas + canvas")
    before = pixels(page)
    page.keyboard.press("+")
    assert pixels(page) != before
    page.keyboard.press("0")
    assert pixels(page) == before
    page.keyboard.press("n")
    assert "Pair" in page.locator(".explore .card h3").inner_text()
    page.keyboard.press("Enter")
    assert page.locator(".explore .card .tag").is_visible()


def test_uploading_a_pair_and_moving_p_by_keyboard_changes_the_probabilities(
    open_page: Callable[..., Any],
) -> None:
    page = open_page("?view=pair")
    page.wait_for_selector(".pair .slot")
    for seed, modality in enumerate(("vis", "tac")):
        slot = f'.pair .slot[data-modality="{modality}"]'
        page.set_input_files(f"{slot} input[type=file]", texture(seed))
        page.wait_for_function(
            f"document.querySelector('{slot} .what').textContent.includes('{seed}.png')"
        )
    page.wait_for_function(
        "location.search.includes('vis=image') && location.search.includes('tac=image')"
    )
    page.wait_for_selector(".pair .results[aria-busy=false] .bars table")
    cells = page.locator(".pair .bars td[data-voice=both] .share")
    before = cells.all_inner_texts()
    assert sum(float(text.split()[0]) for text in before) == pytest.approx(100, abs=0.5)
    assert page.locator(".pair .verdict h2").inner_text()
    page.focus(".pair .order")
    for _ in range(10):
        page.keyboard.press("ArrowLeft")
    assert cells.all_inner_texts() != before


def test_one_image_alone_is_enough(open_page: Callable[..., Any]) -> None:
    page = open_page("?view=pair&vis=row:0&tac=row:0")
    page.wait_for_selector(".pair .bars table")
    page.click('.pair .slot[data-modality="vis"] .clear')
    page.wait_for_function("!document.querySelector('.pair .bars [data-voice=vis]')")
    assert page.locator(".pair .bars td[data-voice=tac]").count() > 1


def test_a_pair_taken_away_right_after_p_moved_leaves_nothing_to_say(
    open_page: Callable[..., Any],
) -> None:
    page = open_page("?view=pair&vis=row:0&tac=row:0")
    page.wait_for_selector(".pair .bars table")
    page.focus(".pair .order")
    page.keyboard.press("ArrowLeft")
    page.evaluate("document.querySelectorAll('.pair .slot .clear').forEach(one => one.click())")
    page.wait_for_timeout(600)  # what is said of p follows after 400 ms; a failed script would show
    assert page.locator(".pair .bars table").count() == 0


def test_the_tree_follows_p(open_page: Callable[..., Any]) -> None:
    page = open_page("?view=tree&vis=row:0&tac=row:0&p=0.5")
    page.wait_for_selector(".tree .tree-view")
    assert page.locator(".tree .tree-view .disc").count() == 7
    before = page.locator(".tree .matrices").inner_text()
    page.focus(".tree .order")
    for _ in range(20):
        page.keyboard.press("ArrowRight")
    page.wait_for_function(
        "before => document.querySelector('.tree .matrices').innerText !== before", arg=before
    )


def test_simulated_data_say_so(open_page: Callable[..., Any]) -> None:
    page = open_page("?view=data")
    page.wait_for_selector(".data .note")
    assert "Simulated" in page.locator(".data .note").inner_text()
    assert page.locator(".top .badge").is_visible()


def test_methods_are_ranked_by_their_mean_over_unseen_domains(
    open_page: Callable[..., Any],
) -> None:
    page = open_page("?view=compare")
    page.wait_for_selector(".ranking")

    def shown() -> list[float]:
        return [float(text) for text in page.locator(".ranking b").all_inner_texts()]

    accuracy = shown()
    assert accuracy == sorted(accuracy, reverse=True)
    assert len(accuracy) == page.locator(".scores .overall").count() == 6
    page.click('[data-metric="1"]')
    assert len(shown()) == 6
    assert shown() != accuracy


def test_compare_links_two_maps_and_counts_what_changes(open_page: Callable[..., Any]) -> None:
    page = open_page("?view=compare&p=0.5&p2=0.1&stage2=f_hat")
    page.wait_for_selector(".compare .map[data-order]")
    text = page.locator(".compare .moved").inner_text()
    changed, right, wrong, other = (
        int(n) for n in re.findall(r"(?<![.\d])(\d+)(?= of|\b now|\b wrong)", text)
    )
    assert changed == right + wrong + other > 0
    before = [
        canvas.evaluate("c => c.toDataURL()")
        for canvas in page.query_selector_all(".compare .map canvas:first-child")
    ]
    page.focus(".compare .map canvas + canvas")
    page.keyboard.press("+")
    page.wait_for_function(
        """before => [...document.querySelectorAll('.compare .map canvas:first-child')]
             .every((canvas, i) => canvas.toDataURL() !== before[i])""",
        arg=before,
    )


def test_the_tour_goes_through_six_steps_and_puts_back_what_was_seen(
    open_page: Callable[..., Any],
) -> None:
    page = open_page("?stage=relu&colour=class")
    page.wait_for_selector(MAP)
    page.click(".tour-start")
    for step in range(1, 7):
        page.wait_for_selector(f".tour h3:has-text('{step} of 6')")
        assert "not measured" not in page.locator(".tour p").inner_text()
        page.keyboard.press("Enter")  # the next button has the focus
    page.wait_for_selector(".tour", state="detached")
    page.wait_for_function("location.search.includes('stage=relu')")


def test_where_the_answer_comes_from_is_tinted_over_the_image(
    open_page: Callable[..., Any],
) -> None:
    page = open_page("?view=pair&vis=row:0")
    page.wait_for_selector(".pair .bars table")
    slot = '.pair .slot[data-modality="tac"]'
    page.set_input_files(f"{slot} input[type=file]", texture(3))
    page.wait_for_function("location.search.includes('tac=image')")
    page.click(f"{slot} .where")
    page.wait_for_selector(f"{slot} .picture canvas")
    assert "orange parts" in page.locator(f"{slot} .what").inner_text()
