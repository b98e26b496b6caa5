"""The relief of a visitor's touch, by the lamps of the touches sent with it."""

from io import BytesIO

import numpy as np
import pytest

from app.pair.touch_relief import MOST, relief
from omnivat.head.heads import EXAMPLES
from omnivat.kit.errors import DataError


@pytest.fixture(scope="module")
def touches():
    """Return the example touches of one gel, as files."""
    files = sorted((EXAMPLES / "pairs" / "TAG-sim").glob("*/*_tac.jpg"))
    return [file.read_bytes() for file in files]


def sent(resources, touches, kind):
    """Return the reply to touches in one body."""
    sizes = ",".join(str(len(one)) for one in touches)
    return relief(resources, b"".join(touches), {"as": kind, "sizes": sizes, "name": "<b>x</b>"})


def test_the_first_of_the_touches_comes_back_as_slopes_heights_a_surface_and_figures(
    resources, touches
):
    found = np.load(BytesIO(sent(resources, touches, "npy")))
    assert found.shape == (224, 224, 3)
    bent = np.gradient(found[..., 2], axis=1)
    assert np.corrcoef(bent.ravel(), found[..., 0].ravel())[0, 1] > 0.7
    surface = sent(resources, touches, "ply")
    assert b"element vertex 50176\n" in surface and b"element face 99458\n" in surface
    shown = sent(resources, touches, "figures")["figures"]
    assert [one["type"] for plot in shown for one in plot["data"]] == ["surface", *["heatmap"] * 2]
    assert "<b>" not in shown[0]["layout"]["title"]["text"]


def test_too_few_touches_and_sizes_that_are_not_theirs_are_refused(resources, touches):
    with pytest.raises(DataError, match=r"three|3"):
        sent(resources, touches[:2], "npy")
    for sizes in ("", "5", "0,9", ",".join(["1"] * (MOST + 1))):
        with pytest.raises(DataError, match="sizes is"):
            relief(resources, touches[0], {"as": "npy", "sizes": sizes})
