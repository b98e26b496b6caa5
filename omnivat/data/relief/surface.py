"""Slopes and heights of a touch, by the lamps of its sensor."""

from dataclasses import replace
from typing import Any

import numpy as np

from omnivat.data.relief.filters import Array, blurred, fast, resized, scale
from omnivat.data.relief.lamps import Lamps, alone, clean
from omnivat.data.relief.moments import SMOOTH
from omnivat.kit.errors import DataError

BENT = 84.0  # of 255: twice what a curvature of 1 adds to a drawn picture


def slopes(picture: Array, lamps: Lamps, *, dots: str = "fill") -> Array:
    """Return the slopes (H, W, 2) float32, to the right and downwards, of a touch (H, W, 3) uint8.

    A slope is positive where the gel comes nearer to the camera; 1 is the root mean square over
    the pictures that gave the lamps. Relief broader than a fifth of the picture is lost with the
    slow light.

    Raises DataError for another array or other lamps, and if the lamps have a background of another
    aspect ratio.

    >>> from omnivat import EXAMPLES, lamps
    >>> from omnivat.data.images import read_image
    >>> files = sorted((EXAMPLES / "pairs" / "TAG-sim").glob("*/*_tac.jpg"))
    >>> touches = [np.asarray(read_image(file)) for file in files]
    >>> found = slopes(touches[0], lamps(touches))
    >>> found.shape, bool(np.abs(found).mean() > 0.2)
    ((224, 224, 2), True)
    """
    light = clean(picture, dots).astype(np.float32)
    if not isinstance(lamps, Lamps):
        raise DataError(
            f"The lamps have type {type(lamps).__name__}; pass what `lamps` returns for three"
            " pictures of the sensor or more."
        )
    height, width = light.shape[:2]
    if lamps.background is not None:
        down, across = lamps.background.shape[:2]
        if abs(height * across - width * down) > 0.03 * height * across:
            raise DataError(
                f"The picture has {width} × {height} pixels, and the lamps' background {across} ×"
                f" {down}; pass whole pictures of the same camera."
            )
        light -= resized(lamps.background.astype(np.float32), height, width)
    mixture = np.linalg.pinv(lamps.colours).T.astype(np.float32)
    return np.asarray(fast(light) @ mixture)


def heights(
    picture: Array, lamps: Lamps, *, pixel: float | None = None, dots: str = "fill"
) -> Array:
    """Return the heights (H, W) float32 of a touch (H, W, 3) uint8; the median is 0, towards the
    camera is positive.

    pixel  mm of a pixel. With it, and lamps whose steepness is known, heights are in mm; else the
           unit is what a slope of 1 rises in a pixel

    Raises DataError as `slopes` does, for a pixel that is not above 0, and if `pixel` is given and
    the steepness is unknown (`with_known_height`).

    >>> from omnivat import EXAMPLES, lamps
    >>> from omnivat.data.images import read_image
    >>> files = sorted((EXAMPLES / "pairs" / "TQ-DIGIT-sim").glob("*/*_tac.jpg"))
    >>> touches = [np.asarray(read_image(file)) for file in files]
    >>> found = heights(touches[0], lamps(touches))
    >>> found.shape, bool(abs(np.median(found)) < 1e-6)
    ((224, 224), True)
    """
    size = 1.0 if pixel is None else _number(pixel)
    if not 0 < size < np.inf:
        raise DataError(f"A pixel of {pixel!r:.40} mm gives no heights; give a number above 0.")
    if pixel is not None and isinstance(lamps, Lamps) and lamps.steepness is None:
        raise DataError(
            "Heights in mm need one known height beside the pixel's size; call with_known_height"
            " first."
        )
    found = integrated(slopes(picture, lamps, dots=dots))
    unit = 1.0 if pixel is None else size * (lamps.steepness or 1.0)
    return np.asarray((found - np.median(found)) * np.float32(unit))


def with_known_height(lamps: Lamps, picture: Array, *, pixel: float, height: float) -> Lamps:
    """Return the lamps with their steepness, from one touch of a thing of known height.

    picture  (H, W, 3) uint8, of a thing narrower than a fifth of the picture, such as a ball or a
             coin's letters
    pixel    mm of a pixel of this picture
    height   mm from the gel around it to its highest spot (the 99.9 % quantile)

    Raises DataError unless both are above 0 and the picture shows a relief.

    >>> from omnivat import EXAMPLES, lamps
    >>> from omnivat.data.images import read_image
    >>> files = sorted((EXAMPLES / "pairs" / "TQ-DIGIT-sim").glob("*/*_tac.jpg"))
    >>> touches = [np.asarray(read_image(file)) for file in files]
    >>> known = with_known_height(lamps(touches), touches[0], pixel=0.07, height=0.5)
    >>> found = heights(touches[0], known, pixel=0.07)  # mm
    >>> round(float(np.quantile(found, 0.999)), 3)
    0.5
    """
    rise = float(np.quantile(heights(picture, lamps), 0.999))
    size, top = _number(pixel), _number(height)
    if not all(0 < value < np.inf for value in (size, top, rise)):
        raise DataError(
            f"A pixel of {pixel!r:.40} mm and a height of {height!r:.40} mm, with a relief of"
            f" {rise:.3g}, give no scale; all three must be numbers above 0."
        )
    return replace(lamps, steepness=top / (size * rise))


def _number(value: Any) -> float:
    """Return a number, NaN for anything else."""
    try:
        return float(value)
    except (TypeError, ValueError, OverflowError):
        return np.nan


def drawn(picture: Array, lamps: Lamps | None = None, *, dots: str = "fill") -> Array:
    """Return a touch (H, W, 3) uint8 as an encoder reads its relief, (H, W, 3) uint8: how it bends.

    lamps  of its sensor; None: those of this picture alone, where nothing is known of the sensor

    All three channels are the relief's curvature: dark where it bends away like an edge, light in
    a hollow, mid-grey where it is even.
    """
    clear = clean(picture, dots)
    return painted(slopes(clear, lamps or alone(clear, dots="keep"), dots="keep"))


def painted(slopes: Array) -> Array:
    """Return slopes (H, W, 2) as a picture (H, W, 3) uint8 (`drawn`).

    Curvature is the divergence of the slopes, smoothed, and 1 is its root mean square in the
    picture; tanh bounds it.
    """
    smooth = blurred(slopes, SMOOTH * scale(slopes))
    bend = np.gradient(smooth[..., 0], axis=1) + np.gradient(smooth[..., 1], axis=0)
    bend /= np.sqrt(np.square(bend).mean()) + 1e-3  # rounding of an even picture stays small
    grey = np.rint(128 + 127.5 * np.tanh(bend * (BENT / 255)))
    return np.repeat(np.clip(grey, 0, 255).astype(np.uint8)[..., None], 3, axis=2)


def integrated(slopes: Array) -> Array:
    """Return the heights (H, W), of mean 0, whose differences are nearest to slopes (H, W, 2).

    Least squares between neighbouring pixels is Poisson's equation with free edges, which the
    discrete cosine transform solves exactly.

    >>> y, x = np.mgrid[:40, :50]
    >>> hill = 3 * np.exp(-((x - 20) ** 2 + (y - 25) ** 2) / 90)
    >>> down, right = np.gradient(hill)
    >>> found = integrated(np.stack([right, down], -1))
    >>> bool(np.abs(found - (hill - hill.mean())).max() < 0.05)
    True
    """
    from scipy.fft import dctn, idctn

    height, width = slopes.shape[:2]
    divergence = np.zeros((height, width), slopes.dtype)
    right, down = slopes[..., 0], slopes[..., 1]
    between = (right[:, 1:] + right[:, :-1]) / 2
    divergence[:, :-1] += between
    divergence[:, 1:] -= between
    between = (down[1:] + down[:-1]) / 2
    divergence[:-1] += between
    divergence[1:] -= between
    waves = [2 * np.cos(np.pi * np.arange(length) / length) - 2 for length in (height, width)]
    curvature = (waves[0][:, None] + waves[1]).astype(slopes.dtype)
    curvature[0, 0] = 1
    spectrum = dctn(divergence, norm="ortho") / curvature
    spectrum[0, 0] = 0
    return np.asarray(idctn(spectrum, norm="ortho"))


def ply(heights: Array) -> bytes:
    """Return the heights (H, W) as a surface in a binary PLY file, for any 3-D program.

    A pixel is 1 long; right is x, up y, and towards the camera z, in the unit of the heights.

    >>> ply(np.zeros((3, 4)))[:3]
    b'ply'
    """
    rows, columns = np.indices(heights.shape)
    points = np.stack([columns, -rows, heights], -1).reshape(-1, 3).astype("<f4")
    at = np.arange(heights.size).reshape(heights.shape)
    a, b, c, d = at[:-1, :-1], at[:-1, 1:], at[1:, :-1], at[1:, 1:]
    corners = np.stack([a, c, b, b, c, d], -1).reshape(-1, 3)
    faces = np.empty(len(corners), [("n", "u1"), ("corners", "<i4", 3)])
    faces["n"], faces["corners"] = 3, corners
    head = (
        f"ply\nformat binary_little_endian 1.0\nelement vertex {len(points)}\n"
        "property float x\nproperty float y\nproperty float z\n"
        f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    return head.encode() + points.tobytes() + faces.tobytes()
