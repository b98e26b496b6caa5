"""Links, history, several visitors, no network, and a server that crashes and restarts."""

import pytest

from .conftest import watched
from .gestures import (
    ANSWERED,
    MAP,
    READY,
    SLOT,
    WHERE,
    choose,
    go,
    grab,
    holds,
    open_tab,
    p_shown,
    pixels,
    pull,
    settle,
    texture,
)

pytestmark = pytest.mark.browser


def test_the_tab_of_a_link_opens_even_where_gradio_loses_the_first_clicks(new_page, address):
    page = new_page()
    page.add_init_script("""{
            const click = HTMLElement.prototype.click;
            let lost = 0;
            HTMLElement.prototype.click = function () {
                if (this.getAttribute("role") !== "tab" || ++lost > 2) click.call(this);
            };
        }""")
    page.goto(f"{address}?view=train", wait_until="commit")
    page.wait_for_selector("#view-train .go:visible")
    page.click("#view-explore-button")
    page.wait_for_selector(READY["explore"])


def test_nothing_but_maps_waits_for_a_map_that_takes_long(new_page, address):
    page = new_page()
    ready = []
    step = {"step": {"done": 1, "total": 9, "text": "p = 0.1"}, "ready": False}
    page.route(
        "**/omnivat/frames*",
        lambda route: route.continue_() if ready else route.fulfill(status=202, json=step),
    )
    page.goto(f"{address}?view=pair&chapter=analyse", wait_until="commit")
    page.wait_for_selector(".top .badge:visible")
    page.wait_for_selector(ANSWERED)
    assert not page.is_visible(".pair .on-map")
    open_tab(page, "explore")
    assert "1 of 9" in page.inner_text(".explore .wait")
    ready.append(True)
    page.wait_for_selector(MAP)
    open_tab(page, "pair")
    page.wait_for_selector(".pair .on-map canvas")
    page.click(".top .badge")
    page.wait_for_selector(".top .limits:has-text('Map positions')")


def test_an_address_brings_what_one_visitor_set_to_another(visit, open_page):
    page = visit("?mode=moved&pin=3", MAP)
    plain = pixels(page)
    page.click('[data-stage="f_bar"]')
    page.select_option(".explore .colouring", "modality")
    page.uncheck('[data-kind="class"][data-name="wood"] input')
    page.focus(".explore .order")
    page.keyboard.press("Home")
    for _ in range(4):
        page.keyboard.press("ArrowRight")
    page.wait_for_function("location.search.includes('p=0.04')")
    page.mouse.move(1, 1)
    drawn = pixels(page)
    assert drawn != plain
    other = open_page(page.evaluate("location.search"), MAP, locale="en-GB")
    assert p_shown(other) == "0.04"
    assert pixels(other) == drawn
    assert other.inner_text(".explore .card h3").startswith("Pair 3")


def test_back_steps_through_chapters_and_from_another_page_to_what_was_left_in_the_chosen_theme(
    visit, address
):
    page = visit(WHERE, READY["explore"])
    page.click('.explore [data-chapter="order"]')
    page.wait_for_selector(f'.explore[data-chapter="order"] {MAP.removeprefix(".explore ")}')
    page.go_back(wait_until="commit")
    page.wait_for_selector('.explore[data-chapter="where"]')
    page.go_forward(wait_until="commit")
    page.wait_for_selector('.explore[data-chapter="order"]')
    settle(page)
    steps = page.evaluate("history.length")
    pull(page, grab(page), 0.85, steps=20)
    page.mouse.up()
    left = p_shown(page)
    page.wait_for_function(f"location.search.includes('p={float(left):g}')")
    assert page.evaluate("history.length") == steps  # a drag leaves no step
    was = page.evaluate("document.body.classList.contains('dark')")
    page.click(".ov.top .theme")
    page.goto(address + "omnivat/about")
    page.go_back(wait_until="commit")
    page.wait_for_selector(MAP)
    page.wait_for_function(
        "p => document.querySelector('.explore .order-value')?.textContent === p", arg=left
    )
    before = pixels(page)
    page.focus(".explore .order")
    page.keyboard.press("ArrowLeft")
    assert pixels(page) != before  # alive, not a picture of itself
    assert page.evaluate("document.body.classList.contains('dark')") is not was
    page.click(".ov.top .theme")  # this profile is shared


def test_back_to_an_address_restores_its_selection(visit):
    page = visit("?chapter=analyse&sel=0.3", READY["explore"])
    page.wait_for_selector(".explore .pictures .clear")
    go(page, "?chapter=analyse")
    page.wait_for_selector(".explore .pictures .clear", state="detached")
    page.go_back(wait_until="commit")
    page.wait_for_selector(".explore .pictures .clear")
    assert page.inner_text(".explore .pictures h4").startswith("4 ")


def test_a_page_that_nobody_touches_draws_no_frames(new_page, address):
    page = new_page()
    page.add_init_script("""const frame = window.requestAnimationFrame;
        window.drawn = 0;
        window.requestAnimationFrame = (draw) => { window.drawn++; return frame(draw); };""")
    page.goto(address)
    page.wait_for_selector("body[data-ready]")
    still = """() => {
        const before = window.drawn;
        return new Promise((done) => setTimeout(() => done(window.drawn === before), 400));
    }"""
    assert any(page.evaluate(still) for _ in range(20))


def test_the_watch_for_outside_requests_sees_one(desktop, address):
    problems = []
    page = watched(desktop.browser.new_page(bypass_csp=True), address, problems)
    page.goto(address + "omnivat/about")
    page.evaluate("fetch('http://elsewhere.invalid/').catch(() => 0)")
    page.close()
    assert problems == ["outside request: http://elsewhere.invalid/"]


def test_a_camera_gives_a_picture_that_is_answered(visit):
    page = visit("?view=pair&vis=row:0&tac=row:0", ANSWERED)
    slot = SLOT.format("tac")
    page.click(f"{slot} .camera")
    page.wait_for_function("document.querySelector('.pair .slot video')?.videoWidth > 0")
    page.click(f"{slot} button:has-text('Take it')")
    holds(page, "tac", "camera")
    page.wait_for_selector(ANSWERED)
    assert page.evaluate("document.querySelector('.pair .slot video')") is None


def test_a_killed_server_is_told_of_the_drag_goes_on_and_a_new_server_gets_the_images_again(
    visit, server
):
    visit("?chapter=analyse", MAP)
    page = visit("?view=pair&chapter=analyse&vis=row:0&tac=row:0", ANSWERED)
    page.held = True  # without a server it never settles
    choose(page, "tac", texture(4))
    page.wait_for_function("location.search.includes('tac=image')")
    page.wait_for_selector(ANSWERED)
    server.stop()
    choose(page, "vis", texture(5))
    page.wait_for_selector(".top .lost:has-text('does not respond')")
    open_tab(page, "explore")
    before = pixels(page)
    pull(page, grab(page), 0.9)
    page.mouse.up()
    assert pixels(page) != before
    server.start()
    open_tab(page, "pair")
    holds(page, "vis", "5.png · 96 × 96")
    page.wait_for_selector(ANSWERED)
    page.wait_for_selector(".pair .bars td[data-reading=vis]", state="attached")
    assert page.is_hidden(".pair .problem") and page.is_hidden(".top .lost")


def test_a_server_started_again_with_another_head_is_told_of_and_not_mixed_in(visit):
    page = visit("?view=pair&vis=row:0&tac=row:0", ANSWERED)

    def as_another(route):
        answer = route.fetch()
        route.fulfill(response=answer, headers={**answer.headers, "x-holds": "another"})

    page.route("**/omnivat/pair*", as_another)
    page.held = False  # every reply comes
    page.click(f"{SLOT.format('vis')} .clear")
    page.wait_for_selector(".pair .problem:has-text('another head or set. Reload the page')")
    page.unroute("**/omnivat/pair*")
