"""A surface on a solid: pictures of colour and bumps, and the unresolved slopes."""

from dataclasses import dataclass

import numpy as np

from omnivat.simulate.framing import Framing
from omnivat.simulate.noise import Array, turned
from omnivat.simulate.surfaces import Surface
from omnivat.simulate.things import Thing

_TEXELS = 28_000
_FINER = 2  # samples along each side of a texel
_MARGIN = 1.3  # of the view, around the contact; parts farther away are not in the picture


@dataclass(frozen=True, slots=True, kw_only=True)
class Texture:
    """Pictures on the solid's uv; the first row is the smallest v.

    uv         (V, 2) of each vertex, 0 to 1 over the pictures
    colour     (H, W, 3) linear
    bumps      (H, W) mm
    slopes     root-mean-square slopes along u and v, too fine for the pictures
    """

    uv: Array
    colour: Array
    bumps: Array
    slopes: tuple[float, float]


def textured(thing: Thing, framing: Framing) -> Texture:
    """Return the thing's appearance on its solid, at the resolution of a photograph."""
    uv = thing.solid.uv
    reach = _MARGIN * framing.view
    low = np.maximum(uv.min(0), thing.spot.uv - reach)
    high = np.maximum(np.minimum(uv.max(0), thing.spot.uv + reach), low + 1.0)
    step = float(np.sqrt(np.prod(high - low) / _TEXELS))
    columns, rows = (int(n) for n in np.maximum(np.ceil((high - low) / step), 2))
    fine = [
        (np.arange(_FINER * count) + 0.5) / (_FINER * count) * (b - a) + a
        for count, a, b in zip((columns, rows), low, high, strict=True)
    ]
    u, v = np.meshgrid(*fine)
    shape = (rows, _FINER, columns, _FINER)
    return Texture(
        uv=(uv - low) / (high - low),
        colour=thing.sight.colour(u, v).reshape(*shape, 3).mean((1, 3)),
        bumps=thing.sight.relief(u, v).reshape(shape).mean((1, 3)),
        slopes=unresolved_slopes(thing.sight, thing.spot.uv, spacing=step),
    )


def unresolved_slopes(surface: Surface, at: Array, *, spacing: float) -> tuple[float, float]:
    """Return root-mean-square slopes along and across the axis that texels of `spacing` mm lose.

    They widen the highlight, as in nature: from a distance, a brushed sheet is a rough mirror.
    """
    axis = np.arange(-48, 48) * (spacing / 6)
    along, across = np.meshgrid(axis, axis)
    u, v = turned(along, across, -surface.angle)
    relief = surface.relief(u + at[0], v + at[1])
    fine = np.gradient(relief, spacing / 6)
    coarse = np.gradient(relief.reshape(16, 6, 16, 6).mean((1, 3)), spacing)
    lost = [max(float(f.var() - c.var()), 0.0) for f, c in zip(fine, coarse, strict=True)]
    return float(np.sqrt(lost[1])), float(np.sqrt(lost[0]))
