"""Explore on a phone, on a dark system and as a saved page, in a real Chromium."""

import re

import pytest

from omnivat.head.heads import EXAMPLES

from .gestures import MAP, READY

pytestmark = pytest.mark.browser


COVERED = """() => {
  const box = document.querySelector('.tour').getBoundingClientRect();
  return ['.map', '.over', '.order', '.places', '.bars', '.twin-pictures'].filter((one) => {
    const part = document.querySelector(`.explore ${one}`);
    const b = part?.checkVisibility() && part.getBoundingClientRect();
    return b && b.left < box.right && b.right > box.left && b.top < box.bottom
      && b.bottom > box.top;
  });
}"""

PHONE = {"size": (400, 800), "has_touch": True, "is_mobile": True}


def test_on_a_phone_no_step_of_the_tour_covers_map_chart_or_slider(new_page, address):
    page = new_page(**PHONE)
    page.goto(address, wait_until="commit")
    page.wait_for_selector(READY["explore"])
    page.click(".tour-start")
    for step in range(1, 9):
        page.wait_for_selector(f".tour h3:has-text('{step} of 8')")
        assert page.evaluate(COVERED) == []
        if step < 8:
            page.tap(".tour [data-option]")
        page.tap(".tour .next-step")


def test_the_saved_page_works_from_disk_with_its_toy_and_tour(chromium, tmp_path):
    from app.shared.places import places
    from app.site.export import export_page

    export_page(places(), EXAMPLES / "frames.bin", tmp_path / "page.html")
    page = chromium.new_page(viewport={"width": 1440, "height": 900})
    failed = []
    page.on("pageerror", lambda error: failed.append(str(error)))
    page.on(
        "request", lambda r: None if r.url.startswith(("file:", "data:")) else failed.append(r.url)
    )
    page.goto((tmp_path / "page.html").as_uri())
    page.wait_for_selector(MAP)
    page.wait_for_selector(".explore .score b")
    page.click('.explore [data-panel="toy"] summary')
    page.wait_for_selector(".explore .toy .plane path")
    page.click(".tour-start")
    page.wait_for_selector(".tour h3:has-text('1 of 3')")
    page.click(".tour [data-option]")
    assert re.search(r"\d", page.inner_text(".tour p"))
    page.close()
    assert failed == []


INK = """() => {
  const { width, height } = document.querySelectorAll('.explore .map canvas')[1];
  const x = document.querySelectorAll('.explore .map canvas')[1].getContext('2d');
  return x.getImageData(0, 0, width, height).data.filter((v, i) => i % 4 === 3 && v > 0).length;
}"""


GROUND = """() => document.querySelector('.explore .map canvas').getContext('2d')
  .getImageData(3, 3, 1, 1).data.slice(0, 3).reduce((sum, part) => sum + part, 0)"""


def test_a_dark_system_gets_a_dark_page_and_light_paper_with_the_points_of_the_map_as_shapes(
    open_page,
):
    page = open_page("?chapter=order", MAP, color_scheme="dark")
    page.wait_for_selector("body.dark")
    assert page.evaluate(GROUND) < 150
    page.wait_for_function(f"() => ({INK})() > 0")
    before = page.evaluate(INK)
    on_paper = page.evaluate(  # at once: the next animation frame draws for the screen
        f"() => {{ dispatchEvent(new Event('beforeprint')); return ({INK})(); }}"
    )
    assert on_paper > 2 * before
    assert not page.locator("body.dark").count()
    page.evaluate("dispatchEvent(new Event('afterprint'))")
    page.wait_for_selector("body.dark")
