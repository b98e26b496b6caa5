"""Below every accuracy stands where it comes from: head, training data, test data."""

import re

import pytest

from .gestures import settle

pytestmark = pytest.mark.browser

SHARES = """() => {
  const shown = (e) => e.checkVisibility({ visibilityProperty: true });
  const about = '.side, .beside .pane, .panels details, .press';
  const texts = document.createTreeWalker(document.querySelector('.ov.explore'),
    NodeFilter.SHOW_TEXT);
  const found = [], alone = [];
  while (texts.nextNode()) {
    const { parentElement: of, data } = texts.currentNode;
    // probabilities of one pair, axes and counts of neighbours are no accuracies
    if (!/\\d\\s%/.test(data) || !shown(of)
      || of.closest('svg, .sr, .card, .chosen, .legend, .provenance, .changed, .approximate'))
      continue;
    found.push(data);
    let box = of.closest(about);
    if (box?.matches('.press')) box = box.parentElement;
    while (box && ![...box.querySelectorAll('.provenance')].some(shown))
      box = box.parentElement?.closest(about);
    if (!box) alone.push(`${data} (${of.className || of.tagName})`);
  }
  return { found, alone };
}"""
SENTENCES = (
    r"Measured with .*, trained on .*and tested on .*(\. The model was given .+|the same pairs)\.$"
)
VIEWS = [
    "chapter=touch",
    "chapter=touch&dots=1&known=50&reading=fused",
    "chapter=where&rung=spread",
    "chapter=gaps&p=0.2",
    "chapter=order",
    "chapter=fooled&reading=tac",
    "chapter=analyse",
    "chapter=analyse&mode=moved",
    "chapter=analyse&mode=every",
    "chapter=analyse&mode=moved&beside=1&stage2=f_hat&head2=method:nearest_mean",
    "chapter=analyse&mode=moved&sel=0.35",
]


@pytest.mark.parametrize("view", VIEWS)
def test_every_accuracy_on_the_screen_has_a_line_that_tells_where_it_comes_from(open_page, view):
    page = open_page(f"?{view}", ".explore .provenance >> visible=true")
    settle(page)
    seen = page.evaluate(SHARES)
    assert seen["found"]
    assert seen["alone"] == []
    for line in page.locator(".explore .provenance >> visible=true").all_inner_texts():
        assert re.search(SENTENCES, line, re.DOTALL), line
    bare = "document.querySelectorAll('.provenance').forEach((one) => one.remove())"
    found = page.evaluate(f"{bare}; ({SHARES})()")  # at once, before anything is drawn again
    assert found["alone"]  # the search can see


def test_one_head_has_one_accuracy_in_all_chapters(open_page):
    page = open_page("?chapter=analyse&mode=moved", ".explore .score .provenance")
    score = page.inner_text(".explore .score .large")
    page.click('.explore .chapters [data-chapter="fooled"]')
    page.wait_for_selector(".explore .stage .remark .provenance")
    assert f"both together in {score}." in page.inner_text(".explore .stage .remark")
    page.evaluate("document.querySelector('[data-panel=domains]').open = true")
    assert page.inner_text(".explore .each-domain .mean-row output") == score
