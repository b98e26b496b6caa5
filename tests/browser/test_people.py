"""Accessibility: keyboard only, screen readers, phones, large text, light and dark."""

import pytest

from app.shared.components import VIEWS

from .gestures import ANSWERED, COLOURS, MAP, READY, faults, open_tab, pixels, settle

pytestmark = pytest.mark.browser

PAIR = "?vis=row:0&tac=row:0&pin=3"


@pytest.fixture
def audited(visit):
    """Return the open page."""
    return visit(f"{PAIR}&chapter=analyse", MAP)


def test_an_audit_finds_nothing_wrong_with_any_tab(audited):
    for view in VIEWS:
        open_tab(audited, view)
        audited.wait_for_selector(READY[view])
        assert faults(audited) == [], view
    audited.evaluate("document.querySelector('#view-train .task').style.color = '#ccd'")
    assert any("contrast" in fault for fault in faults(audited, COLOURS))  # the audit can see
    audited.evaluate("document.querySelector('#view-train .task').style.color = ''")


@pytest.mark.long
def test_the_dark_page_has_contrast_enough_in_any_tab(audited):
    light = pixels(audited)
    audited.click(".ov.top .theme")
    assert pixels(audited) != light
    for view in VIEWS:
        open_tab(audited, view)
        audited.wait_for_selector(READY[view])
        assert faults(audited, COLOURS) == [], view
    audited.click(".ov.top .theme")


# every element that a mouse can use, and whether keys come to it; a group of radios is one stop
REACH = """view => {
  const root = document.getElementById(`view-${view}`);
  const label = (e) => e.getAttribute('aria-label') ?? e.textContent.slice(0, 30);
  const name = (e) => `${e.tagName}.${e.className?.baseVal ?? e.className} ${label(e)}`;
  const usable = [...root.querySelectorAll('button, select, input, summary, a[href], [tabindex]')]
    .filter((e) => !e.disabled && e.tabIndex >= 0
      && e.checkVisibility({ visibilityProperty: true }));
  const mute = [...root.querySelectorAll('[role=radio], button, select, input, summary')]
    .filter((e) => e.tabIndex < 0
      && !e.closest('[role=radiogroup], [role=tablist]'));  // arrow keys move inside
  window.toReach = new Set(usable);
  return { count: usable.length, mute: mute.map(name) };
}"""
PASSED = """() => {
  const now = document.activeElement;
  const style = getComputedStyle(now.closest('.choose') ?? now);
  const seen = now.matches(':focus-visible') && style.outlineStyle !== 'none'
    && parseFloat(style.outlineWidth) > 0;
  const wanted = window.toReach.delete(now);
  return { left: window.toReach.size, blind: wanted && !seen ? now.outerHTML.slice(0, 120) : null };
}"""


def test_the_tab_key_comes_to_everything_and_shows_where_it_is(visit):
    page = visit(PAIR)
    for view in VIEWS:
        open_tab(page, view)
        page.wait_for_selector(READY[view])
        settle(page)
        found = page.evaluate(REACH, view)
        assert found["count"] >= 2
        assert found["mute"] == []
        page.evaluate("view => document.getElementById(`view-${view}-button`).focus()", view)
        left, blind = found["count"], []
        for _ in range(found["count"] + 15):
            page.keyboard.press("Tab")
            at = page.evaluate(PASSED)
            left = at["left"]
            blind += [at["blind"]] if at["blind"] else []
            if not left:
                break
        assert page.evaluate("[...window.toReach].map((e) => e.outerHTML.slice(0, 120))") == []
        assert blind == []


def test_a_visitor_without_a_mouse_goes_from_tab_to_tab_and_chooses_a_pair(visit):
    page = visit("?chapter=analyse&vis=row:0&tac=row:0")
    page.focus("#view-explore-button")
    page.keyboard.press("Tab")
    page.keyboard.press("Enter")
    page.wait_for_selector(ANSWERED)
    page.focus(".pair .gallery button:nth-child(4)")
    page.keyboard.press("Enter")
    page.wait_for_selector(".pair .gallery button:nth-child(4)[aria-pressed=true]")
    page.wait_for_function(
        "!location.search.includes('row%3A0') && !location.search.includes('row:0')"
    )


def test_where_p_has_come_to_is_said_aloud(visit):
    page = visit("?mode=moved&p=0.3")
    page.focus(".explore .order")
    page.keyboard.press("ArrowRight")
    page.wait_for_selector(".explore .sr:has-text('p 0.31'):has-text('modality gap')")


HOVERED = """async () => {
  const parts = (text) => {
    const all = (text.match(/[\\d.]+/g) ?? [0, 0, 0, 0]).map(Number);
    return text.startsWith('color(') ? all.map((v, i) => (i < 3 ? 255 * v : v)) : all;
  };
  const over = ([r, g, b, a = 1], below) => [r, g, b].map((v, i) => a * v + (1 - a) * below[i]);
  const ground = (e) => (e ? over(parts(getComputedStyle(e).backgroundColor),
    ground(e.parentElement)) : [255, 255, 255]);
  const light = (rgb) => rgb.map((v) => v / 255).map((v) => (v <= 0.03928 ? v / 12.92
    : ((v + 0.055) / 1.055) ** 2.4))
    .reduce((sum, v, i) => sum + v * [0.2126, 0.7152, 0.0722][i], 0);
  const now = document.querySelector('[data-hovered]');
  const back = ground(now);
  const [high, low] = [light(over(parts(getComputedStyle(now).color), back)),
    light(back)].sort((a, b) => b - a);
  return (high + 0.05) / (low + 0.05);
}"""


KINDS = """view => {
  const seen = window.looks ??= new Map(); // of all views
  window.toHover = [];
  const parts = `#view-${view} :is(button, summary), .ov.top button`;
  for (const one of document.querySelectorAll(parts)) {
    if (one.disabled || !one.checkVisibility() || !one.textContent.trim()) continue;
    const style = getComputedStyle(one);
    const key = [one.className, style.color, style.backgroundColor, one.ariaPressed,
      one.ariaChecked].join();
    if (!seen.has(key)) window.toHover.push(one);
    seen.set(key, one);
  }
  return window.toHover.map((one) => one.outerHTML.slice(0, 90));
}"""
NEXT = """n => {
  document.querySelector('[data-hovered]')?.removeAttribute('data-hovered');
  window.toHover[n].dataset.hovered = '';
}"""


def faint(page, view):
    """Return the buttons of a view, one of each look, whose text is too faint under the pointer."""
    found, names = [], page.evaluate(KINDS, view)
    for theme in ("dark", "light"):
        page.evaluate("dark => document.body.classList.toggle('dark', dark)", theme == "dark")
        for number, name in enumerate(names):
            page.evaluate(NEXT, number)
            page.locator("[data-hovered]").hover(force=True)
            if (ratio := page.evaluate(HOVERED)) < 4.5:
                found.append(f"{theme} {name}: {ratio:.2f}")
    return found


def test_a_button_under_the_pointer_can_be_read_pressed_or_not(open_page):
    page = open_page("?chapter=analyse&beside=1&vis=row:0&tac=row:0", MAP)
    page.add_style_tag(content="* { transition: none !important; }")
    chapters = page.locator(".chapters [data-chapter]").evaluate_all(
        "all => all.map((one) => one.dataset.chapter)"
    )
    for chapter in chapters:
        page.click(f'.chapters [data-chapter="{chapter}"]')
        page.wait_for_selector(f'.explore[data-chapter="{chapter}"]')
        settle(page)
        assert faint(page, "explore") == [], chapter
    for view in VIEWS[1:]:
        open_tab(page, view)
        page.wait_for_selector(READY[view])
        settle(page)
        assert faint(page, view) == [], view
    page.evaluate("window.looks.clear()")
    page.add_style_tag(
        content=":is(.ov, #view-train) button:hover"
        " { color: #ccd !important; background: #dde !important; }"
    )
    assert faint(page, "train")  # the check can see
