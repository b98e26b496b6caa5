"""Tree, Compare, Data and Train: one journey for each action."""

import re
from collections.abc import Callable
from typing import Any

import pytest

from .gestures import open_tab

pytestmark = pytest.mark.browser


def test_the_tree_follows_p_and_tells_which_nodes_are_constant(open_page: Callable[..., Any]) -> None:
    page = open_page("?view=tree&vis=row:0&tac=row:0")
    page.wait_for_selector(".tree .tree-view")
    assert page.locator(".tree .tree-view .disc").count() == 7
    page.wait_for_selector(".tree .worth:has-text('nodes')")
    told = page.locator(".tree .worth").inner_text()
    number = re.search(r"(\d) of 7 nodes \(dashed\)", told)
    assert page.locator(".tree .disc.fixed").count() == (int(number[1]) if number else 0)
    assert "(learned)" in page.locator(".tree .whose").inner_text()
    before = page.locator(".tree .matrices").text_content()
    page.focus(".tree .order")
    for _ in range(20):
        page.keyboard.press("ArrowRight")
    page.wait_for_function("before => document.querySelector('.tree .matrices').textContent !== before", arg=before)
    assert "what-if" in page.locator(".tree .whose").inner_text()


def test_compare_starts_at_the_learned_p_and_counts_what_changes(open_page: Callable[..., Any]) -> None:
    page = open_page("?view=compare")
    page.wait_for_selector(".compare .moved:has-text('predictions change')")
    text = page.locator(".compare .moved").inner_text().replace(",", "")
    changed, everything = (int(n) for n in re.search(r"(\d+) of (\d+)", text).groups())
    parts = [int(n) for n in re.findall(r"(\d+) (?:corrected|broken|still)", text)]
    assert "nearest class mean" in text
    assert changed == sum(parts) > 0
    assert everything > changed
    sides = page.locator(".compare .order").evaluate_all("all => all.map((one) => one.value)")
    assert sides[0] == sides[1]


def test_compare_links_two_maps(open_page: Callable[..., Any]) -> None:
    page = open_page("?view=compare")
    page.wait_for_selector(".compare .moved:has-text('predictions change')")
    before = [
        canvas.evaluate("c => c.toDataURL()") for canvas in page.query_selector_all(".compare .map canvas:first-child")
    ]
    page.focus(".compare .map canvas + canvas")
    page.keyboard.press("+")
    page.wait_for_function(
        """before => [...document.querySelectorAll('.compare .map canvas:first-child')]
             .every((canvas, i) => canvas.toDataURL() !== before[i])""",
        arg=before,
    )


def test_scores_from_source_to_target_are_shown_by_two_measures(open_page: Callable[..., Any]) -> None:
    page = open_page("?view=compare")
    page.click(".compare details.every summary")
    page.wait_for_selector(".scores tbody tr")
    accuracy = page.locator(".scores tbody").inner_text()
    page.click('.matrix [data-key="1"]')
    assert page.locator(".scores tbody").inner_text() != accuracy


def test_simulated_data_say_so(open_page: Callable[..., Any]) -> None:
    page = open_page("?view=data")
    page.wait_for_selector(".data .note")
    assert "Simulated" in page.locator(".data .note").inner_text()
    assert page.locator(".top .badge").is_visible()


def test_a_head_is_trained_scrubbed_used_and_saved(open_page: Callable[..., Any]) -> None:
    page = open_page("?view=train")
    page.wait_for_selector(".train .go")
    page.click(".train .choices details summary")
    page.select_option(".train [name=width]", "16")
    page.fill(".train [name=epochs]", "6")
    page.uncheck(".train [name=lang]")
    page.click(".train .go")
    page.wait_for_selector(".train .status:has-text('Done: 6 epochs')", timeout=120_000)
    assert page.locator(".train .both .charts figure").count() == 6
    assert page.evaluate(
        "Math.min(...[...document.querySelectorAll('.train .charts text')].map((t) => "
        "parseFloat(getComputedStyle(t).fontSize) * t.getScreenCTM().a)) >= 11"
    )
    last = page.evaluate("document.querySelector('.train .map canvas').toDataURL()")
    page.focus(".train .scrubber input")
    for _ in range(4):
        page.keyboard.press("ArrowLeft")
    assert page.locator(".train .scrubber output").inner_text() == "2 of 6"
    page.wait_for_function("last => document.querySelector('.train .map canvas').toDataURL() !== last", arg=last)
    with page.expect_download() as saved:
        page.click(".train .save")
    assert saved.value.path().read_bytes()[:2] == b"PK"
    page.click(".train .use")
    page.wait_for_url("**/?set=*")
    page.wait_for_selector(".ov.explore:visible")
    page.wait_for_selector(".explore .modes [data-key=moved][aria-checked=true]")
    open_tab(page, "data")
    page.wait_for_selector(".data .facts:has-text('D = 16')")


def test_a_training_can_be_cancelled(open_page: Callable[..., Any]) -> None:
    page = open_page("?view=train")
    page.wait_for_selector(".train .go")
    page.click(".train .choices details summary")
    page.select_option(".train [name=width]", "16")
    page.uncheck(".train [name=lang]")
    page.fill(".train [name=epochs]", "100")
    page.click(".train .go")
    page.wait_for_selector(".train .status:has-text('Training: epoch')", timeout=60_000)
    page.click(".train .stop")
    page.wait_for_selector(".train .status:has-text('Cancelled after')", timeout=60_000)
    assert page.locator(".train .go").is_enabled()


def test_a_set_of_signals_offers_neither_camera_nor_sensor(open_page: Callable[..., Any]) -> None:
    page = open_page("?set=chirps&tab=pair")
    page.wait_for_selector(".pair .of-signals:visible")
    page.wait_for_selector(".pair .slot .where:visible")
    for gone in (".slot .camera", ".cameras", ".panel.sensor"):
        assert page.locator(f".pair {gone}").count()
        assert not page.locator(f".pair {gone} >> visible=true").count()
