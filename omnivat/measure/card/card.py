"""What one folder of touches shows of its sensor."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from itertools import islice
from typing import Any

import numpy as np

from omnivat.data.relief import Lamps, NoLampsError, UnsettledError, lamps
from omnivat.data.relief.filters import blurred, fast, scale
from omnivat.data.relief.lamps import several
from omnivat.kit.errors import DataError
from omnivat.measure.card.traits import Array, Traits, traits_of

FEWEST, MOST = 5, 200  # pictures
SMOOTH, RIM = 3.0, 8.0  # pixels of 224: for the strength
DRAWS = 200  # of the bootstrap
SETTLED = 0.97  # confidence of lamps above which more pictures are not needed
EACH = ("relief", "sharpness", "softness", "noise", "brightness", "red", "blue", "dots", "pitch")


@dataclass(frozen=True, slots=True, kw_only=True)
class SensorCard:
    """One sensor, from touches without labels. Light is in steps of 255.

    pictures  how many were read
    size      their (width, height), the commonest
    lamps     the gel's lamps, or None; `unlit` then states why
    halves    cosine between the lamps of every other picture and of the rest, or None
    field     (h, w, 3) the gel's light without relief, in cells: the median picture
    rows      a number for each picture (n,) by its name in EACH: logarithms of relief, sharpness
              (that of fine edges, and of soft ones), noise, brightness and of red and blue over
              green; 1 for a picture with dots; the dots' pitch over the picture's shorter side
              (NaN without dots)
    strength  logarithm of the colour that a slope adds, up to a constant of the gel, and its
              standard error; None without lamps
    missing   what more touches may settle, or ""
    changes   what changed from another card, the likeliest first; None if none was given
    """

    pictures: int
    size: tuple[int, int]
    lamps: Lamps | None
    unlit: str
    halves: float | None
    field: Array
    rows: Mapping[str, Array]
    strength: tuple[float, float] | None
    missing: str
    changes: tuple[Any, ...] | None = None

    def of(self, name: str) -> tuple[float, float]:
        """Return the mean of a row over the pictures, and its standard error; or the strength."""
        if name == "strength":
            return self.strength or (float("nan"), float("nan"))
        row = self.rows[name]
        kept = row[np.isfinite(row)]
        if len(kept) < min(FEWEST, len(row)):
            return float("nan"), float("nan")
        return float(kept.mean()), float(kept.std() / np.sqrt(max(len(kept) - 1, 1)))

    @property
    def uneven(self) -> float:
        """Spread of the gel's light over its mean."""
        grey = self.field.mean(-1)
        return float(grey.std() / max(grey.mean(), 1e-6))


def card_of(pictures: Iterable[Array]) -> SensorCard:
    """Return the card of a sensor from its touches, each (H, W, 3) uint8; at most MOST are read.

    Raises DataError for fewer than FEWEST pictures.
    """
    return summed([traits_of(picture) for picture in islice(several(pictures), MOST)])


def summed(read: list[Traits]) -> SensorCard:
    """Return the card of a sensor from the traits of its touches; see `card_of`."""
    if len(read) < FEWEST:
        there = "is 1" if len(read) == 1 else f"are {len(read) or 'none'}"
        raise DataError(
            f"A sensor's card needs {FEWEST} touch images or more, better 25, and there {there};"
            " add some."
        )
    sizes = [traits.size for traits in read]
    common = max(set(sizes), key=sizes.count)
    same = [traits for traits in read if traits.size == common]
    found, unlit, unsettled = lit_by(same)
    halves = [lit_by(same[start::2])[0] for start in (0, 1)]
    agreement = None
    if halves[0] is not None and halves[1] is not None:
        agreement = abs(cosine(halves[0].colours, halves[1].colours))
    return SensorCard(
        pictures=len(read),
        size=common,
        lamps=found,
        unlit=unlit,
        halves=agreement,
        field=np.median([traits.field for traits in same], 0),
        rows={name: np.array([_number(traits, name) for traits in read]) for name in EACH},
        strength=None if found is None else strength_of(same, found),
        missing=_missing(found, len(same)) if found or unsettled else "",
    )


def lit_by(read: list[Traits]) -> tuple[Lamps | None, str, bool]:
    """Return the lamps of the pictures; or None, why not, and whether more pictures may help."""
    try:
        return lamps((traits.filled for traits in read), dots="keep"), "", False
    except NoLampsError as error:
        return None, str(error), isinstance(error, UnsettledError)


def strength_of(read: list[Traits], lit: Lamps) -> tuple[float, float] | None:
    """Return the logarithm of the colour that a slope adds, and its standard error.

    Contrast alone does not give it, because objects differ in relief more than gels in strength.
    But a slope also darkens the gel, with its square (Lambert's law), and that does not depend on
    the lamps' strength: what a square of colour darkens falls with the square of the strength,
    whatever was touched. None if the pictures show no such darkening.
    """
    plane, _, _ = np.linalg.svd(lit.colours)
    grey = plane[:, 2] * np.sign(plane[:, 2].sum())
    shares = []
    for traits in read:
        light = fast(blurred(traits.filled.astype(np.float32), SMOOTH * scale(traits.filled)))
        coloured = np.square(light @ plane[:, :2]).sum(-1, keepdims=True)
        coloured, dark = fast(coloured), fast((light @ grey)[..., None].astype(np.float32))
        rim = max(1, round(RIM * scale(light)))
        inner = (slice(rim, -rim), slice(rim, -rim))
        coloured, dark = coloured[inner], dark[inner]
        shares.append(-float((coloured * dark).sum() / max(np.square(coloured).sum(), 1e-9)))
    draws = np.random.default_rng(0).integers(len(shares), size=(DRAWS, len(shares)))
    medians = np.median(np.array(shares)[draws], 1)
    if min(np.median(shares), np.quantile(medians, 0.05)) <= 0:
        return None
    logarithms = -0.5 * np.log(np.maximum(medians, 1e-9))
    high, low = np.quantile(logarithms, [0.84, 0.16])
    return float(-0.5 * np.log(np.median(shares))), float(high - low) / 2


def cosine(a: Array, b: Array) -> float:
    """Return the cosine of two arrays of one shape; 0 if one is flat."""
    length = float(np.linalg.norm(a) * np.linalg.norm(b))
    return float((a * b).sum()) / length if length > 1e-9 else 0.0


def _number(traits: Traits, name: str) -> float:
    """Return a trait as the number on the card's scale; NaN where the gel does not show it."""
    tint = np.maximum(traits.tint, 1.0)
    values: dict[str, Any] = {
        "relief": lambda: np.log(traits.coarse),
        "sharpness": lambda: np.log(traits.edge or np.nan),
        "softness": lambda: np.log(traits.soft / traits.coarse),
        "noise": lambda: np.log(max(traits.noise, 0.1)),
        "brightness": lambda: np.log(tint.mean()),
        "red": lambda: np.log(tint[0] / tint[1]),
        "blue": lambda: np.log(tint[2] / tint[1]),
        "dots": lambda: float(traits.dots is not None),
        "pitch": lambda: (
            np.mean(traits.dots.pitch) / min(traits.filled.shape[:2]) if traits.dots else np.nan
        ),
    }
    return float(values[name]())


def _missing(found: Lamps | None, count: int) -> str:
    sure = 0.0 if found is None else found.confidence
    if sure >= SETTLED:
        return ""
    # the error of the lamps falls with the number of pictures
    needed = max(20, round(count * (1 - sure) / (1 - SETTLED))) if found else max(20, 2 * count)
    return f"About {min(needed, MOST) - count} more touches may settle the lamps."
