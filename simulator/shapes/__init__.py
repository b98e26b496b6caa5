"""Procedural solids at true scale, and the shapes of each material.

Materials share shapes, as in a kitchen: a bowl may be any of the five.
"""

from collections.abc import Callable

import numpy as np

from simulator.noise import Rng
from simulator.shapes import flats, tools, vessels
from simulator.shapes.solid import Made, Solid, made_of
from simulator.shapes.spots import Spot, blocked, spot

__all__ = [
    "KINDS",
    "OBJECTS",
    "PARTS",
    "Made",
    "Solid",
    "Spot",
    "blocked",
    "kind_of",
    "made_of",
    "spot",
]

KINDS: dict[str, Callable[[Rng, Made], Solid]] = {
    shape.__name__: shape
    for shape in (
        vessels.bowl, vessels.cup, vessels.mug, vessels.tumbler, vessels.plate, vessels.vase,
        vessels.bottle, vessels.can, vessels.candlestick, tools.spoon, tools.fork, tools.spatula,
        tools.comb, tools.wrench, flats.board, flats.tray, flats.box, flats.brick, flats.tile,
        flats.pipe, flats.floor, flats.panel, flats.post, flats.bench, flats.seat,
    )
}  # fmt: skip


def _weights(table: str) -> dict[str, dict[str, float]]:
    """Return material -> name of a shape -> weight."""
    rows = (row.split(": ") for row in table.strip().splitlines())
    return {
        material: {name: float(weight) for name, weight in map(str.split, shapes.split(", "))}
        for material, shapes in rows
    }


OBJECTS = _weights("""
wood: spoon 3, spatula 2, board 3, bowl 3, comb 1, fork 1, box 2, candlestick 2, plate 1, \
    tray 2, brick 2, cup 1, vase 1
steel: spoon 3, fork 3, wrench 2, bowl 3, cup 2, spatula 2, can 2, tray 2, pipe 2, bottle 1, \
    plate 1, candlestick 1, box 1, mug 1
plastic: cup 2, mug 1, spatula 2, bowl 3, bottle 2, board 2, comb 2, tray 2, box 2, plate 2, \
    tumbler 1, spoon 1, pipe 1, fork 1, brick 1
ceramic: mug 3, vase 2, bowl 3, plate 3, cup 2, tile 2, brick 1, spoon 1, candlestick 1, tray 2, \
    bottle 1
glass: tumbler 3, vase 2, bowl 3, plate 2, bottle 3, cup 2, candlestick 1, tray 1, board 1, \
    mug 1, tile 1
""")  # what is photographed whole
PARTS = _weights("""
wood: floor 2, panel 3, post 3, bench 3, seat 2, box 1, board 1
steel: panel 3, post 3, pipe 2, floor 1, can 1, bench 1, seat 1, bowl 1
plastic: panel 2, seat 3, box 2, bench 1, post 1, floor 1, bottle 1, tray 2
ceramic: floor 3, panel 2, brick 2, vase 3, tile 2, plate 1, bowl 1
glass: panel 4, floor 1, bottle 2, vase 2, bowl 1, tumbler 1
""")  # what is met indoors and outdoors


def kind_of(weights: dict[str, float], rng: Rng) -> str:
    """Draw the name of a shape."""
    share = np.array(list(weights.values()), dtype=np.float64)
    return str(rng.choice(list(weights), p=share / share.sum()))
