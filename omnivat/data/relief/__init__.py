"""A gel's lamps from a few pictures without labels, and the relief that its colours show.

`moments.py` sums what a picture's colours and their derivatives share; `lamps.py` finds the lamps
from these sums, or refuses; `surface.py` computes slopes and heights by the lamps. docs/relief.md
derives them.
"""

from omnivat.data.relief.lamps import Lamps, NoLampsError, UnsettledError, alone, lamps
from omnivat.data.relief.surface import drawn, heights, ply, slopes, with_known_height

__all__ = [
    "Lamps",
    "NoLampsError",
    "UnsettledError",
    "alone",
    "drawn",
    "heights",
    "lamps",
    "ply",
    "slopes",
    "with_known_height",
]
