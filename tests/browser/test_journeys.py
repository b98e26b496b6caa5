"""A visitor's actions in a real Chromium: one journey for each tab, by mouse and by keyboard."""

import re

import pytest

from .gestures import ANSWERED, TOOLS, pixels, place_of_a_point

pytestmark = pytest.mark.browser


def test_raw_stages_do_not_move_and_the_page_says_why(visit):
    page = visit("?mode=moved&stage=frft&p=0.2")
    assert "unitary" in page.inner_text(".explore .explain")
    before = pixels(page)
    page.focus(".explore .order")
    for _ in range(5):
        page.keyboard.press("ArrowRight")
    assert page.inner_text(".explore .order-value") == "0.25"
    assert pixels(page) == before


def test_a_point_shows_its_pair_and_pins_it_for_the_other_tabs(visit):
    page = visit(TOOLS)
    at = place_of_a_point(page)
    page.mouse.click(*at)
    page.wait_for_selector(".explore .card .tag")
    page.wait_for_function("/pin=\\d+/.test(location.search)")
    page.click(".explore .card .open")
    page.wait_for_selector(ANSWERED)
    assert re.search(r"pair \d+", page.inner_text(".pair .slot .what"))


def test_a_lasso_selects_points_in_a_short_address_and_saves_them_as_csv(visit):
    page = visit(TOOLS)
    page.click(".explore .tool.lasso")
    box = page.locator(".explore .map").bounding_box()
    page.mouse.move(box["x"] + 4, box["y"] + 4)
    page.mouse.down()
    for dx, dy in ((0.99, 0.01), (0.99, 0.99), (0.01, 0.99), (0.01, 0.05)):
        page.mouse.move(box["x"] + dx * box["width"], box["y"] + dy * box["height"], steps=3)
    page.mouse.up()
    heading = page.inner_text(".explore .pictures h4")
    count = int(heading.split()[0])
    assert count > 200
    page.wait_for_function("location.search.includes('sel=')")
    assert len(page.url) < 1200
    with page.expect_download() as saved:
        page.click(".explore .pictures .csv")
    lines = saved.value.path().read_text(encoding="utf-8").splitlines()
    assert lines[0].startswith("pair,modality,domain,class")
    assert len(lines) == count + 1
    page.focus(".explore .map canvas + canvas")
    page.keyboard.press("Escape")
    assert page.locator(".explore .pictures .clear").count() == 0


def test_the_map_works_by_keyboard_alone(visit):
    page = visit(TOOLS)
    page.focus(".explore .map canvas + canvas")
    before = pixels(page)
    counts = []
    for zooms in (0, 6):
        for _ in range(zooms):
            page.keyboard.press("+")
        assert (pixels(page) == before) == (zooms == 0)  # drawn, which settles what is in view
        page.keyboard.press("s")
        counts.append(int(page.inner_text(".explore .pictures h4").split()[0]))
    assert counts[0] > counts[1] > 0
    page.keyboard.press("Escape")
    page.keyboard.press("0")
    assert pixels(page) == before
    page.keyboard.press("n")
    assert "Pair" in page.inner_text(".explore .card h3")
    page.keyboard.press("Enter")
    assert page.is_visible(".explore .card .tag")


# what a figure of the page looks like, where it can be seen
FIGURES = """() => [
  ...document.querySelectorAll('.explore :is(b, output, .said, .figure, .remark)'),
].filter((one) =>
  !one.closest('.tour') && one.checkVisibility({ visibilityProperty: true })
    && /[0-9✓✗]/.test(one.textContent)
  && !one.matches('.order-value')).map((one) => one.textContent)"""


def test_the_tour_asks_before_it_answers_walks_four_chapters_and_ends_with_the_titles_answer(visit):
    page = visit("?stage=relu&colour=class")
    page.click(".tour-start")
    chapters = []
    for step in range(1, 8):
        page.wait_for_selector(f".tour h3:has-text('{step} of 8')")
        assert page.locator(".tour [data-option]").count() >= 2
        assert page.locator(".tour [data-option]:focus").count() == 0  # the focus marks no option
        assert page.evaluate(FIGURES) == []
        chapters.append(page.evaluate("document.querySelector('.ov.explore').dataset.chapter"))
        page.keyboard.press("Tab")
        page.keyboard.press("Enter")
        page.wait_for_selector(".tour .next-step")
        told = page.inner_text(".tour p")
        assert told.startswith(("Correct.", "No: "))
        assert not re.search("NaN|undefined", told)
        page.keyboard.press("Enter")  # the next button has the focus
    assert chapters == ["touch"] * 3 + ["gaps", "where", "order", "fooled"]
    assert len(re.findall(r"\d+\s%", page.inner_text(".tour p"))) >= 4
    page.keyboard.press("Enter")
    page.wait_for_selector(".tour", state="detached")
    page.wait_for_function("location.search.includes('stage=relu')")
