"""The relief of a visitor's touch, by the lamps of the touches sent with it."""

from dataclasses import replace
from io import BytesIO

import numpy as np
import pytest
from PIL import Image

from app.pair.touch_relief import MOST, relief
from app.shared.requests import FILES
from omnivat import lamps, slopes
from omnivat.head.heads import EXAMPLES
from omnivat.kit.errors import DataError


@pytest.fixture(scope="module")
def touches():
    """Return the example touches of one gel, as files."""
    files = sorted((EXAMPLES / "pairs" / "TAG-sim").glob("*/*_tac.jpg"))
    return [file.read_bytes() for file in files]


def sent(resources, touches, kind, **more):
    """Return the reply to touches that come with a question."""
    return relief(resources, {"as": kind, "name": "<b>x</b>", FILES: touches, **more})


def test_the_first_of_the_touches_comes_back_as_slopes_heights_a_surface_and_figures(
    resources, touches
):
    found = np.load(BytesIO(sent(resources, touches, "npy")))
    assert found.shape == (224, 224, 3)
    bent = np.gradient(found[..., 2], axis=1)
    assert np.corrcoef(bent.ravel(), found[..., 0].ravel())[0, 1] > 0.7
    surface = sent(resources, touches, "ply")
    assert b"element vertex 50176\n" in surface and b"element face 99458\n" in surface
    reply = sent(resources, touches, "figures")
    assert f"Drawn by the lamps that {len(touches)} touches of this sensor give" in reply["caption"]
    shown = reply["figures"]
    assert [one["type"] for plot in shown for one in plot["data"]] == ["surface", *["heatmap"] * 2]
    assert "<b>" not in shown[0]["layout"]["title"]["text"]


def test_one_touch_is_drawn_by_the_lamps_of_the_profile_which_the_caption_names(resources, touches):
    dark, *others = (np.asarray(Image.open(BytesIO(one)).convert("RGB")) for one in touches)
    gel = lamps(others)
    bare = resources.head().source_profile
    for name, held in (("lit", replace(bare, lamps=gel)), ("unlit", replace(bare, lamps=None))):
        resources.profiles.keep(name, held)
    found = np.load(BytesIO(sent(resources, touches[:1], "npy", profile="lit")))
    assert np.array_equal(found[..., :2], slopes(dark, gel))
    caption = sent(resources, touches[:1], "figures", profile="lit")["caption"]
    assert f"lamps in the profile of your sensor, which {len(others)} touches gave" in caption
    with pytest.raises(DataError, match=r"holds no lamps\. 2 more touches"):
        sent(resources, touches[:3], "npy", profile="unlit")


def test_too_few_and_too_many_touches_are_refused(resources, touches):
    with pytest.raises(DataError, match=r"three|3"):
        sent(resources, touches[:2], "npy")
    with pytest.raises(DataError, match=f"{MOST + 1} pictures came with the question"):
        sent(resources, touches[:1] * (MOST + 1), "npy")
