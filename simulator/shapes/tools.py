"""Tools and cutlery: bars, blades and prongs lying on the table."""

import numpy as np

from simulator.noise import Rng
from simulator.shapes.solid import Made, Solid, assembled, bar, block, lathed, placed, swept, turned


def handle(rng: Rng, made: Made, length: float) -> Solid:
    """Return a slightly bent bar along -x that ends at the origin, wider at its far end."""
    t = np.concatenate([[0.0, 0.004], np.linspace(0.012, 0.988, 40), [0.996, 1.0]])
    width = rng.uniform(3.0, 4.5) + rng.uniform(2.0, 5.0) * (1 - t) ** 1.5
    path = np.stack([-(1 - t) * length, 0 * t, rng.uniform(4, 12) * np.sin(np.pi * t)], axis=1)
    half = np.stack([width, np.minimum(0.9 * made.wall + 0.1 * width, width)], axis=1)
    return swept(path, half, power=3.0)


def spoon(rng: Rng, made: Made) -> Solid:
    """Return a spoon: an oval dish on a handle."""
    r, thick = rng.uniform(17, 26), min(made.wall, 5.0)
    deep = r * rng.uniform(0.3, 0.5)
    dish = lathed([
        (r * 0.75, 0.0, r * 0.6), (r, deep, thick * 0.5),
        (r - thick, deep, thick * 0.5), (r * 0.72, thick, r * 0.6),
    ], oblong=rng.uniform(1.3, 1.6))  # fmt: skip
    stem = placed(handle(rng, made, rng.uniform(110, 190)), at=(-1.15 * r, 0, deep - 1.0))
    return assembled(dish, stem)


def fork(rng: Rng, made: Made) -> Solid:
    """Return a fork of three or four prongs."""
    prongs, gap = rng.integers(3, 5), rng.uniform(5.5, 8)
    half, span = min(0.5 + 0.5 * made.wall, 2.4), rng.uniform(40, 60)
    places = (np.arange(prongs) - (prongs - 1) / 2) * gap
    tines = [bar((18, y, 3), (18 + span, y, 5), (half, half)) for y in places]
    palm = placed(block((28, gap * prongs, 3.0), bevel=1.4), at=(8, 0, 3))
    return assembled(*tines, palm, handle(rng, made, rng.uniform(110, 170)))


def spatula(rng: Rng, made: Made) -> Solid:
    """Return a turner: a flat blade, slotted or whole, on a handle."""
    long, wide, thick = rng.uniform(70, 110), rng.uniform(45, 80), min(made.wall, 6.0)
    slots = rng.choice([0, 0, 3])
    strips = slots + 1 if slots else 1
    each = wide / strips - (5 if slots else 0)
    places = (np.arange(strips) - (strips - 1) / 2) * wide / strips
    blade = [
        placed(block((long, each, thick), bevel=thick * 0.4), at=(long / 2, y, 3)) for y in places
    ]
    ends = [placed(block((12, wide - 5 * bool(slots), thick), bevel=thick * 0.4),
                   at=(x, 0, 3)) for x in (5, long - 5)] if slots else []  # fmt: skip
    return assembled(*blade, *ends, handle(rng, made, rng.uniform(140, 210)))


def comb(rng: Rng, made: Made) -> Solid:
    """Return a comb: a back and a row of teeth."""
    length, deep, pitch = rng.uniform(110, 170), rng.uniform(18, 30), rng.uniform(3.2, 5.0)
    back = placed(block((length, 14, 4.5), bevel=made.bevel), at=(0, 0, 2.3))
    teeth = [
        bar((x, -4, 2.3), (x, -6 - deep, 2.3), (pitch * 0.28, 1.6), power=2.5)
        for x in np.arange(-length / 2 + 6, length / 2 - 6, pitch)
    ]
    return assembled(back, *teeth)


def wrench(rng: Rng, made: Made) -> Solid:
    """Return an open-ended wrench: a flat shank with two jaws at an end, a ring at the other."""
    long, thick = rng.uniform(110, 180), rng.uniform(5, 8)
    shank = bar((-long / 2, 0, 0), (long / 2, 0, 0), (rng.uniform(6, 9), thick * 0.4))
    jaw = rng.uniform(13, 18)
    jaws = [
        placed(block((jaw * 1.8, jaw * 0.7, thick), bevel=made.bevel),
               at=(long / 2 + jaw * 0.7, side * jaw * 0.75, 0), turn=side * -0.15)
        for side in (-1, 1)
    ]  # fmt: skip
    ring = turned(
        [
            (jaw * 0.55, 0.0, 0.0),
            (jaw, 0.0, 1.2),
            (jaw, thick, 1.2),
            (jaw * 0.55, thick, 1.2),
            (jaw * 0.55, 0.0, 0.0),
        ]
    )
    heel = placed(block((jaw * 0.9, jaw * 2.0, thick), bevel=made.bevel), at=(long / 2, 0, 0))
    eye = placed(ring, at=(-long / 2 - jaw * 0.8, 0, -thick / 2))
    return assembled(shank, heel, *jaws, eye)
