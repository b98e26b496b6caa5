"""Files through the real page: read as what they show, or refused in a sentence."""

import json
from io import BytesIO

import numpy as np
import pytest
from PIL import Image

from .gestures import ANSWERED, SLOT, choose, holds, texture

pytestmark = pytest.mark.browser


def saved(image, **options):
    """Return the bytes of an image file."""
    with BytesIO() as handle:
        image.save(handle, "PNG", **options)
        return handle.getvalue()


def picture():
    """Return a colourful picture without any symmetry."""
    random = np.random.default_rng(1)
    return Image.fromarray(random.integers(0, 255, (8, 12, 3), dtype=np.uint8)).resize((96, 64))


@pytest.fixture
def pair_page(visit):
    """Return the Pair tab that all these files go through, one after the other."""
    return visit("?view=pair&vis=row:0&tac=row:0&p=0.5", ANSWERED)


def give(page, name, content):
    """Choose bytes as touch."""
    choose(page, "tac", {"name": name, "mimeType": "image/png", "buffer": content})


def shares(page):
    """Return the probabilities that the touch alone has in the page, shown or folded away."""
    return page.locator(".pair .bars td[data-reading=tac] .share").all_text_contents()


def test_a_turned_photo_is_shown_whole_and_answered_as_the_upright_one(pair_page, posted):
    exif = Image.Exif()
    exif[0x0112] = 6
    give(pair_page, "turned.png", saved(picture(), exif=exif))
    plain = picture().transpose(Image.Transpose.ROTATE_270)
    holds(pair_page, "tac", "turned.png · 64 × 96")
    pair_page.wait_for_selector(ANSWERED)
    ref = posted("image", saved(plain))["ref"]
    wanted = posted("pair", json.dumps({"tac": ref, "head": "own"}).encode())
    told = [f"{100 * p:.1f}\u00a0%" for p in wanted["exact"]["readings"]["tac"]]
    pair_page.wait_for_function(
        """told => [...document.querySelectorAll('.pair .bars td[data-reading=tac] .share')]
             .map((cell) => cell.textContent).join() === told.join()""",
        arg=told,
    )
    assert shares(pair_page) == told
    assert pair_page.is_hidden(".pair .problem")
    fits = "all => all.map((one) => getComputedStyle(one).objectFit)"
    assert set(pair_page.locator(".pair .picture img").evaluate_all(fits)) == {"contain"}


def test_a_bad_file_is_one_sentence_that_names_it_and_the_page_stays_usable(pair_page):
    before = shares(pair_page)
    give(pair_page, "words.png", b"these are words, not pixels")
    pair_page.wait_for_selector(".pair .problem:visible")
    text = pair_page.inner_text(".pair .problem")
    assert "words.png" in text
    assert "not an image" in text
    assert text.count(". ") == 0 and text.endswith(".")
    assert shares(pair_page) == before  # what was there still is
    give(pair_page, "good.png", texture(0)["buffer"])
    pair_page.wait_for_selector(".pair .problem", state="hidden")
    holds(pair_page, "tac", "good.png")
    pair_page.wait_for_selector(ANSWERED)


def test_a_file_over_the_limit_is_refused_before_it_is_sent(pair_page, tmp_path):
    (tmp_path / "huge.png").write_bytes(bytes(20_000_001))
    asked = []
    pair_page.on("request", lambda request: asked.append(request.url))
    choose(pair_page, "tac", tmp_path / "huge.png")
    pair_page.wait_for_selector(".pair .problem:has-text('huge.png'):has-text('20')")
    assert [url for url in asked if "sizes=" in url] == []


def test_a_dropped_and_a_pasted_image_are_taken_like_a_chosen_one(pair_page):
    many = ".pair .many"  # what is pasted outside of a slot is not for the pair
    before = pair_page.inner_text(many)
    for event, holder, place in (
        ("paste", "clipboardData", many),
        ("drop", "dataTransfer", SLOT.format("tac")),
        ("paste", "clipboardData", SLOT.format("tac")),
    ):
        pair_page.evaluate(
            """async ([slot, event, holder]) => {
              const canvas = new OffscreenCanvas(40, 30);
              canvas.getContext('2d').fillRect(0, 0, event === 'drop' ? 9 : 20, 30);
              const carried = new DataTransfer();
              carried.items.add(new File([await canvas.convertToBlob()], `${event}.png`,
                { type: 'image/png' }));
              const made = event === 'drop'
                ? new DragEvent(event, { [holder]: carried, bubbles: true, cancelable: true })
                : new ClipboardEvent(event, { [holder]: carried, bubbles: true, cancelable: true });
              document.querySelector(slot).dispatchEvent(made);
            }""",
            [place, event, holder],
        )
        if place != many:
            holds(pair_page, "tac", f"{event}.png · 40 × 30")
    assert pair_page.inner_text(many) == before
