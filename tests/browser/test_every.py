"""Every p, the third mode, in a real Chromium: its curves follow the shipped frames."""

from pathlib import Path

import pytest

from omnivat.maps.frames import read_frames

from .gestures import MAP

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
pytestmark = pytest.mark.browser


@pytest.mark.parametrize(
    ("query", "folder"), [("", EXAMPLES), ("&set=chirps", EXAMPLES / "chirps")]
)
def test_one_head_for_every_order_is_the_third_mode_and_its_curves_follow_p(
    open_page, query, folder
):
    frames = read_frames(folder / "every.bin")
    for order in (0.2, 0.8):
        page = open_page(f"?mode=every&map=pca&p={order}{query}", ".explore[data-kind=every]")
        page.wait_for_selector(f'{MAP}[data-order="{order}"]')
        modes = page.locator(".explore .modes [data-key]")
        assert modes.evaluate_all("all => all.map((one) => one.dataset.key)") == [
            "retrained",
            "moved",
            "every",
        ]
        shown = page.text_content(".explore .curves [data-name=accuracy] output")
        value = frames.curves["accuracy/unseen"][frames.orders.index(order)]
        assert shown.replace("\xa0", " ") == f"{100 * value:.1f} %"
        assert "One head for every p" in page.inner_text(".explore .mode-words")
