"""Every p in a real Chromium: curves of its frames, and neighbours of no other head."""

import re
from pathlib import Path

import numpy as np
import pytest

from app.shared.tables import tables
from omnivat.data.store import load_embeddings
from omnivat.head.heads import default_embeddings
from omnivat.maps.frames import read_frames

from .gestures import MAP, go

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
pytestmark = pytest.mark.browser


@pytest.mark.parametrize(
    ("query", "folder"), [("", EXAMPLES), ("&set=chirps", EXAMPLES / "chirps")]
)
def test_one_head_for_every_order_is_a_mode_and_its_curves_follow_p(open_page, query, folder):
    frames = read_frames(folder / "every.bin")
    page = open_page(f"?mode=every&map=pca&p=0.2{query}", ".explore[data-kind=every]")
    for order in (0.2, 0.8):
        go(page, f"?mode=every&map=pca&p={order}{query}")
        page.wait_for_selector(f'{MAP}[data-order="{order}"]')
        modes = page.locator(".explore .modes [data-key]")
        shown = modes.evaluate_all("all => all.map((one) => one.dataset.key)")
        assert shown == [row["id"] for row in tables()["modes"]]
        shown = page.text_content(".explore .curves [data-name=accuracy] output")
        value = frames.curves["accuracy/unseen"][frames.orders.index(order)]
        assert shown.replace("\xa0", " ") == f"{100 * value:.1f} %"
        assert "One head for every p" in page.inner_text(".explore .mode-words")


def test_neighbours_in_frames_of_another_head_are_those_of_the_raw_embedding(open_page):
    pairs, pair = load_embeddings(default_embeddings()), 100
    rows = np.concatenate([pairs.vis, pairs.tac]).astype(np.float64)
    rows /= np.linalg.norm(rows, axis=1, keepdims=True)
    cosines = rows @ rows[pair]
    nearest = [int(k) for k in np.argsort(-cosines) if k != pair][:6]
    page = open_page(f"?chapter=analyse&mode=every&stage=f_hat&p=0.8&pin={pair}", ".card .near")
    assert "raw embedding" in page.inner_text(".card .near h4")
    page.click(".card .find >> nth=0")
    page.wait_for_selector(".card .found button")
    found = page.locator(".card .found button")
    assert found.evaluate_all("all => all.map((one) => +one.dataset.point)") == nearest
    said = [re.search(r"cosine ([\d.]+)", found.nth(k).get_attribute("title"))[1] for k in range(6)]
    np.testing.assert_allclose([float(text) for text in said], cosines[nearest], atol=6e-4)
