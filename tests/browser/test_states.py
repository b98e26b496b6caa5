"""States of the page that people come to by clicking: four sizes, light and dark, and on paper."""

import pytest

from .gestures import READY, go, settle

pytestmark = pytest.mark.browser

SIZES = [(1280, 720), (1024, 768), (2560, 1440), (400, 800)]
VIEWS = {  # and what of each needs no scrolling, on a phone and elsewhere
    "chapter=touch": ([], []),
    "chapter=gaps": ([".map", ".order", ".gap-bars"], [".gap-steps", ".chosen", ".stage .figure"]),
    "chapter=where": ([".threads", ".places", ".stage .title"], []),
    "chapter=order": ([".map", ".over svg", ".order", ".stage .title"], []),
    "chapter=fooled": ([".stage .map", ".lookers", ".stage .title"], [".readings"]),
    "chapter=analyse&pin=3": ([], []),
    "chapter=analyse&mode=moved&beside=1&stage2=f_hat&head2=method:nearest_mean": ([], []),
}
OUTSIDE = """selectors => selectors.filter((one) => {
  const { top, bottom, height } = document.querySelector(`.explore ${one}`).getBoundingClientRect();
  return !height || top < 0 || bottom > innerHeight;
})"""
# true if the button to the next chapter hides a part of the sentence that replies to the title
COVERED = """() => {
  const [remark, onward] = ['.remark',
    '.onward'].map((one) => document.querySelector(`.explore .stage ${one}`));
  return remark.getBoundingClientRect().bottom > onward.getBoundingClientRect().top + 1;
}"""
# texts that leave their box, and parts that lie on one another
CUT = """() => {
  const seen = (e) => e.checkVisibility({ visibilityProperty: true })
    && e.getBoundingClientRect().width > 1;
  const all = (of) => [...document.querySelectorAll(`.ov.explore :is(${of})`)].filter(seen);
  const textOf = (e) => {
    const range = document.createRange();
    range.selectNodeContents(e);
    return range.getBoundingClientRect();
  };
  const found = [];
  for (const e of all('button, figcaption, output, .figure, .provenance, .remark, .who')) {
    if (e.closest('.chapters, .presses, .sr') || !e.textContent.trim()) continue;
    const text = textOf(e);
    const holders = [e.matches('button') && e, e.closest('.twin, .object, .lookers button'),
      e.closest('.segments'),
      e.closest('.side'), e.closest('.map-panel'), document.body];
    const box = holders.find((one) => one
      && one.getBoundingClientRect().width > 1).getBoundingClientRect();
    if (text.right > box.right + 1.5
      || text.left < box.left - 1.5) found.push(`cut: ${e.textContent.trim().slice(0, 40)}`);
  }
  const parts = all('.tools > *, .pane, .changed, .kinds, .zooms, .tile, .lookers .thumb');
  parts.forEach((a, i) => parts.slice(i + 1).forEach((b) => {
    if (a.contains(b) || b.contains(a)) return;
    const [p, q] = [a, b].map((e) => e.matches('.changed') ? textOf(e) : e.getBoundingClientRect());
    const over = Math.min(p.right, q.right) - Math.max(p.left, q.left);
    const deep = Math.min(p.bottom, q.bottom) - Math.max(p.top, q.top);
    if (over > 1.5
      && deep > 1.5) found.push(`${a.className || a.tagName} lies on ${b.className || b.tagName}`);
  }));
  if (document.scrollingElement.scrollWidth > innerWidth) found.push('wider than the window');
  return [...new Set(found)];
}"""


def test_no_text_is_cut_no_part_lies_on_another_and_map_chart_and_control_need_no_scrolling(visit):
    for view, (parts, wide) in VIEWS.items():
        page = visit(f"?{view}", READY["explore"])
        page.wait_for_selector(".explore :is(.provenance, .tree-of-pair) >> visible=true")
        page.evaluate("scrollTo(0, 0)")
        for width, height in SIZES:
            page.set_viewport_size({"width": width, "height": height})
            page.evaluate(
                "() => new Promise((done) => requestAnimationFrame(() => setTimeout(done)))"
            )
            settle(page)
            at, needed = (view, width), parts if width == 400 else [*parts, *wide]
            assert page.evaluate(CUT) == [], at
            assert page.evaluate(OUTSIDE, needed) == [], at
            assert not page.evaluate(COVERED), at
    page.locator(".explore .chapters").evaluate("one => { one.style.width = '200vw'; }")
    assert page.evaluate(CUT)  # the check can see
    page.locator(".explore .chapters").evaluate("one => { one.style.width = ''; }")


def test_what_is_shared_while_p_plays_is_what_stays_on_the_screen(visit):
    page = visit("?chapter=analyse&mode=moved", ".explore .score .provenance")
    before = page.input_value(".explore .order")
    page.click(".explore .play")
    page.wait_for_function(
        "before => document.querySelector('.explore .order').value !== before", arg=before
    )
    page.click(".explore .share")
    link = page.input_value(".explore .shared:popover-open input")
    assert page.get_attribute(".explore .play", "aria-pressed") == "false"
    settle(page)
    assert link == page.evaluate("location.href")
    shown = float(page.input_value(".explore .order"))
    assert abs(float(link.split("p=")[-1].split("&")[0]) - shown) < 1e-3


def test_paper_keeps_the_words_simulated_lines_of_figures_and_names_of_colours_but_no_button(
    visited,
):
    visited.set_viewport_size({"width": 718, "height": 1047})

    def seen(parts):
        return visited.locator(f"{parts} >> visible=true").count()

    for chapter in ("touch", "where", "order", "fooled", "analyse"):
        go(visited, f"?chapter={chapter}")
        visited.wait_for_selector(READY["explore"])
        visited.wait_for_selector(".explore .provenance >> visible=true")
        visited.emulate_media(media="print")
        assert seen(".top .badge") == 1, chapter
        gone = ".tour-start, .theme, .chapters, .next, .zooms button, .tiles button:nth-child(13)"
        assert seen(gone) == 0, chapter
        assert seen(".explore .provenance"), chapter
        assert chapter != "fooled" or seen(".explore .readings .scale") == 3
        assert chapter != "where" or seen(".explore .sensors button") == 8
        visited.emulate_media(media="screen")
