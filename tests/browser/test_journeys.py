"""What a visitor does, in a real Chromium: one journey a tab, by mouse and by keyboard."""

import re
from collections.abc import Callable
from io import BytesIO
from typing import Any

import numpy as np
import pytest
from PIL import Image

pytestmark = pytest.mark.browser

MAP = ".explore .map[data-order]"


def texture(seed: int) -> dict[str, Any]:
    """Return a picture as a file to upload."""
    random = np.random.default_rng(seed)
    with BytesIO() as handle:
        Image.fromarray(random.integers(0, 255, (96, 96, 3), dtype=np.uint8)).save(handle, "PNG")
        return {"name": f"{seed}.png", "mimeType": "image/png", "buffer": handle.getvalue()}


def pixels(page: Any) -> str:
    """Return the map's points as they are drawn now, once drawing has settled."""
    return page.evaluate(
        """() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() =>
             done(document.querySelector('.explore .map canvas').toDataURL()))))"""
    )


def place_of_a_point(page: Any) -> tuple[float, float]:
    """Return where on the page some point is drawn: hover until the card shows a pair."""
    box = page.locator(".explore .map").bounding_box()
    for share in np.linspace(0.3, 0.7, 9):
        for height in np.linspace(0.3, 0.7, 9):
            at = box["x"] + share * box["width"], box["y"] + height * box["height"]
            page.mouse.move(*at)
            if "Pair" in page.locator(".explore .card h3").inner_text():
                return at
    raise AssertionError("no point was found on the map")


def test_dragging_p_changes_the_map_and_the_figures(open_page: Callable[..., Any]) -> None:
    page = open_page()
    page.wait_for_selector(MAP)
    before, gap = pixels(page), page.locator(".explore .curves output").first.inner_text()
    box = page.locator(".explore .order").bounding_box()
    page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    page.mouse.down()
    page.mouse.move(box["x"] + box["width"] * 0.8, box["y"] + box["height"] / 2, steps=5)
    page.mouse.up()
    assert pixels(page) != before
    assert page.locator(".explore .curves output").first.inner_text() != gap
    shown = page.locator(".explore .order-value").inner_text()
    page.wait_for_function(f"location.search.includes('p={float(shown):g}')")


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


def test_a_link_brings_back_what_was_seen(open_page: Callable[..., Any]) -> None:
    query = "?p=0.31&stage=relu&colour=class&domain=TAG-sim&pin=3"
    page = open_page(query)
    page.wait_for_selector(MAP)
    assert page.locator(".explore .order-value").inner_text() == "0.31"
    assert page.locator('[data-stage="relu"]').get_attribute("aria-checked") == "true"
    assert page.locator(".explore .colouring").input_value() == "class"
    assert not page.locator('[data-name="TAG-sim"] input').is_checked()
    assert page.locator(".explore .card h3").inner_text().startswith("Pair 3")


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


@pytest.mark.parametrize(
    ("name", "content", "wanted"),
    [
        ("notes.png", b"these are words, not pixels", "not an image"),
        ("empty.png", b"", "empty"),
        ("torn.png", texture(0)["buffer"][:500], "damaged"),
    ],
)
def test_a_bad_upload_is_one_sentence_and_the_page_stays_usable(
    open_page: Callable[..., Any], name: str, content: bytes, wanted: str
) -> None:
    page = open_page("?view=pair&vis=row:0&tac=row:0")
    page.wait_for_selector(".pair .bars table")
    chosen = '.pair .slot[data-modality="tac"] input[type=file]'
    page.set_input_files(chosen, {"name": name, "mimeType": "image/png", "buffer": content})
    page.wait_for_selector(".pair .problem:visible")
    text = page.locator(".pair .problem").inner_text()
    assert name in text
    assert wanted in text
    assert text.endswith(".")
    page.set_input_files(chosen, texture(5))
    page.wait_for_selector(".pair .problem", state="hidden")
    page.wait_for_function("location.search.includes('tac=image')")
    page.wait_for_selector(".pair .results[aria-busy=false] .bars table")


def test_one_image_alone_is_enough(open_page: Callable[..., Any]) -> None:
    page = open_page("?view=pair&vis=row:0&tac=row:0")
    page.wait_for_selector(".pair .bars table")
    page.click('.pair .slot[data-modality="vis"] .clear')
    page.wait_for_function("!document.querySelector('.pair .bars [data-voice=vis]')")
    assert page.locator(".pair .bars td[data-voice=tac]").count() > 1


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


def test_a_phone_shows_every_tab_without_scrolling_sideways(open_page: Callable[..., Any]) -> None:
    page = open_page("?vis=row:0&tac=row:0", viewport={"width": 400, "height": 800})
    page.wait_for_selector(MAP)
    for view in ("explore", "pair", "tree", "compare", "data"):
        page.evaluate(f"document.getElementById('view-{view}-button').click()")
        page.wait_for_selector(f".ov.{view}:visible")
        wide = page.evaluate(
            """view => Math.max(...[...document.querySelectorAll(`.ov.${view} .panel, .ov.${view} figure,
              .ov.${view} .map, .ov.${view} .order-bar, .ov.${view} button`)]
              .filter((e) => !e.closest('.gallery, .scroll')).map((e) => e.getBoundingClientRect().right))""",
            view,
        )
        assert wide <= 400, f"{view} reaches to pixel {wide}"


def test_two_visitors_do_not_disturb_one_another(open_page: Callable[..., Any]) -> None:
    one, two = open_page("?p=0.2"), open_page("?p=0.8")
    for page in (one, two):
        page.wait_for_selector(MAP)
    one.focus(".explore .order")
    one.keyboard.press("ArrowRight")
    assert one.locator(".explore .order-value").inner_text() == "0.21"
    assert two.locator(".explore .order-value").inner_text() == "0.80"


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


def test_a_killed_server_is_told_of_and_a_new_one_gets_the_images_again(
    chromium: Any, mortal_server: Any
) -> None:
    page = chromium.new_page()
    page.set_default_timeout(60_000)
    page.goto(mortal_server.address + "?view=pair&vis=row:0&tac=row:0")
    page.wait_for_selector(".pair .bars table")
    page.set_input_files('.pair .slot[data-modality="tac"] input[type=file]', texture(4))
    page.wait_for_function("location.search.includes('tac=image')")
    page.wait_for_selector(".pair .results[aria-busy=false] .bars table")
    mortal_server.stop()
    remove = '.pair .slot[data-modality="vis"] .clear'
    page.click(remove)
    page.wait_for_selector(".pair .problem:visible")
    assert "does not answer" in page.locator(".pair .problem").inner_text()
    mortal_server.start()
    page.set_input_files('.pair .slot[data-modality="vis"] input[type=file]', texture(6))
    page.wait_for_selector(".pair .bars td[data-voice=tac]")
    assert page.locator(".pair .problem").is_hidden()
    page.close()
