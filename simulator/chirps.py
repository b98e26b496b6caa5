"""Chirps: synthetic pairs whose class shows at one fractional order only.

A class is a spike at order p*, interference is spikes at other orders. On disk, a set is two
pictures of stripes for each pair, and pairs.csv."""

from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Annotated

import numpy as np
import torch
from numpy.typing import NDArray

from omnivat.data.domains import SIMULATED_SUFFIX
from omnivat.data.pairs import Pair, PairSet
from omnivat.data.store import COLUMNS
from omnivat.data.strips import STRIPES, strip_picture
from omnivat.fractional import dfrft
from omnivat.kit.config import Within, require_declared
from omnivat.kit.files import replacing
from omnivat.kit.progress import OnStep, Step
from omnivat.kit.seeding import derive_seed
from omnivat.kit.stages import IMAGES
from simulator.noise import Rng, unit
from simulator.plan import write_table

DOMAINS = tuple(f"Chirps {letter}{SIMULATED_SUFFIX}" for letter in "ABCD")  # first the source
CLASSES = tuple(f"chirp {number}" for number in range(1, 6))
TEST_SHARE = 0.5  # of each class of each domain, rounded
CLEARANCE = 0.25  # least distance between p* and the order of any interference
SPIKES = 3  # of interference, at random positions
NOISE = 0.05  # standard deviation of white noise on every sample
Share = Annotated[float, Within(0.0, 1.0)]


@dataclass(frozen=True, slots=True, kw_only=True)
class ChirpSettings:
    """A set of chirps; docs/order.md has the recipe. The defaults give the shipped set."""

    order: Share = 0.35  # p*, where the signal of a class is a single spike, in [0, 1]
    strength: Annotated[float, Within(0.0, 1000.0)] = 2.0  # norm of interference over signal
    shift: Share = 1.0  # 0: all domains share the source's interference orders; 1: each has its own
    pairs_per_class: Annotated[int, Within(2, 100_000)] = 40  # of each domain
    seed: int = 0

    def __post_init__(self) -> None:
        require_declared(self)


def signals(settings: ChirpSettings) -> dict[str, NDArray[np.float32]]:
    """Return VIS and TAC (N, D) of the whole set, in the order of `pairs_of`.

    The same settings give the same numbers; a domain does not depend on the others. The largest
    magnitude of a signal is 1, as after reading its picture.
    """
    label = np.repeat(np.arange(len(CLASSES)), settings.pairs_per_class)
    return {
        name: np.concatenate(
            [
                _modality(
                    settings, label, order, derive_seed(settings.seed, "chirps", domain, name)
                )
                for domain, order in enumerate(own)
            ]
        )
        for name, own in zip(IMAGES, interference_orders(settings).T, strict=True)
    }


def origin(settings: ChirpSettings) -> str:
    """Return one line on the origin of the set."""
    louder = f"interference of {settings.strength:g} times its norm at other orders"
    return (
        f"made-up chirps: a class is a spike at order {settings.order:g}, {louder}, seed"
        f" {settings.seed}"
    )


def interference_orders(settings: ChirpSettings) -> NDArray[np.float64]:
    """Return each domain's interference orders of VIS and of TAC, (4, 2).

    They are spread evenly over [0, 1] outside p* ± 0.25 and then shuffled, so no two are equal.
    With shift < 1, later domains' orders lie between the source's and their own.
    """
    low, high = settings.order - CLEARANCE, settings.order + CLEARANCE
    below, above = max(low, 0.0), max(1.0 - high, 0.0)
    places = np.linspace(0.0, below + above, 2 * len(DOMAINS))
    orders = np.where(places <= below, places, places - below + high)
    drawn = np.random.default_rng(derive_seed(settings.seed, "orders")).permutation(orders)
    pairs = drawn.reshape(len(DOMAINS), 2)
    if low < 0.0:  # nothing fits below p*
        pairs = np.maximum(pairs, high)
    moved: NDArray[np.float64] = pairs[0] + settings.shift * (pairs - pairs[0])
    return moved


def places(settings: ChirpSettings) -> NDArray[np.int64]:
    """Return the position (K,) of each class's spike, in the first half of the axis.

    A mirrored signal has its spike at D - position, which belongs to no other class.
    """
    room = (STRIPES // 2 - 1) / len(CLASSES)  # entries for each class
    random = np.random.default_rng(derive_seed(settings.seed, "places"))
    inside = np.arange(len(CLASSES)) + 0.5 * random.random(len(CLASSES))
    return 1 + np.floor(room * inside).astype(np.int64)


def _modality(
    settings: ChirpSettings, label: NDArray[np.int64], order: float, seed: int
) -> NDArray[np.float32]:
    """Return one modality's signals (N, D) of classes (N,): spike, interference and noise."""
    count, rows, random = len(label), np.arange(len(label)), np.random.default_rng(seed)
    own, other = np.zeros((2, count, STRIPES), complex)
    own[rows, places(settings)[label]] = _phases(random, count)
    for _ in range(SPIKES):
        where = random.integers(0, STRIPES, count)
        other[rows, where] += _phases(random, count)
    mixed = unit(_real_at_zero(own, settings.order))
    mixed += settings.strength * unit(_real_at_zero(other, order))
    mixed += NOISE * random.standard_normal(mixed.shape)
    largest: NDArray[np.float64] = np.abs(mixed).max(1, keepdims=True)
    return (mixed / largest).astype(np.float32)


def _phases(random: Rng, count: int) -> NDArray[np.complex128]:
    return np.exp(2j * np.pi * random.random(count))


def _real_at_zero(sparse: NDArray[np.complex128], order: float) -> NDArray[np.float64]:
    """Return the real part of signals (N, D) that look like `sparse` at `order`."""
    return dfrft(torch.from_numpy(sparse), -order).numpy().real


def pairs_of(settings: ChirpSettings, folder: Path) -> tuple[Pair, ...]:
    """Return the pairs of the set in a folder, domain by domain and class by class."""
    count = settings.pairs_per_class
    test, found = round(TEST_SHARE * count), []
    for domain, kind, number in product(DOMAINS, CLASSES, range(count)):
        stem = f"{domain}/{kind}/{kind.replace(' ', '-')}-{number:03d}"
        found.append(
            Pair(
                vis=folder / f"{stem}_vis.png",
                tac=folder / f"{stem}_tac.png",
                domain=domain,
                material=kind,
                object=f"{domain} {kind} {number}",
                split="test" if number < test else "train",
            )
        )
    return tuple(found)


def write_chirps(out: Path, settings: ChirpSettings, *, on_step: OnStep) -> PairSet:
    """Write `<out>/<domain>/<class>/<name>_{vis,tac}.png` and `<out>/pairs.csv`; return the pairs.

    The same settings give the same bytes. `omnivat embed OUT --encoder strip --no-flips` reads the
    signals back.
    """
    pairs, drawn = pairs_of(settings, out), signals(settings)
    for row, pair in enumerate(pairs):
        for name in IMAGES:
            with replacing(getattr(pair, name)) as temporary:
                strip_picture(drawn[name][row]).save(temporary, format="PNG")
        on_step(Step(done=row + 1, total=len(pairs), text=pair.object))
    write_table(out, pairs, COLUMNS)
    return PairSet(pairs=pairs, origin=origin(settings), simulated=True)
