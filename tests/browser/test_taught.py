"""Try a pair: what a taught head and a guess look like in every part of the tab."""

import pytest

from .gestures import ANSWERED, SLOT, send

pytestmark = pytest.mark.browser


@pytest.fixture
def taught(open_page):
    """Return the page with two photos in each of two classes, predicted by the taught head."""
    page = open_page("?view=pair&vis=row:0", ANSWERED)
    for seed, label in enumerate(("wood", "wood", "glass", "glass")):
        send(page, "vis", seed)
        page.click(f'.pair .labels [data-label="{label}"]')
    page.click(".pair [data-send=teach]")
    page.wait_for_selector(".pair .taught-now")
    return page


def test_where_explains_the_taught_head_while_it_makes_the_headline(taught):
    headline = taught.inner_text(".pair .reading[data-reading=vis] .said")
    taught.click(f"{SLOT.format('vis')} .where")
    what = taught.locator(f"{SLOT.format('vis')} .what")
    taught.wait_for_selector(f"{SLOT.format('vis')} .what .tag:has-text('taught')")
    assert what.locator("b").nth(1).inner_text() == headline.split()[0].rstrip("?")
    tinted = taught.locator(f"{SLOT.format('vis')} .picture canvas").count()
    assert tinted == ("no single part matters" not in what.inner_text())
    taught.click(
        ".pair [data-send=used]"
    )  # back to the head as trained: the explanation of the other one goes
    taught.wait_for_selector(".pair .taught-now", state="detached")
    assert "taught" not in what.inner_text()
