"""Correct a visitor's touch images before they are embedded: turn or mirror them, swap their
channels, or fill their printed dots. A request lists the corrections in `mend`, as words; "" is
none.
"""

from typing import TYPE_CHECKING

from app.shared.state import Question
from omnivat.data.arranged import WAYS, arranged
from omnivat.kit.errors import DataError

if TYPE_CHECKING:
    from PIL.Image import Image

FILL = "fill"
MOST = 4  # words


def mend_in(question: Question) -> str:
    """Return how a request's touches are mended. Raises DataError for an unknown word."""
    mend = question.get("mend") or ""
    words = mend.split() if isinstance(mend, str) else [str(mend)]
    if len(words) > MOST or not {FILL, *WAYS}.issuperset(words):
        raise DataError(f"mend is '{mend!s:.60}'; give words of {', '.join((FILL, *WAYS))}.")
    return " ".join(words)


def mended(touch: "Image", mend: str) -> "Image":
    """Return a touch image (RGB) with the corrections of `mend`; the same object for ""."""
    if FILL in mend.split():
        import numpy as np
        from PIL.Image import fromarray

        from omnivat.data.dots import fill_dots

        filled, dots = fill_dots(np.asarray(touch))
        touch = fromarray(filled) if dots else touch
    return arranged(touch, way_in(mend))


def way_in(mend: str) -> str:
    """Return the arrangement in the words of `mend`, as a profile records it."""
    return " ".join(word for word in mend.split() if word != FILL)
