"""Records of frames: the maps of a stage, and all data of a set of pairs."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from omnivat.head.checkpoint import Head


FEATURES = "features"  # the kind of frames without a head


def kind_of(head: "Head") -> str:
    """Return the kind of a head's frames: "every" if trained with random p, else "moved"."""
    return "every" if head.provenance.get("train", {}).get("order_draw") else "moved"


CLOSE = 0.0005  # quarter turns: a round stop this close to the learned order is replaced by it


def with_learned(orders: Sequence[float], learned: float | None) -> tuple[float, ...]:
    """Return the orders with a stop at exactly `learned`, ascending.

    A learned order outside the range of `orders` is not added, so the slider keeps its ends.

    >>> with_learned((0.0, 0.5, 1.0), 0.4983)
    (0.0, 0.4983, 0.5, 1.0)
    >>> with_learned((0.0, 0.5, 1.0), 0.5002)
    (0.0, 0.5002, 1.0)
    """
    given = sorted(float(order) for order in orders)
    if learned is None or not given or not given[0] <= learned <= given[-1]:
        return tuple(given)
    kept = [order for order in given if abs(order - learned) >= CLOSE]
    return tuple(sorted([*kept, float(learned)]))


LEVELS = 65535  # steps of a quantised coordinate


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MapFrames:
    """Maps of one stage by one method, quantised.

    points     (F, 2N, 2) u16: N VIS rows, then N TAC rows; 0 is `low` and 65535 is `high`
    orders     (F,) the stop of each frame; a single frame serves every stop
    low, high  corners of a square around all frames
    max_error  largest error of a stored coordinate, in map units
    trust      (F,) how far neighbours on the map are neighbours in space, 1 for all of them, from a
               sample (`omnivat.maps.projection.quality`); None where it was not measured
    """

    points: NDArray[np.uint16]
    orders: tuple[int, ...]
    low: tuple[float, float]
    high: tuple[float, float]
    max_error: float
    trust: tuple[float | None, ...]

    def places(self, frame: int) -> NDArray[np.float64]:
        """Return the coordinates of a frame, (2N, 2), in map units."""
        low = np.array(self.low)
        step = (np.array(self.high) - low) / LEVELS
        places: NDArray[np.float64] = low + self.points[frame] * step
        return places


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FrameSet:
    """The page's data for N pairs at P orders.

    orders       (P,) quarter turns
    domain       (N,) u8 index into `domains`
    label        (N,) u8 index into `classes`
    prediction   (P, N) u8 class predicted from both images, index into `classes`
    confidence   (P, N) u8 its probability; 255 is 1
    maps         "method/stage" -> frames
    curves       "measure/stage" -> P values; None if undefined
    head         where the head comes from: learned order, source domain, hash
    embeddings   where the embeddings come from: encoder, weights' hash, simulated, origin
    """

    orders: tuple[float, ...]
    domains: tuple[str, ...]
    classes: tuple[str, ...]
    domain: NDArray[np.uint8]
    label: NDArray[np.uint8]
    prediction: NDArray[np.uint8]
    confidence: NDArray[np.uint8]
    maps: Mapping[str, MapFrames]
    curves: Mapping[str, list[float | None]]
    head: Mapping[str, Any] = field(default_factory=dict)
    embeddings: Mapping[str, Any] = field(default_factory=dict)

    @property
    def pairs(self) -> int:
        return len(self.label)


def require_fit(frames: FrameSet) -> None:
    """Raise ValueError if parts of the frames do not fit together; the message names the part."""
    stops, pairs = len(frames.orders), frames.pairs
    shapes = {"domain": (pairs,), "prediction": (stops, pairs), "confidence": (stops, pairs)}
    for name, wanted in shapes.items():
        if getattr(frames, name).shape != wanted:
            raise ValueError(f"{name} has shape {getattr(frames, name).shape}, expected {wanted}")
    named = {"domain": frames.domains, "label": frames.classes, "prediction": frames.classes}
    for name, names in named.items():
        if getattr(frames, name).max() >= len(names):
            raise ValueError(f"a {name} has no name")
    for name, values in frames.curves.items():
        if len(values) != stops:
            raise ValueError(f"curve {name} has {len(values)} values for {stops} orders")
    for name, frame in frames.maps.items():
        wanted_shape = (len(frame.orders), 2 * pairs, 2)
        if frame.points.shape != wanted_shape or frame.points.dtype.itemsize != 2:
            raise ValueError(f"map {name} has shape {frame.points.shape}, expected {wanted_shape}")
        if not all(0 <= stop < stops for stop in frame.orders) or not frame.orders:
            raise ValueError(f"map {name} has a frame for a stop that does not exist")


def quantised(
    maps: list[NDArray[np.float64]], orders: tuple[int, ...], trust: tuple[float | None, ...]
) -> MapFrames:
    """Quantise maps (2N, 2) of one stage to u16 within one square around all of them."""
    stacked = np.stack(maps).astype(np.float64)
    flat = stacked.reshape(-1, 2)
    lowest, highest = flat.min(0), flat.max(0)
    middle, half = (lowest + highest) / 2, max(float((highest - lowest).max()) / 2, 1e-12)
    low, high = middle - half, middle + half
    points = np.rint((stacked - low) * (LEVELS / (2 * half))).clip(0, LEVELS).astype("<u2")
    drawn = low + points * (2 * half / LEVELS)
    return MapFrames(
        points=points,
        orders=orders,
        low=(float(low[0]), float(low[1])),
        high=(float(high[0]), float(high[1])),
        max_error=float(np.abs(drawn - stacked).max()),
        trust=trust,
    )
