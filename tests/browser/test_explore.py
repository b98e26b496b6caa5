"""Explore's story in a real Chromium: modes of p, staircase, unseen domains, toy, finder."""

import pytest

from app.shared.tables import tables
from omnivat.data.domains import DOMAINS
from omnivat.head.heads import EXAMPLES
from omnivat.maps.frames import read_frames

from .gestures import MAP, MOVED, TOOLS, grab, open_tab, pixels, place_of_a_point, pull, settle

pytestmark = pytest.mark.browser


def words(page, selector):
    """Return the text of the first element of Explore that matches."""
    text = page.inner_text(f".explore {selector}")
    return text.replace("\xa0", " ")


PLACE = "JSON.stringify(document.querySelector('.explore').getBoundingClientRect())"


@pytest.fixture
def early(new_page, address):
    """Return a function that opens a page at a size; what it gives lets Gradio's script come."""

    def opened(query, size):
        page, held = new_page(size), []
        page.route("**/assets/index-*.js", lambda route: held.append(route))
        page.goto(address + query, wait_until="commit")
        page.wait_for_selector(".explore.ready")
        assert not page.locator("#view-explore-button, body[data-ready]").count()
        return page, lambda: held[0].continue_()

    return opened


def test_a_chapter_is_there_before_gradio_and_nothing_moves_or_is_lost_when_gradio_comes(early):
    page, come = early("?chapter=gaps&map=pca", (1280, 720))
    page.wait_for_selector(MAP)
    opened = page.get_attribute(MAP, "data-order")
    moved = "old => document.querySelector('.explore .map').dataset.order !== old"
    page.focus(".explore .order-bar [role=slider], .explore .order-bar input")
    page.keyboard.press("ArrowRight")
    page.wait_for_function(moved, arg=opened)
    box = grab(page, 0.4)
    come()
    page.wait_for_selector("#view-explore-button", state="attached")
    dragged = page.get_attribute(MAP, "data-order")
    pull(page, box, 0.6)
    page.wait_for_function(moved, arg=dragged)  # the drag goes on
    before = page.evaluate(PLACE), page.get_attribute(MAP, "data-order")
    focused = page.evaluate("document.activeElement.outerHTML")
    page.mouse.up()
    page.wait_for_selector("body[data-ready]")
    page.wait_for_selector("#omnivat-first", state="detached")
    assert page.locator("#view-explore .explore").is_visible()
    assert before == (page.evaluate(PLACE), page.get_attribute(MAP, "data-order"))
    assert page.evaluate("document.activeElement.outerHTML") == focused
    page.keyboard.press("ArrowRight")
    page.wait_for_function(moved, arg=before[1])


def test_on_a_phone_nothing_moves_and_limits_that_are_open_stay_open_when_gradio_comes(early):
    page, come = early("?chapter=where", (400, 720))
    scrolled = "document.querySelector('.explore .chapters').scrollLeft"
    assert page.evaluate(scrolled) > 0
    page.click(".top .badge:has-text('simulated data')")
    page.wait_for_selector(".top .limits >> visible=true")
    before = page.evaluate(PLACE)
    come()
    page.wait_for_selector("#omnivat-first", state="detached")
    assert page.is_visible(".top .limits") and page.evaluate(PLACE) == before
    assert page.evaluate(scrolled) > 0


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
    page.wait_for_selector(".explore [data-panel=step] .map-title:has-text('photo–touch cosine')")
    pixels(page)  # the last move of the mouse is drawn
    settle(page)
    assert "range=" in page.url
    found = page.inner_text(".explore .finder .found")
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
    page.fill(".explore .finder input[type=search]", "wood")
    page.wait_for_selector(f".explore .finder .found:not(:text-is('{found}'))")


def test_the_first_mode_is_a_head_for_each_stop_and_the_other_a_what_if_with_a_learned_p(visit):
    frames = read_frames(EXAMPLES / "retrained.bin")
    share = frames.curves["seeds:accuracy/unseen/mean"][frames.orders.index(0.5)]
    page = visit(f"{TOOLS}&map=pca&p=0.5")
    right = f"{100 * share:.0f} %"
    assert (
        f"{right} correct in seven unseen domains\n\nMeasured with 2 heads for p = 0.50"
        in words(page, ".score")
    )
    assert page.get_attribute(".explore .curves [data-name=accuracy] .spread", "d")
    page.click('.explore .modes [data-key="moved"]')
    page.wait_for_selector(".explore[data-kind=moved]")
    assert page.locator(".explore .curves .band").count() == 4
    assert not page.locator(".explore .curves [data-name=accuracy] .spread").count()
    page.wait_for_function("location.search.includes('mode=moved')")
    page.click(".explore .learned")  # a stop of its own, and no round one
    learned = read_frames(EXAMPLES / "frames.bin").head["learned_order"]
    order = "document.querySelector('.explore .map').dataset.order"
    page.wait_for_function(f"learned => Math.abs({order} - learned) < 1e-9", arg=learned)


def test_every_step_of_the_staircase_has_its_figures_and_opens_its_map(visit):
    frames = read_frames(EXAMPLES / "frames.bin")
    page = visit(f"{MOVED}&p=0.3")
    stop = frames.orders.index(0.3)
    for stage in ("raw", "frft", "relu", "f_bar", "f_hat"):
        for name in ("modality_gap", "domain_gap", "margin"):
            page.select_option(".explore .of-steps", name)
            value = frames.curves[f"{name}/{stage}"][stop]
            shown = words(page, f'.stair[data-name="{name}"] [data-step="{stage}"]')
            assert shown == f"{value:.2f}".replace("-0.00", "0.00") or shown == f"{value:.2f}"
        page.click(f'.explore [data-stage="{stage}"]')
        page.wait_for_selector(f'.explore [data-stage="{stage}"][aria-checked=true]')
    page.wait_for_function("!location.search.includes('stage=')")


def test_strangers_have_a_bar_each_a_reading_its_map_and_a_cell_of_the_matrix_filters_it(visit):
    frames = read_frames(EXAMPLES / "frames.bin")
    page = visit("?chapter=fooled", ".explore .bar-row")
    assert page.locator(".explore .bar-row .range").count() >= len(frames.domains)
    assert page.locator(".explore .bar-row.source").count() == 1
    figures, drawn = set(), []
    for reading in ("vis", "tac", "fused"):
        page.click(f'.explore .readings [data-key="{reading}"]')
        assert "–" in words(page, '.readings [aria-checked="true"] small')
        figures.add(tuple(page.locator(".explore .bar-row output").all_inner_texts()))
        drawn.append(pixels(page))
    assert len(figures) == len(set(drawn)) == 3  # the points of a reading, by what is read in them
    page.click('.explore .readings [data-key="vis"]')
    assert pixels(page) == drawn[0]
    page.click('.explore .readings [data-key="fused"]')
    cell = page.locator(".explore .confusion button:not(:disabled)").first
    count = int(cell.inner_text())
    cell.click()
    page.wait_for_function("location.search.includes('cell=')")
    page.wait_for_selector(f".explore .pictures h4:has-text('{2 * count} points selected')")
    assert page.locator(".explore .pictures .tiles button").count() == min(count, 60)
    page.locator('.explore .confusion [aria-pressed="true"]').click()
    page.wait_for_selector(".explore .pictures h4:has-text('look like another class')")


def test_on_the_toy_the_transform_keeps_the_distance_and_the_relu_does_not(visit):
    page = visit(f"{MOVED}&p=0.1", ".explore .toy .plane path")
    before = [words(page, f".toy .{name}") for name in ("d-turned", "d-clipped", "g-clipped")]
    page.focus(".explore .order")
    for _ in range(6):
        page.keyboard.press("PageUp")
    after = [words(page, f".toy .{name}") for name in ("d-turned", "d-clipped", "g-clipped")]
    assert after[0] == before[0]
    assert after[2] != before[2]


def test_a_filter_changes_title_and_curves_alike_and_the_title_names_the_method(visit):
    frames = read_frames(EXAMPLES / "frames.bin")
    lone, others = frames.domains[1], [n for i, n in enumerate(frames.domains) if i != 1]
    page = visit(f"{MOVED}&p=0.3&domain={'~'.join(others)}")
    value = frames.curves[f"modality_gap/f_hat/{lone}"][frames.orders.index(0.3)]
    assert words(page, ".curves [data-name=modality_gap] output") == f"{value:.3f}"
    assert f"modality gap in {DOMAINS['OF Real'].title} {value:.2f}" in words(
        page, "[data-panel=step] .map-title"
    )
    assert DOMAINS["OF Real"].title in words(page, ".curves [data-name=modality_gap] .of")
    assert words(page, "[data-panel=step] .map-title small") == "UMAP"
    assert "Ignore distances and scale." in words(page, ".approximate")


def test_one_head_for_every_order_is_a_mode_and_its_curves_follow_p(visit):
    frames = read_frames(EXAMPLES / "every.bin")
    for order in (0.2, 0.8):
        page = visit(f"{TOOLS}&mode=every&map=pca&p={order}&pin=9", f'{MAP}[data-order="{order}"]')
        modes = page.locator(".explore .modes [data-key]")
        shown = modes.evaluate_all("all => all.map((one) => one.dataset.key)")
        assert shown == [row["id"] for row in tables()["modes"]]
        shown = page.text_content(".explore .curves [data-name=accuracy] output")
        value = frames.curves["accuracy/unseen"][frames.orders.index(order)]
        assert shown.replace("\xa0", " ") == f"{100 * value:.1f} %"
        assert "One head for every p" in page.inner_text(".explore .mode-words")
        page.wait_for_selector(".card .near h4:has-text('raw embedding')")  # of another head


def test_the_pictures_of_a_pair_are_at_the_pointer_and_on_the_map_far_in(visit):
    page = visit(MOVED)
    x, _ = place_of_a_point(page)
    page.wait_for_selector(".explore .peek:visible")
    box = page.locator(".explore .peek").bounding_box()
    assert min(abs(box["x"] - x), abs(box["x"] + box["width"] - x)) < 40
    page.focus(".explore .map canvas + canvas")
    for _ in range(16):
        page.keyboard.press("+")
    page.wait_for_selector(".explore .map.pictured")
    page.mouse.move(1, 1)
    page.keyboard.press("0")


def test_a_link_of_a_forgotten_set_says_so_and_leads_home(new_page, address):
    page = new_page()
    page.goto(f"{address}?set=forgotten", wait_until="commit")
    page.wait_for_selector(".explore .wait.problem")
    assert "no longer has" in words(page, ".wait")
    assert not page.is_visible(".explore .order")
    open_tab(page, "pair")
    page.wait_for_selector(".pair .problem:has-text('no longer has')")
    open_tab(page, "explore")
    assert "set=" not in page.get_attribute(".explore .wait a", "href")
