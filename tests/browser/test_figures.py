"""Interactive figures in a real Chromium: offline, in light and dark, with pictures at the
pointer.
"""

import numpy as np
import pytest
from PIL import Image

from omnivat import figures

pytestmark = pytest.mark.browser


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    """A page with a map in two and in three dimensions, and a sheet of thumbnails."""
    folder = tmp_path_factory.mktemp("figures")
    Image.new("RGB", (256, 192), "#336699").save(folder / "s.webp")
    (folder / "s.json").write_text('{"tile": 64, "columns": 4, "count": 12}')
    tiles = figures.pictures(folder / "s.webp")
    places = np.random.default_rng(0).normal(size=(12, 3))
    parts = [
        figures.map_figure(some, [0, 1, 2] * 2, ["a", "b", "c"], title="map", pictures=tiles)
        for some in (places[:, :2], places)
    ]
    (folder / "page.html").write_text(figures.html_page("Maps", parts), encoding="utf-8")
    return folder / "page.html"


@pytest.fixture(scope="module")
def page(chromium, file):
    """Return the page in the dark on a phone; it collects errors and requests."""
    page = chromium.new_page(color_scheme="dark", viewport={"width": 400, "height": 800})
    page.wrong = []
    page.on("pageerror", lambda error: page.wrong.append(str(error)))
    page.on(
        "request",
        lambda r: r.url.startswith(("data:", "blob:", "file:")) or page.wrong.append(r.url),
    )
    page.goto(file.as_uri())
    page.wait_for_selector("body[data-drawn]")
    yield page
    page.close()


def test_no_control_of_a_figure_leads_to_another_host(page):
    titles = page.eval_on_selector_all(
        ".modebar-btn", "all => all.map((e) => e.dataset.title ?? e.title)"
    )
    assert len(titles) >= 6 and not [t for t in titles if "Share" in t]
    assert page.eval_on_selector_all("a[href]", "all => all.map((e) => e.href)") == []
    refused = page.evaluate("fetch('https://example.org').then(() => 'sent', () => 'refused')")
    assert refused == "refused"
    assert [one for one in page.wrong if "example.org" not in one] == []


def test_the_figure_follows_light_and_dark_and_its_own_switch(page):
    ink = "getComputedStyle(document.querySelector('.gtitle')).fill"
    assert page.evaluate(ink) == "rgb(232, 238, 246)"
    page.click(".theme")
    page.wait_for_function(f"{ink} === 'rgb(15, 23, 42)'")


def test_pointing_at_a_point_shows_its_photo_and_its_touch(page):
    mark = page.locator(".plot").first.locator(".point").first
    mark.hover(force=True)
    page.wait_for_selector("#tip i >> nth=1", state="attached")
    assert page.eval_on_selector("#tip", "tip => getComputedStyle(tip).display") == "flex"
    assert "data:image/webp" in page.eval_on_selector("#tip i", "i => i.style.backgroundImage")
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
