"""Boards, trays, boxes and bricks, and the parts of buildings that people touch."""

import numpy as np

from simulator.noise import Rng
from simulator.shapes.solid import (
    Made,
    Solid,
    assembled,
    block,
    grounded,
    joined,
    lathed,
    placed,
    sawn,
    slab,
    turned,
)


def board(rng: Rng, made: Made) -> Solid:
    """Return a cutting board."""
    return slab(
        made, rng.uniform(180, 300), rng.uniform(110, 190), rng.uniform(1.5, 2.5) * made.wall + 3
    )


def tray(rng: Rng, made: Made) -> Solid:
    """Return a shallow dish of rectangular plan."""
    half, deep, t = rng.uniform(60, 95), rng.uniform(18, 40), made.wall
    return sawn(lathed([
        (half * 0.88, 0.0, 5.0), (half * 0.97, deep, t * 0.5),
        (half * 0.97 + 5, deep + 0.4, t * 0.4), (half * 0.97 + 5, deep + 2.2, t * 0.4),
        (half * 0.97 - t, deep + 2.0, t * 0.5), (half * 0.88 - t, t, 5.0),
    ], power=7.0, oblong=rng.uniform(1.1, 1.6)))  # fmt: skip


def box(rng: Rng, made: Made) -> Solid:
    """Return a box with a lid that stands out a little."""
    x, y, z = rng.uniform(70, 150), rng.uniform(55, 110), rng.uniform(40, 90)
    bevel = made.bevel
    body = placed(block((x, y, z), bevel=bevel), at=(0, 0, z / 2))
    lid = placed(block((x + 4, y + 4, 12), bevel=min(bevel, 4)), at=(0, 0, z + 4))
    return assembled(body, lid)


def brick(rng: Rng, made: Made) -> Solid:
    """Return a brick or a block."""
    return slab(made, rng.uniform(90, 210), rng.uniform(60, 105), rng.uniform(40, 70))


def tile(rng: Rng, made: Made) -> Solid:
    """Return a thin square slab, lying."""
    side = rng.uniform(95, 160)
    return slab(made, side, side, made.wall + 3)


def pipe(rng: Rng, made: Made) -> Solid:
    """Return a piece of pipe, lying."""
    r, long, t = rng.uniform(10, 26), rng.uniform(120, 240), min(made.wall, 5.0)
    tube = turned(
        [(r - t, 0.0, 0.0), (r, 0.0, 0.6), (r, long, 0.6), (r - t, long, 0.6), (r - t, 0.0, 0.0)]
    )
    return grounded(placed(tube, roll=np.pi / 2, turn=rng.uniform(0, np.pi)))


def floor(rng: Rng, made: Made) -> Solid:
    """Return a piece of floor or table top, wider than a picture."""
    return slab(made, 900, 900, 12)


def panel(rng: Rng, made: Made) -> Solid:
    """Return an upright sheet, such as a door, a sign or a piece of wall; it faces -y."""
    return slab(made, rng.uniform(260, 640), rng.uniform(12, 30), rng.uniform(300, 620))


def post(rng: Rng, made: Made) -> Solid:
    """Return an upright, square or round."""
    half, tall = rng.uniform(25, 60), rng.uniform(600, 800)
    if rng.random() < 0.5:
        return slab(made, 2 * half, 2 * half, tall)
    return lathed([(half, 0.0, 2.0), (half, tall, 4.0)])


def bench(rng: Rng, made: Made) -> Solid:
    """Return a seat of planks on two feet."""
    wide, thick, count = rng.uniform(60, 100), rng.uniform(18, 30), rng.integers(2, 5)
    long, gap, bevel = rng.uniform(420, 620), rng.uniform(6, 14), made.bevel
    places = (np.arange(count) - (count - 1) / 2) * (wide + gap)
    planks = [
        placed(block((long, wide, thick), bevel=bevel), at=(0, y, 200 + thick / 2)) for y in places
    ]
    span = count * (wide + gap)
    feet = [
        placed(block((40, span, 200), bevel=3), at=(x, 0, 100)) for x in (-0.35 * long, 0.35 * long)
    ]
    return assembled(*planks, *feet)


def seat(rng: Rng, made: Made) -> Solid:
    """Return the seat of a stool: a thick disc or square on one leg."""
    r, thick = rng.uniform(120, 180), rng.uniform(18, 40)
    power = rng.choice([2.0, 6.0])
    top = turned(
        [(0.0, 0.0, 0.0), (r, 0.0, made.bevel), (r, thick, made.bevel), (0.0, thick - 2, 0.0)],
        power=power,
    )
    leg = lathed([(25, 0.0, 3.0), (25, 240, 3.0)])
    return sawn(joined(placed(top, at=(0, 0, 238)), leg))
