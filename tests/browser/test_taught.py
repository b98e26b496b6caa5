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
    with taught.expect_request(lambda request: "/occlusion?" in request.url) as sent:
        taught.click(f"{SLOT.format('vis')} .where")
    assert "taught=" in sent.value.url
    what = taught.locator(f"{SLOT.format('vis')} .what")
    taught.wait_for_selector(f"{SLOT.format('vis')} .what .tag:has-text('taught')")
    assert what.locator("b").nth(1).inner_text() == headline.split()[0].rstrip("?")
    taught.click(
        ".pair [data-send=used]"
    )  # back to the head as trained: the explanation of the other one goes
    taught.wait_for_selector(".pair .taught-now", state="detached")
    assert "taught" not in what.inner_text()


def test_every_class_of_a_guess_is_grey_and_called_one(open_page):
    page = open_page("?view=pair&vis=row:0", ANSWERED)
    send(page, "vis", 9)
    page.wait_for_selector(".pair .reading[data-reading=vis] .guessed")
    if not page.locator(".pair .all-classes[open]").count():
        page.click(".pair .all-classes summary")
    assert page.locator(".pair .bars td").count() == page.locator(".pair .bars td.of-guess").count()
    assert "(guess)" in page.inner_text(".pair .bars thead")
