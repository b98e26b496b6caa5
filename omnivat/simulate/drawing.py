"""Draw one planned pair: one thing, photographed and pressed at the same place."""

from dataclasses import dataclass

from omnivat.seeding import derive_seed
from omnivat.simulate.noise import Array
from omnivat.simulate.photograph import Renderer, photograph
from omnivat.simulate.plan import Planned
from omnivat.simulate.pressing import tactile
from omnivat.simulate.shading import shaded
from omnivat.simulate.things import thing


@dataclass(frozen=True, slots=True, kw_only=True)
class Drawn:
    """The two images of one pair, (size, size, 3) from 0 to 1."""

    vis: Array
    tac: Array


def drawn(pair: Planned, *, seed: int, size: int, renderer: Renderer = shaded) -> Drawn:
    """Return both images of `pair`; the same seed gives the same images."""
    made = thing(pair, seed=seed)
    stream = derive_seed(seed, "pair", pair.domain, pair.material, pair.object)
    return Drawn(
        vis=photograph(made, pair, stream, size=size, renderer=renderer),
        tac=tactile(made, pair.domain, stream, size=size),
    )
