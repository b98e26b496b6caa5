"""Chirps of a second program, which shares no line with omnivat.simulate.chirps.

It differs where a search could lean on the first: places of classes are random, interference may be
as near as 0.1 to p*, at the ends of [0, 1] and of any number of spikes, and one modality may be
without a signal.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray

from omnivat.data.embeddings import Embeddings, Header
from omnivat.fractional import dfrft

NOISE = 0.05


@dataclass(frozen=True, slots=True, kw_only=True)
class Recipe:
    """One draw: everything but the numbers of its signals."""

    order: float  # p*
    near: tuple[tuple[float, float], ...]  # interference orders of VIS and TAC, by domain
    width: int = 64
    spikes: int = 3
    strength: float = 2.0
    blind: str = ""  # modality without a signal: "vis", "tac" or neither
    classes: int = 5
    pairs: int = 100  # of each domain
    seed: int = 0


def drawn(seed: int, **fixed: Any) -> Recipe:
    """Draw a recipe: p* in [0, 1], interference 0.1 to 0.25 from it or at an end of [0, 1]."""
    random = np.random.default_rng([2718, seed])
    order = float(
        fixed.pop("order", random.choice([random.uniform(0, 1), 0.0, 1.0], p=[0.9, 0.05, 0.05]))
    )
    near = tuple((_near(order, random), _near(order, random)) for _ in range(3))
    values: dict[str, Any] = {
        "order": order,
        "near": near,
        "width": int(random.choice([32, 64, 64, 64, 96])),
        "spikes": int(random.integers(1, 7)),
        "blind": str(random.choice(["", "", "", "vis", "tac"])),
        "seed": seed,
    }
    return Recipe(**(values | fixed))


def _near(order: float, random: np.random.Generator) -> float:
    """Return an order of interference in [0, 1]: near p*, at an end, or anywhere 0.25 away."""
    far = [q for q in (0.0, 1.0, float(random.uniform(0, 1))) if abs(q - order) >= 0.25]
    close = [order + side * random.uniform(0.1, 0.25) for side in (-1, 1)]
    inside = [q for q in close if 0 <= q <= 1]
    return float(random.choice([float(random.choice(far)), *inside]))


def embeddings_of(recipe: Recipe) -> Embeddings:
    """Return the set: three domains, the first of which is the source."""
    random = np.random.default_rng([3141, recipe.seed])
    place = random.permutation(np.arange(1, recipe.width // 2))[: recipe.classes]
    label = np.tile(np.arange(recipe.pairs) % recipe.classes, len(recipe.near))
    halves = [
        np.concatenate([_signals(recipe, place, q[m], name, random) for q in recipe.near])
        for m, name in enumerate(("vis", "tac"))
    ]
    rows = {c: [""] * len(label) for c in ("vis", "tac", "split", "part")}
    domains = tuple("abc"[: len(recipe.near)])
    return Embeddings(
        header=Header(
            encoder="other chirps",
            weights_hash="0",
            preprocessing="",
            domains=domains,
            classes=tuple("ABCDEFGH"[: recipe.classes]),
            simulated=True,
        ),
        vis=halves[0],
        tac=halves[1],
        domain=np.repeat(np.arange(len(domains)), recipe.pairs).astype(np.int64),
        label=label.astype(np.int64),
        rows=rows | {"object": [str(k) for k in range(len(label))]},
    )


def _signals(
    recipe: Recipe, place: NDArray[Any], order: float, name: str, random: np.random.Generator
) -> NDArray[np.float32]:
    rows = np.arange(recipe.pairs)
    spike, other = np.zeros((2, recipe.pairs, recipe.width), complex)
    spike[rows, place[rows % recipe.classes]] = np.exp(2j * np.pi * random.random(len(rows)))
    for _ in range(recipe.spikes):
        phase = np.exp(2j * np.pi * random.random(len(rows)))
        other[rows, random.integers(0, recipe.width, len(rows))] += phase
    signal, noise = (
        dfrft(torch.from_numpy(z), -p).real.numpy()
        for z, p in ((spike, recipe.order), (other, order))
    )
    signal, noise = (
        z / np.linalg.norm(z, axis=1, keepdims=True).clip(1e-9) for z in (signal, noise)
    )
    white = NOISE * random.standard_normal(signal.shape)
    mixed: NDArray[np.float64] = (name != recipe.blind) * signal + recipe.strength * noise + white
    return mixed.astype(np.float32)
