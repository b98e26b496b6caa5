"""The chapters of Explore in a real Chromium, used as a person uses them."""

import json

import pytest

from omnivat.head.heads import EXAMPLES

from .conftest import DESK
from .first_view import LOOK
from .gestures import COLOURS, READY, TOUCH, WHERE, faults, go, grab, pixels, pull, settle

pytestmark = pytest.mark.browser
SAID = ".explore .twin .said"
WHOLE = """of => [...document.querySelectorAll(of)].filter((one) => {
  const { top, bottom, left, right, height } = one.getBoundingClientRect();
  return height && top >= 0 && bottom <= innerHeight && left >= 0 && right <= innerWidth;
}).length"""


FIRST = {  # what a chapter shows last
    "touch": SAID,
    "gaps": ".explore .tree-of-pair",
    "where": ".explore .places button",
    "order": ".explore .wave path",
    "fooled": ".explore .lookers .thumb",
}


@pytest.fixture(scope="module")
def twins():
    """Return what the heads predict of the twins."""
    return json.loads((EXAMPLES / "twins.json").read_text(encoding="utf-8"))


def said(page):
    """Return the verdict under each picture."""
    return [one.replace("\xa0", " ") for one in page.locator(SAID).all_inner_texts()]


def percents(page):
    """Return the share at each bar of the first chapter, then the large one."""
    shown = page.locator(".explore .twin output").all_inner_texts()
    return [one.replace("\xa0", " ") for one in [*shown, page.inner_text(".explore .touch .large")]]


def percent(share):
    """Return a share as the page writes it."""
    return f"{int(100 * share + 0.5)} %"


def pressed(page):
    """Return the number of the chosen press among those shown."""
    return int(page.get_attribute(".explore .presses [aria-checked=true]", "data-key"))


def verdicts(page, twins, source, dots, rung):
    """Return what heads of one source read in each touch of the chosen press."""
    press = pressed(page)
    truth = twins["shown"][press]["class"]
    read = twins["verdicts"]["touch"][source][dots][rung][8 * press : 8 * press + 8]
    return [f"{'✓' if int(k) == truth else '✗'} {twins['classes'][int(k)]}" for k in read]


@pytest.fixture
def touch(visit):
    """Return the first chapter as it opens."""
    return visit("?chapter=touch")


def test_the_page_opens_with_one_press_by_eight_sensors_and_a_verdict_under_each(visited, twins):
    touch = visited  # as it was opened, without a chapter in its address
    assert touch.get_attribute(".explore", "data-chapter") == "touch"
    assert said(touch) == verdicts(touch, twins, 0, 0, 0)
    shares = [one[0] for one in twins["accuracy"]["touch"][0][0][0]]
    assert percents(touch) == [
        percent(share) for share in [*shares, twins["away"]["touch"][0][0][0][0]]
    ]
    assert "Simulated data." in touch.inner_text(".explore .from-where")


def test_the_pictures_of_a_press_are_in_view_at_once_and_nothing_is_wider_than_the_window(visit):
    page = visit(TOUCH, SAID)
    for size in ((1280, 720), (1024, 768), (1440, 900), (2560, 1440), (400, 800)):
        page.set_viewport_size(dict(zip(("width", "height"), size, strict=True)))
        settle(page)
        pictures = page.evaluate(WHOLE, ".explore .twin-pictures .tile")
        assert pictures >= (4 if size[0] == 400 else 9), size
        assert page.evaluate(WHOLE, ".explore .dots button") == 3, size
        assert page.evaluate("document.scrollingElement.scrollWidth <= innerWidth"), size
        seen = page.evaluate(LOOK)
        assert seen["words"] <= 150, size
        assert seen["smallest"] >= 14, size
        assert size[0] < 1280 or seen["map"] >= 0.35, size
        assert abs(seen["left"] - seen["right"]) <= 2, size
    page.set_viewport_size(DESK["viewport"])


def test_dots_and_pictures_combine_and_every_sensor_can_be_the_one_that_was_learned(touch, twins):
    touch.click(".explore .dots [data-key='1']")
    touch.click(".explore .known [data-key='20']")
    rung = 1 + twins["pictures"].index(20)
    for source, domain in enumerate(twins["domains"]):
        touch.select_option(".explore .touch .from", str(source))
        assert said(touch) == verdicts(touch, twins, source, 1, rung)
        assert percents(touch)[-1] == percent(twins["away"]["touch"][source][1][rung][0])
        home = touch.locator(".explore .twin.home")
        assert home.count() == 1
        assert domain["sensor"] in home.inner_text()
        assert home.locator("output").inner_text() in touch.inner_text(".explore .touch .figure")
    touch.click(".explore .given [data-key='vis']")
    assert not touch.is_visible(".explore .dots")  # a photo has none
    assert percents(touch)[-1] == percent(twins["away"]["photo"][source][0][rung][0])
    touch.click(".explore .given [data-key='fused']")
    for group in (".dots", ".known", ".given"):
        assert touch.locator(f".explore .touch {group} [aria-checked=true]").count() == 1
    assert percents(touch)[-1] == percent(twins["away"]["both"][source][1][rung][0])


def test_by_relief_the_pictures_are_grey_and_more_of_them_are_read_right(touch, twins):
    touch.click(".explore .dots [data-key='1']")
    colours = int(percents(touch)[-1].split()[0])
    assert touch.locator(".explore .twin .relief").count() == 0  # its sheet is not fetched yet
    touch.focus(".explore .dots [aria-checked=true]")
    touch.keyboard.press("ArrowRight")
    touch.wait_for_selector(".explore .dots [data-key=relief][aria-checked=true]:focus")
    assert said(touch) == verdicts(touch, twins, 0, 2, 0)
    assert percents(touch)[-1] == percent(twins["away"]["touch"][0][2][0][0])
    assert int(percents(touch)[-1].split()[0]) > colours
    assert "Nothing is known of the new sensor" in touch.inner_text(".explore .touch .remark")
    tiles = touch.locator(".explore .twin .relief")
    assert tiles.count() == 8
    assert ", as its relief" in touch.get_attribute(".explore .twin .tile", "aria-label")
    touch.click(".explore .known [data-key='200']")
    assert "20 pictures of the new sensor provide its lamps" in touch.inner_text(
        ".explore .touch .remark"
    )
    assert said(touch) == verdicts(touch, twins, 0, 2, 4)
    touch.click(".explore .given [data-key='vis']")
    assert tiles.count() == 0


def test_keys_choose_press_dots_and_pictures_and_a_focused_sensor_is_described(touch, twins):
    press = pressed(touch)
    touch.focus(".explore .presses [aria-checked=true]")
    touch.keyboard.press("ArrowRight")
    assert pressed(touch) == press + 1
    truth = twins["classes"][twins["shown"][press + 1]["class"]]
    assert touch.inner_text(".explore .object figcaption").startswith(truth)
    touch.focus(".explore .dots [aria-checked=true]")
    touch.keyboard.press("ArrowRight")
    touch.wait_for_selector(".explore .dots [data-key='1'][aria-checked=true]:focus")
    touch.focus(".explore .twin[data-domain='4']")
    assert touch.inner_text(".explore .twin-pictures .legend") == twins["domains"][4]["about"]


def test_an_audit_finds_no_fault_in_a_chapter_light_or_dark_and_its_first_view_has_few_words(
    new_page, address
):
    page = new_page((1280, 720))
    page.add_init_script("localStorage['omnivat-panels'] = '{}'")  # as on a first visit
    page.goto(address, wait_until="commit")
    page.wait_for_selector(READY["explore"])
    for chapter, shown in FIRST.items():
        go(page, f"?chapter={chapter}")
        page.wait_for_selector(shown)
        page.evaluate("scrollTo(0, 0)")
        seen = page.evaluate(LOOK)
        assert faults(page) == [], chapter
        assert seen["words"] <= 150, chapter
        assert seen["smallest"] >= 14, chapter
        assert seen["map"] >= 0.4, chapter
        page.click(".ov.top .theme")
        settle(page)
        assert page.locator("body.dark").count() and faults(page, COLOURS) == [], chapter
        page.click(".ov.top .theme")


def test_every_press_is_threaded_and_points_glide_through_three_places(visit):
    page = visit(WHERE, ".explore .places button")
    drawn, figures = [], []
    for key in ("none", "mean", "spread"):
        page.click(f".explore .places [data-key='{key}']")
        settle(page)
        drawn.append(pixels(page, ".explore .threads"))
        figures.append(page.inner_text(".explore .stage .figure"))
    assert len(set(drawn)) == len(set(figures)) == 3
    page.click(".explore .kinds [data-key='umap']")
    settle(page)
    assert "map=umap" in page.url
    assert pixels(page, ".explore .threads") not in drawn
    page.focus(".explore .threads canvas + canvas")
    page.keyboard.press("n")
    page.wait_for_function("location.search.includes('press=')")
    page.click(".explore .sensors [data-domain='4']")
    assert page.locator(".explore .sensors [aria-pressed=true]").count() == 1


def test_what_is_lost_is_split_by_reading_and_by_look(visit, twins):
    from playwright.sync_api import expect

    loss = twins["split"]["loss"]
    for look, key in enumerate(("", "1", "relief")):
        page = visit(f"?chapter=where&dots={key}", '.explore.ready[data-chapter="where"]')
        if not page.is_visible(".split"):  # the page remembers an open panel
            page.click("[data-panel=split] summary")
        for key, reading in (("tac", "touch"), ("vis", "photo"), ("fused", "both")):
            page.click(f".split [data-key={key}]")
            cell = loss[reading][look if reading != "photo" else 0]
            shown = page.locator(".split output")
            home, away = (f"{int(cell[name][0] + 0.5)} %" for name in ("home", "away"))
            expect(shown.first).to_have_text(home, timeout=60_000)
            expect(shown.last).to_have_text(away, timeout=60_000)
            rows = page.locator(".split .who").all_inner_texts()
            assert ("another sensor" in rows) == (reading != "photo")
            assert ("another scene" in rows) == (reading != "touch")


def test_open_panels_scroll_in_their_column_and_the_page_has_no_empty_end(visit):
    page = visit("?chapter=fooled", ".explore .lookers .thumb")
    for panel in ("grid", "confusion"):
        if not page.locator(f"[data-panel={panel}][open]").count():
            page.click(f"[data-panel={panel}] summary")
    settle(page)
    assert page.evaluate("document.documentElement.scrollHeight - innerHeight") <= 0


def test_accuracy_is_drawn_as_far_as_p_was_dragged_and_the_sensors_only_at_the_end(visit):
    page = visit("?chapter=order", ".explore .wave path")
    line, wave = ".explore .over .own", ".explore .wave path"
    length = "one => one.getTotalLength()"
    first, turned = page.locator(line).evaluate(length), page.locator(wave).get_attribute("d")
    pull(page, grab(page, 0.8), 0.5)
    assert page.locator(line).evaluate(length) > first
    assert page.locator(wave).get_attribute("d") != turned
    assert page.locator(".explore .over .pale").count() == 0
    box = page.locator(".explore .order").bounding_box()
    pull(page, box, 0.0)
    pull(page, box, 1.0)
    page.mouse.up()
    assert page.locator(".explore .over .pale").count() == 1
