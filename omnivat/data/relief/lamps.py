"""The lamps of a gel, from a few of its pictures without labels."""

from collections.abc import Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import numpy as np

from omnivat.data.arrays import LEAST, MOST
from omnivat.data.dots import SMALLEST, fill_dots
from omnivat.data.relief.filters import fast, reduced
from omnivat.data.relief.moments import (
    Moments,
    colours_of,
    curl_free,
    derivatives,
    moments_of,
    split_of,
)
from omnivat.kit.errors import DataError

Array = np.ndarray[Any, np.dtype[Any]]
FEWEST = 3  # pictures
MEDIAN = 8  # pictures, from which on their median may be the background
REDUCED = 112  # pixels of the shorter side in which lamps are sought
GREY = 0.03  # least energy of the second colour, of the first's
FAINT = 1.5  # of 255: least root mean square of the fast colours
WOUND = 0.6  # largest ratio of the smallest curl to the next
MIXED = 0.5  # least share of the curl that stays when pictures are divided among two sensors
DIVIDED = 6  # pictures, from which on they are divided
SURE = 0.5  # least confidence
DRAWS, LEVEL = 100, 0.05  # of the bootstrap


class NoLampsError(DataError):
    """Pictures do not give a gel's lamps; the sentence gives the reason."""


class UnsettledError(NoLampsError):
    """More pictures of the same gel may give its lamps."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Lamps:
    """The lamps of one sensor.

    colours     (3, 2): what a slope to the right and one downwards add to red, green and blue of
                255. A slope is positive where the gel comes nearer to the camera along it; 1 is
                the root mean square over the pictures.
    background  (h, w, 3) uint8, reduced: the median picture, subtracted first; None if the slow
                light alone is subtracted
    ratio       smallest curl over the next, 0 to 1: below 0.3 for one gel in good pictures
    confidence  cosine to the lamps of infinitely many such pictures that 95 % of bootstrap draws
                of the pictures exceed
    pictures    how many were used
    steepness   true slope, mm in a mm, of a slope of 1; None if no height is known

    Raises DataError for colours or a background of another kind.
    """

    colours: Array
    background: Array | None
    ratio: float
    confidence: float
    pictures: int
    steepness: float | None = None

    def __post_init__(self) -> None:
        """Check the arrays."""
        own, behind = self.colours, self.background
        real = isinstance(own, np.ndarray) and own.shape == (3, 2) and own.dtype.kind in "fiu"
        if not (real and (not own.any() or LEAST <= np.abs(own).max() <= MOST)):  # NaN is refused
            raise DataError(
                f"The lamps' colours are not 3 × 2 numbers, the largest from {LEAST:g} to {MOST:g};"
                " make them again."
            )
        if self.steepness is not None and not LEAST <= self.steepness <= MOST:
            raise DataError(
                f"The lamps' steepness is {self.steepness:g}, and {LEAST:g} to {MOST:g} are"
                " accepted; measure it again."
            )
        if behind is not None and not (
            isinstance(behind, np.ndarray)
            and behind.dtype == np.uint8
            and behind.shape[2:] == (3,)
            and behind.size
        ):
            raise DataError("The lamps' background is no (h, w, 3) of uint8; make them again.")


def several(pictures: Any) -> Iterator[Any]:
    """Return pictures one by one; a single one, or what is none at all, alone."""
    with suppress(TypeError, RuntimeError):
        if getattr(pictures, "ndim", 0) != 3:
            return iter(pictures)
    return iter([pictures])


def lamps(pictures: Iterable[Array], *, dots: str = "fill") -> Lamps:
    """Return the lamps of the gel that touched in all `pictures`, each (H, W, 3) uint8.

    A relief has no curl, and only the right lamps give slopes without curl. Five to twenty
    pictures are enough; they need no labels, no calibration press, and may be frames of a film in
    which the contact moves. Pictures are read one after the other and kept reduced.

    dots  "fill": printed dots are filled first; "keep": they were filled, or there are none

    Raises NoLampsError for fewer than 3 pictures, for grey or faint ones, photographs, pictures of
    several sensors, and pictures that disagree; DataError for what is no picture.

    >>> rng = np.random.default_rng(0)
    >>> lit = np.array([[30, 0], [-15, 26], [-15, -26]])  # red, green, blue
    >>> y, x = np.mgrid[:128, :128]
    >>> def touch():
    ...     waves = rng.normal(size=(5, 3)) * [0.25, 0.25, 3]
    ...     phases = (np.cos(a * x + b * y + c)[..., None] * (a, b) for a, b, c in waves)
    ...     return np.uint8(np.clip(128 + sum(phases) @ lit.T, 0, 255))
    >>> found = lamps([touch() for _ in range(5)]).colours
    >>> bool(abs((found * lit).sum()) > 0.99 * np.linalg.norm(found) * np.linalg.norm(lit))
    True
    """
    small = [reduced(clean(picture, dots), REDUCED) for picture in several(pictures)]
    if len(small) < FEWEST:
        there = "is 1" if len(small) == 1 else f"are {len(small) or 'none'}"
        raise UnsettledError(
            f"Lamps need {FEWEST} pictures of one sensor or more, and there {there}; add"
            f" {FEWEST - len(small)}."
        )
    backgrounds: list[Array | None] = [None]
    if len(small) >= MEDIAN and len({picture.shape for picture in small}) == 1:
        backgrounds.append(np.rint(np.median(small, 0)).astype(np.uint8))
    tried = []
    for background in backgrounds:
        fields = [
            derivatives(fast(picture if background is None else picture - background))
            for picture in small
        ]
        moments = moments_of(fields)
        mixture, (least, second) = curl_free(moments.mean(np.ones(len(small))))
        tried.append((least / second, background, fields, moments, mixture))
    ratio, background, fields, moments, mixture = min(tried, key=lambda fit: fit[0])
    _require_one_gel(moments, ratio)
    found = colours_of(mixture, moments.mean(np.ones(len(small))))
    sure = _confidence(moments, found)
    if sure < SURE:
        raise UnsettledError(
            f"These {len(small)} pictures do not settle the lamps: their confidence is {sure:.2f},"
            f" and {SURE} is needed. Add pictures of other things, or turn the object between"
            " touches."
        )
    return Lamps(
        colours=found * _sign(fields, mixture),
        background=background,
        ratio=float(ratio),
        confidence=sure,
        pictures=len(small),
    )


def alone(picture: Array, *, dots: str = "fill") -> Lamps:
    """Return the lamps that one touch (H, W, 3) uint8 gives by itself, unchecked: confidence is 0.

    Slopes by them may be sheared or turned, but `drawn` shows how the gel bends, and that they
    change little: a head reads other sensors nearly as well as by lamps of 20 pictures.
    """
    fields = [derivatives(fast(reduced(clean(picture, dots), REDUCED)))]
    moments = moments_of(fields).mean(np.ones(1))
    mixture, (least, second) = curl_free(moments)
    found = colours_of(mixture, moments) * _sign(fields, mixture)
    return Lamps(
        colours=found * (np.abs(found).max() >= LEAST),  # less is rounding, in an even picture
        background=None,
        ratio=float(least / max(second, 1e-12)),
        confidence=0.0,
        pictures=1,
    )


def clean(picture: Array, dots: str) -> Array:
    """Return the picture (H, W, 3) uint8 without its dots; raises DataError for another array."""
    shape = np.shape(picture) if isinstance(picture, np.ndarray) else ()
    kind = picture.dtype if shape else type(picture).__name__
    if len(shape) != 3 or shape[2] != 3 or kind != np.uint8:
        raise DataError(
            f"A picture has shape {shape} and type {kind}; pass (height, width, 3)"
            " uint8, as numpy.asarray of an RGB image gives it."
        )
    if min(picture.shape[:2]) < SMALLEST:
        raise DataError(
            f"A picture has {picture.shape[1]} × {picture.shape[0]} pixels; its relief needs"
            f" {SMALLEST} × {SMALLEST} or more."
        )
    return fill_dots(picture)[0] if dots == "fill" else picture


def _sign(fields: list[Array], mixture: Array) -> int:
    """Return 1 if slopes of this mixture (2, 3) are those of a gel, -1 if they are its opposite.

    A gel bridges hollows and is pushed sharply by edges, so its curvature is skewed to negative.
    """
    skew = 0.0
    for _, right, down in fields:
        curvature = right @ mixture[0] + down @ mixture[1]
        spread = np.square(curvature).mean() ** 1.5
        skew += float(np.clip((curvature**3).mean() / max(spread, 1e-12), -3, 3))
    return -1 if skew > 0 else 1


def _confidence(moments: Moments, found: Array) -> float:
    """Return the cosine to `found` (3, 2) that 95 % of draws of the pictures exceed."""
    count = len(moments.colour)
    draws = np.random.default_rng(0).multinomial(count, np.full(count, 1 / count), DRAWS)
    mean = moments.mean(draws.astype(float))
    drawn = colours_of(curl_free(mean)[0], mean)
    size = np.linalg.norm(drawn, axis=(1, 2)) * np.linalg.norm(found)
    return float(np.quantile(np.abs((drawn * found).sum((1, 2))) / np.maximum(size, 1e-12), LEVEL))


def _require_one_gel(moments: Moments, ratio: float) -> None:
    """Raise NoLampsError for pictures without colour, contrast, or one relief under lamps."""
    count = len(moments.colour)
    mean = moments.mean(np.ones(count))
    first, second = np.linalg.eigvalsh(mean.right + mean.down)[:0:-1]
    contrast = float(np.sqrt(np.trace(mean.colour) / 3))
    if second < GREY * first:
        raise NoLampsError(
            "These pictures are grey, or nearly, or photographs: brightness changes in them, and"
            " hue hardly does, so they do not show from where light comes. Pass touch images of a"
            " gel with coloured lamps."
        )
    if ratio > WOUND and contrast < FAINT:
        raise NoLampsError(
            f"These pictures have too little contrast: colours vary by {contrast:.1f} of 255 around"
            " their slow light. Press harder, or on things with edges."
        )
    if count >= DIVIDED:
        left, other = split_of(moments)
        if left < MIXED:
            raise NoLampsError(
                f"These pictures are of two sensors or more, or some are turned: {sum(~other)} have"
                f" other lamps than {sum(other)}. Pass the pictures of each sensor by themselves."
            )
    if ratio > WOUND:
        raise UnsettledError(
            "The colours of these pictures are not those of a relief under lamps: the curl of the"
            f" best slopes is {ratio:.2f} of the next best's, and at most {WOUND} is accepted. Pass"
            " touch images of one gel with coloured lamps, neither turned nor recoloured."
        )
