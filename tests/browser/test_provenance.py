"""Below every accuracy stands where it comes from: head, training data, test data."""

import re

import pytest

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
    "chapter=analyse",
    "chapter=analyse&mode=moved&beside=1&stage2=f_hat&head2=method:nearest_mean",
    "chapter=touch&dots=1&known=50&reading=fused",
    "chapter=where&rung=spread",
    "chapter=gaps&p=0.2",
    "chapter=order",
    "chapter=fooled&reading=tac",
    "chapter=analyse&mode=moved&sel=0.35",
]


def test_one_head_has_one_accuracy_in_all_chapters_with_its_source_pairs_and_what_was_known(visit):
    page = visit("?chapter=analyse&mode=moved", ".explore .score .provenance")
    assert re.fullmatch(
        r"Measured with the loaded head at its learned p = 0\.503, trained on GelSight \(TAG\) and "
        r"tested on \d+ pairs \(mean of 7 unseen domains\)\. The model was given nothing from "
        r"these domains\.",
        page.inner_text(".explore .score .provenance").replace("\N{NO-BREAK SPACE}", " "),
    )
    score = page.inner_text(".explore .score .large")
    page.click('.explore .chapters [data-chapter="fooled"]')
    page.wait_for_selector(".explore .stage .remark .provenance")
    assert f"both together in {score}." in page.inner_text(".explore .stage .remark")
    page.evaluate("document.querySelector('[data-panel=domains]').open = true")
    assert page.inner_text(".explore .each-domain .mean-row output") == score


def test_every_accuracy_on_the_screen_has_a_line_that_tells_where_it_comes_from(visit):
    for view in VIEWS:
        page = visit(f"?{view}", ".explore.ready .provenance >> visible=true")
        seen = page.evaluate(SHARES)
        assert seen["found"], view
        assert seen["alone"] == [], view
        for line in page.locator(".explore .provenance >> visible=true").all_inner_texts():
            assert re.search(SENTENCES, line, re.DOTALL), (view, line)
    page.add_style_tag(content=".provenance { display: none !important; }")
    assert page.evaluate(SHARES)["alone"]  # the search can see
