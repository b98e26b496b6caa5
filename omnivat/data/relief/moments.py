"""What a picture's colours and their derivatives share, and the slopes without curl in them.

For small slopes g = (right, down), a picture without its slow light is D = M g. Slopes are two
mixtures of its colours, g = A D, and a relief has no curl: ∂g₁/∂y = ∂g₂/∂x. The curl's energy is
quadratic in A's six entries, so the A of least curl for its energy is an eigenvector.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from omnivat.data.relief.filters import blurred, scale

Array = np.ndarray[Any, np.dtype[Any]]
SMOOTH = 1.5  # pixels of 224: grain is smoothed away
RIM = 6.0  # pixels of 224 that are left out at the edge
BRIGHTEST = 0.995  # share of the pixels that are kept as they are; specks and glare are dimmed
GRAIN = 1e-3  # of the derivatives' energy: what is added as if it were grain of every colour
SPLITS, ROUNDS = 8, 12  # starts of the search for two sensors, and rounds of each


@dataclass(frozen=True, slots=True)
class Moments:
    """Mean products of pictures' fast colours D and their derivatives, each (..., 3, 3)."""

    colour: Array  # D Dᵀ
    right: Array  # ∂D/∂x ∂D/∂xᵀ
    down: Array  # ∂D/∂y ∂D/∂yᵀ
    cross: Array  # ∂D/∂x ∂D/∂yᵀ

    @property
    def energy(self) -> Array:
        """What both derivatives hold of each pair of colours, and a little grain."""
        energy = self.right + self.down
        grain = GRAIN * np.trace(energy, axis1=-2, axis2=-1)[..., None, None]
        return np.asarray(energy + 2 * (grain + 1e-9) * np.eye(3))

    @property
    def curl(self) -> Array:
        """The energy (..., 6, 6) of the curl, in A's entries: first row, then second."""
        grain = (self.energy - self.right - self.down) / 2
        top = np.concatenate([self.down + grain, -self.cross.swapaxes(-1, -2)], -1)
        bottom = np.concatenate([-self.cross, self.right + grain], -1)
        return np.concatenate([top, bottom], -2)

    def mean(self, weights: Array) -> "Moments":
        """Return the mean over pictures, by weights (..., n)."""
        share = weights / weights.sum(-1, keepdims=True)
        return Moments(
            *(
                np.tensordot(share, moment, 1)
                for moment in (self.colour, self.right, self.down, self.cross)
            )
        )


def moments_of(pictures: Iterable[Array]) -> Moments:
    """Return the moments (n, 3, 3) of pictures' derivatives, each (3, H, W, 3)."""
    sums = []
    for picture in pictures:
        colour, right, down = picture.reshape(3, -1, 3)
        pairs = (colour, colour), (right, right), (down, down), (right, down)
        sums.append([(a.T @ b).astype(float) / len(a) for a, b in pairs])
    return Moments(*np.stack(sums, 1))


def derivatives(picture: Array) -> Array:
    """Return a picture's fast colours (H, W, 3) and their derivatives to the right and down, (3, h,
    w, 3): smoothed, without the rim, outliers dimmed.
    """
    rim = max(1, round(RIM * scale(picture)))
    kept = blurred(picture, SMOOTH * scale(picture))[rim:-rim, rim:-rim]
    strength = np.sqrt(np.square(kept).sum(-1))
    most = np.partition(strength.ravel(), place := int(BRIGHTEST * strength.size))[place]
    kept = kept * np.minimum(1, most / np.maximum(strength, 1e-6))[..., None]
    right, down = kept[1:-1, 2:] - kept[1:-1, :-2], kept[2:, 1:-1] - kept[:-2, 1:-1]
    return np.stack([kept[1:-1, 1:-1], right / 2, down / 2])


def curl_free(moments: Moments) -> tuple[Array, Array]:
    """Return A (..., 2, 3) of the slopes with the least curl, up to scale and sign, and the curl's
    two smallest shares (..., 2) of the derivatives' energy, 0 to 1/2 each.
    """
    values, vectors = np.linalg.eigh(moments.energy)
    white = vectors / np.sqrt(values)[..., None, :]
    both = np.kron(np.eye(2), white)
    least, ways = np.linalg.eigh(both.swapaxes(-1, -2) @ moments.curl @ both)
    return (both @ ways[..., :1]).reshape(*least.shape[:-1], 2, 3), least[..., :2]


def colours_of(mixture: Array, moments: Moments) -> Array:
    """Return M (..., 3, 2), the colours that slopes A D (A: `mixture`) of mean square 1 add."""
    shared = moments.colour @ mixture.swapaxes(-1, -2)
    energy = mixture @ shared
    size = np.sqrt(np.trace(energy, axis1=-2, axis2=-1) / 2)[..., None, None]
    return np.asarray(shared @ np.linalg.pinv(energy) * size)


def split_of(moments: Moments) -> tuple[float, Array]:
    """Return how much of the curl stays if pictures are divided among two sensors' slopes, 0 to 1,
    and which pictures (n,) are the second's. Groups hold two pictures or more.
    """
    curl, energy = moments.curl, np.kron(np.eye(2), moments.energy)
    count, rng = len(curl), np.random.default_rng(0)
    everything = curl_free(moments.mean(np.ones(count)))[1][0]
    best, kept = 1.0, np.zeros(count, bool)
    for _ in range(SPLITS):
        second = rng.permutation(count) < count // 2
        for _ in range(ROUNDS):
            ways = curl_free(moments.mean(np.stack([~second, second]).astype(float)))[0]
            a = ways.reshape(2, 1, 1, 6)
            wound, all_of = (
                (a @ matrix @ a.swapaxes(-1, -2))[..., 0, 0] for matrix in (curl, energy)
            )
            nearer = wound[1] * all_of[0] < wound[0] * all_of[1]
            if min(nearer.sum(), (~nearer).sum()) < 2 or (nearer == second).all():
                break
            second = nearer
        if min(second.sum(), (~second).sum()) < 2:
            continue
        rows = second.astype(int), np.arange(count)
        left = wound[rows].sum() / all_of[rows].sum() / everything
        if left < best:
            best, kept = float(left), second
    return best, kept
