"""How else the page is met: offline, by touch, aloud, in few colours, enlarged, on a slow line."""

import re

import pytest

from .gestures import READY, go, settle

pytestmark = pytest.mark.browser
SAID = ".explore .announcement"
MARKS = ".explore .now .map canvas + canvas"


def chapter(page, name):
    """Open a chapter."""
    page.click(f'.explore .chapters [data-chapter="{name}"]')
    page.wait_for_selector(f'.explore.ready[data-chapter="{name}"]')
    settle(page)


def aloud(page, words):
    """Wait until the live region says something with these words; return it."""
    page.wait_for_function(
        "words => document.querySelector('.explore .announcement').textContent.includes(words)",
        arg=words,
    )
    return page.text_content(SAID)


def test_without_a_connection_no_chapter_shows_figures_of_another_and_it_opens_when_it_is_back(
    visited,
):
    go(visited, "?chapter=fooled")
    visited.held = True  # without a connection it never settles
    visited.context.set_offline(True)
    visited.click('.explore .chapters [data-chapter="order"]')
    visited.wait_for_selector(".top .lost:has-text('does not respond')")
    assert not visited.locator(".explore .stage .title >> visible=true").count()
    assert visited.text_content(SAID) == ""
    visited.context.set_offline(False)
    visited.held = False
    visited.wait_for_selector('.explore.ready[data-chapter="order"] .figure:has-text("32")')
    settle(visited)
    assert visited.is_hidden(".top .lost")
    assert "for p = 0.80" in visited.inner_text(".explore .lead .provenance").replace("\xa0", " ")


def test_the_document_has_the_name_of_what_is_open(visited):
    chapter(visited, "analyse")
    assert visited.title() == "Analyse · OmniVaT"
    visited.click("#view-pair-button")
    visited.wait_for_function("document.title === 'Try a pair · OmniVaT'")
    visited.click("#view-explore-button")
    visited.wait_for_function("document.title === 'Analyse · OmniVaT'")


def test_keys_speak_of_the_pair_and_p_of_both_gaps_and_every_stair_has_a_name(visited):
    chapter(visited, "analyse")
    visited.focus(MARKS)
    visited.keyboard.press("n")
    assert re.fullmatch(
        r"Pair \d+, \w+, [\w. ()-]+, predicted as \w+, (correct|wrong)", aloud(visited, "Pair")
    )
    visited.keyboard.press("Enter")
    aloud(visited, ", pinned")
    visited.focus(".explore .order")
    visited.keyboard.press("ArrowRight")
    assert "modality gap 0." in aloud(visited, "domain gap 0.")
    names = visited.locator(".explore .treads output").evaluate_all(
        "all => all.map((one) => [one.role, one.ariaLabel])"
    )
    assert [role for role, _ in names] == ["img"] * 6
    assert names[0][1].startswith("Modality gap after the embedding: 0.")


# of the elements that fit, the colours that differ from what is around them
SHOWN = """of => [...document.querySelectorAll(`.ov.explore ${of}`)].filter((one) =>
  one.checkVisibility()).map((one) => {
    const [own, around] = [one, one.parentElement].map((e) => getComputedStyle(e));
    return own.backgroundColor !== around.backgroundColor || own.stroke !== around.backgroundColor;
  })"""


def test_in_forced_colours_what_is_chosen_bars_keys_and_lines_are_visible(visited):
    visited.emulate_media(forced_colors="active")
    for name, parts in {
        "touch": [".segments [aria-checked=true]", ".chapters [aria-current=page]", ".scale .fill"],
        "fooled": [".readings .range", ".readings [aria-checked=true]"],
        "order": [".over .now", ".wave path"],
        "where": [".sensors i"],
    }.items():
        go(visited, f"?chapter={name}")
        visited.wait_for_selector(READY["explore"])
        for part in parts:
            seen = visited.evaluate(SHOWN, part)
            assert seen and all(seen), (name, part)
    colours = visited.locator(".explore .sensors i").evaluate_all(
        "all => new Set(all.map((one) => getComputedStyle(one).backgroundColor)).size"
    )
    assert colours == 8


def test_enlarged_no_part_is_squeezed_or_lies_on_another(visit):
    for name, part in {"touch": ".twin .tile", "where": ".threads", "order": ".map"}.items():
        page = visit(f"?chapter={name}", READY["explore"])
        page.set_viewport_size({"width": 640, "height": 360})
        settle(page)
        box = page.locator(f".explore {part} >> visible=true").first.bounding_box()
        assert min(box["width"], box["height"]) >= (60 if name == "touch" else 200), name
        assert page.evaluate("document.scrollingElement.scrollWidth <= innerWidth")
        title = page.locator(".explore .title >> visible=true").bounding_box()
        presses = page.locator(".explore .presses >> visible=true")
        for other in [presses.bounding_box()] if presses.count() else []:
            assert title["y"] + title["height"] <= other["y"] + 1


# letters and the box that holds them, both in CSS pixels
SIZE = "one => parseFloat(getComputedStyle(one).fontSize)"
FITS = """one => { const box = one.getBoundingClientRect();
  return one.scrollWidth <= one.clientWidth + 1 && box.right <= innerWidth
    && box.bottom <= innerHeight; }"""


def test_a_lecture_enlarges_what_is_said_and_leaves_map_chart_and_control(visited):
    page = visited
    for width, height in ((1280, 720), (1920, 1080)):
        page.set_viewport_size({"width": width, "height": height})
        go(page, "?chapter=touch")
        small = page.locator(".explore .from-where").evaluate(SIZE)
        page.keyboard.press("f")
        large = page.locator(".explore .touch .large")
        assert large.evaluate(SIZE) >= 110
        assert large.evaluate(FITS)
        assert page.locator(".explore .twin figcaption").first.evaluate(SIZE) >= 17 * width / 1280
        assert page.locator(".explore .from-where").evaluate(SIZE) <= small
        page.keyboard.press("f")
        chapter(page, "order")
        page.keyboard.press("f")
        assert page.locator(".explore .order-bar label").evaluate(FITS)
        assert page.locator(".explore .ride label").evaluate(SIZE) >= 24
        for there in (".map", ".over svg", ".order"):
            assert page.locator(f".explore {there} >> visible=true").count()
        assert not page.locator(".explore .panels >> visible=true").count()
        page.keyboard.press("f")


def test_on_a_slow_line_every_empty_place_has_a_word(open_page):
    page = open_page("?chapter=touch", READY["explore"])
    client = page.context.new_cdp_session(page)
    slow = {"offline": False, "latency": 50, "downloadThroughput": 1e5, "uploadThroughput": 1e5}
    client.send("Network.enable")
    client.send("Network.setCacheDisabled", {"cacheDisabled": True})
    client.send("Network.emulateNetworkConditions", slow)
    page.held = True  # until the line is fast again
    page.click('.explore .chapters [data-chapter="analyse"]')
    page.wait_for_selector(".explore .map-wait >> visible=true")
    assert "on its way" in page.inner_text(".explore .map-wait")
    fast = {**slow, "downloadThroughput": -1, "uploadThroughput": -1}
    client.send("Network.emulateNetworkConditions", fast)
    page.wait_for_selector('.explore.ready[data-chapter="analyse"]')
    page.wait_for_selector(".explore .map-wait", state="hidden")
    assert page.is_hidden(".explore .wait")


def test_an_address_of_a_pair_that_is_not_there_shows_no_other_picture(visit):
    page = visit("?view=pair&vis=image:0123456789abcdef&tac=row:99999", ".pair .slot .what")
    settle(page)
    words = page.locator(".pair .slot .what").all_inner_texts()
    assert words == ["A picture from an earlier visit", "This set has no pair 99999."]
    assert not page.locator(".pair .slot .picture .thumb").count()
