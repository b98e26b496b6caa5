"""Accessibility: keyboard only, screen readers, phones, large text, light and dark."""

import pytest

from app.shared.components import VIEWS

from .gestures import ANSWERED, COLOURS, MAP, READY, faults, open_tab, settle

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
        if view != "explore":  # whose chapters test_chapters.py audits in the dark
            audited.click(".ov.top .theme")
            assert faults(audited, COLOURS, f"#view-{view}") == [], view
            audited.click(".ov.top .theme")
    audited.evaluate("document.querySelector('#view-train .task').style.color = '#ccd'")
    assert any(
        "contrast" in fault for fault in faults(audited, COLOURS, "#view-train")
    )  # the audit can see
    audited.evaluate("document.querySelector('#view-train .task').style.color = ''")


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


# the buttons of a view whose text is too faint under the pointer, in the dark and in the light:
# rules for a pointer also hold for what is marked as under one
FAINT = """view => {
  const heed = (rules) => [...rules].forEach((rule) => {
    const of = rule.selectorText;
    if (of?.includes(':hover') && !of.includes('data-hovered'))
      rule.selectorText = of.replaceAll(':hover', ':is(:hover, [data-hovered])');
    heed(rule.cssRules ?? []);
  });
  [...document.styleSheets].forEach((sheet) => heed(sheet.cssRules));
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
  const contrast = (e) => {
    const back = ground(e);
    const [high, low] = [light(over(parts(getComputedStyle(e).color), back)),
      light(back)].sort((a, b) => b - a);
    return (high + 0.05) / (low + 0.05);
  };
  const usable = [...document.querySelectorAll(
    `#view-${view} :is(button, summary), .ov.top button`)].filter((one) =>
    !one.disabled && one.checkVisibility() && one.textContent.trim());
  const marked = usable.flatMap((one) => {
    const all = [];
    for (let e = one; e; e = e.parentElement) all.push(e);
    return all;
  });
  marked.forEach((e) => e.toggleAttribute('data-hovered', true));
  const found = [true, false].flatMap((dark) => {
    document.body.classList.toggle('dark', dark);
    return usable.filter((one) => contrast(one) < 4.5)
      .map((one) => `${dark ? 'dark' : 'light'} ${contrast(one)} ${one.outerHTML.slice(0, 90)}`);
  });
  marked.forEach((e) => e.removeAttribute('data-hovered'));
  return found;
}"""


def test_a_button_under_the_pointer_can_be_read_pressed_or_not(visit):
    page = visit("?chapter=analyse&beside=1&vis=row:0&tac=row:0", MAP)
    page.add_style_tag(content="* { transition: none !important; }")
    chapters = page.locator(".chapters [data-chapter]").evaluate_all(
        "all => all.map((one) => one.dataset.chapter)"
    )
    for chapter in chapters:
        page.click(f'.chapters [data-chapter="{chapter}"]')
        page.wait_for_selector(f'.explore[data-chapter="{chapter}"]')
        assert page.evaluate(FAINT, "explore") == [], chapter
    for view in VIEWS[1:]:
        open_tab(page, view)
        page.wait_for_selector(READY[view])
        assert page.evaluate(FAINT, view) == [], view
    page.add_style_tag(
        content=":is(.ov, #view-train) button:hover"
        " { color: #ccd !important; background: #dde !important; }"
    )
    assert page.evaluate(FAINT, "train")  # the check can see
