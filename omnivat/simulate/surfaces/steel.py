"""Steel surfaces: brushed, milled, turned, ground, cast, rusty, chequered, knurled."""

import numpy as np

from omnivat.simulate.noise import Array, smoothstep
from omnivat.simulate.surfaces.base import (
    Surface,
    arcs,
    diamonds,
    grain,
    mixed,
    orange_peel,
    pick,
    pick_log,
    pits,
    scratches,
    streaks,
    stream,
    tinted,
    treads,
)

_STEELS = ((0.56, 0.55, 0.53), (0.62, 0.61, 0.60), (0.45, 0.44, 0.43), (0.52, 0.50, 0.46))
_RUST = np.array([0.22, 0.085, 0.035])


def _steel(rng: np.random.Generator) -> tuple[float, float, float]:
    return _STEELS[rng.integers(len(_STEELS))]


def brushed(rng: np.random.Generator) -> Surface:
    """Return sheet brushed one way: hair-thin long streaks, a stretched highlight."""
    angle, seed, base = pick(rng, 0, np.pi), stream(rng), _steel(rng)
    depth, width = pick_log(rng, 0.010, 0.026), pick(rng, 0.25, 0.5)

    def hairs(x: Array, y: Array) -> Array:
        return streaks(x, y, angle=angle, width=width, length=60.0, seed=seed)

    return Surface(
        recipe="brushed",
        relief=lambda x, y: depth * hairs(x, y),
        colour=lambda x, y: tinted(base, 0.07 * hairs(x, y)),
        gloss="metal", roughness=pick(rng, 0.12, 0.22), brushing=0.8, angle=angle,
    )  # fmt: skip


def machined(rng: np.random.Generator) -> Surface:
    """Return a milled or turned face: evenly spaced tool marks, bent as the cutter was."""
    far = pick_log(rng, 8, 150)
    turn = pick(rng, 0, 2 * np.pi)
    centre = (far * np.cos(turn), far * np.sin(turn))
    pitch, depth = pick_log(rng, 0.5, 1.3), pick_log(rng, 0.018, 0.045)
    seed, base = stream(rng), _steel(rng)

    def marks(x: Array, y: Array) -> Array:
        tooth = arcs(x, y, centre=centre, pitch=pitch)
        return tooth + 0.35 * arcs(x, y, centre=centre, pitch=pitch * 3.3)

    return Surface(
        recipe="machined",
        relief=lambda x, y: depth * marks(x, y) + 0.002 * grain(
            x, y, coarsest=0.6, finest=0.15, seed=seed),
        colour=lambda x, y: tinted(base, 0.06 * marks(x, y)),
        gloss="metal", roughness=pick(rng, 0.12, 0.25), brushing=0.6, angle=turn + np.pi / 2,
    )  # fmt: skip


def ground(rng: np.random.Generator) -> Surface:
    """Return polished or rolled steel: nearly smooth, scratched by use."""
    seed, base = stream(rng), _steel(rng)
    count, width = int(rng.integers(15, 60)), pick(rng, 0.05, 0.14)

    def lines(x: Array, y: Array) -> Array:
        return scratches(x, y, count=count, reach=30.0, width=width, seed=seed)

    return Surface(
        recipe="ground",
        relief=lambda x, y: 0.003 * orange_peel(x, y, size=4.0, seed=seed) - 0.02 * lines(x, y),
        colour=lambda x, y: tinted(base, -0.25 * lines(x, y)),
        gloss="metal", roughness=pick(rng, 0.04, 0.16),
    )  # fmt: skip


def cast(rng: np.random.Generator) -> Surface:
    """Return cast, forged or blasted steel: dull and evenly grainy, like a moulded plastic."""
    seed, base = stream(rng), _steel(rng)
    dark, depth = pick(rng, 0.3, 0.8), pick_log(rng, 0.012, 0.05)
    size = pick(rng, 0.8, 1.8)

    def rough(x: Array, y: Array) -> Array:
        return grain(x, y, coarsest=size, finest=0.15, seed=seed)

    return Surface(
        recipe="cast",
        relief=lambda x, y: depth * rough(x, y),
        colour=lambda x, y: dark * tinted(base, 0.10 * rough(x, y)),
        gloss="metal", roughness=pick(rng, 0.3, 0.45),
    )  # fmt: skip


def rusty(rng: np.random.Generator) -> Surface:
    """Return steel that rust has begun to eat: scabs that stand proud, pits between."""
    seed, base = stream(rng), _steel(rng)
    edge, depth = pick(rng, -0.6, 0.8), pick_log(rng, 0.03, 0.08)

    def scabs(x: Array, y: Array) -> Array:
        patches = grain(x, y, coarsest=14.0, finest=0.6, seed=seed)
        return smoothstep(patches, edge, edge + 0.5)

    def relief(x: Array, y: Array) -> Array:
        crust = 1.0 + 0.6 * grain(x, y, coarsest=1.5, finest=0.2, seed=seed + 20)
        holes = pits(x, y, size=2.2, radius=0.5, share=0.3, seed=seed + 40)
        return depth * (scabs(x, y) * crust - 0.8 * holes)

    def colour(x: Array, y: Array) -> Array:
        shade = 1.0 + 0.35 * grain(x, y, coarsest=3.0, finest=0.4, seed=seed + 60)
        return np.clip(mixed(tinted(base, 0 * x), _RUST * shade[..., None], scabs(x, y)), 0.01, 0.9)

    return Surface(
        recipe="rusty", relief=relief, colour=colour, gloss="metal",
        roughness=pick(rng, 0.3, 0.5),
    )  # fmt: skip


def chequered(rng: np.random.Generator) -> Surface:
    """Return tread plate: lens-shaped bars."""
    angle, seed, base = pick(rng, 0, np.pi), stream(rng), _steel(rng)
    pitch, rise = pick(rng, 7.0, 13.0), pick(rng, 0.35, 0.6)

    def relief(x: Array, y: Array) -> Array:
        skin = grain(x, y, coarsest=0.8, finest=0.2, seed=seed)
        return rise * treads(x, y, pitch=pitch, angle=angle) + 0.006 * skin

    return Surface(
        recipe="chequered", relief=relief,
        colour=lambda x, y: tinted(
            base, 0.06 * grain(x, y, coarsest=6.0, finest=0.5, seed=seed + 7)),
        gloss="metal", roughness=pick(rng, 0.2, 0.35), angle=angle,
    )  # fmt: skip


def knurled(rng: np.random.Generator) -> Surface:
    """Return a knurled grip: small pyramids on a shaft."""
    angle, seed, base = pick(rng, 0, np.pi), stream(rng), _steel(rng)
    pitch, rise = pick(rng, 0.9, 1.8), pick(rng, 0.10, 0.22)

    return Surface(
        recipe="knurled",
        relief=lambda x, y: rise * diamonds(x, y, pitch=pitch, angle=angle),
        colour=lambda x, y: tinted(base, 0.05 * orange_peel(x, y, size=3.0, seed=seed)),
        gloss="metal", roughness=pick(rng, 0.15, 0.25), angle=angle,
    )  # fmt: skip


RECIPES = {
    brushed: 2.0, machined: 1.5, ground: 1.2, cast: 0.6, rusty: 0.6, chequered: 0.5, knurled: 0.6,
}  # fmt: skip
