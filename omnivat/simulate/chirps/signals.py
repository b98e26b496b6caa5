"""Signals of chirps: a class is a spike at order p*, interference is spikes at other orders."""

import numpy as np
import torch
from numpy.typing import NDArray

from omnivat.data.embeddings import Embeddings, Header
from omnivat.data.store import ROW_NAMES
from omnivat.data.strips import ENCODER, PREPROCESSING, READER
from omnivat.fractional import dfrft
from omnivat.modalities import IMAGES
from omnivat.seeding import derive_seed
from omnivat.simulate.chirps.settings import CLEARANCE, ChirpSettings


def chirp_embeddings(settings: ChirpSettings) -> Embeddings:
    """Return the whole set in memory: VIS and TAC are signals (N, D).

    The same settings give the same numbers. The largest magnitude of a signal is 1, as after
    reading its picture.
    """
    count, domains = settings.pairs_per_class, settings.domains
    label = np.tile(np.repeat(np.arange(settings.classes), count), domains)
    domain = np.repeat(np.arange(domains), count * settings.classes)
    halves = [domain_signals(settings, number) for number in range(domains)]
    return Embeddings(
        header=Header(
            encoder=ENCODER,
            weights_hash=READER,
            preprocessing=PREPROCESSING,
            domains=settings.domain_names,
            classes=settings.class_names,
            simulated=True,
            origin=origin(settings),
        ),
        vis=np.concatenate([vis for vis, _ in halves]),
        tac=np.concatenate([tac for _, tac in halves]),
        domain=domain.astype(np.int64),
        label=label.astype(np.int64),
        rows=pair_names(settings),
    )


def origin(settings: ChirpSettings) -> str:
    """Return one line on the origin of the set."""
    return (
        f"made-up chirps: a class is a spike at order {settings.order:g}, interference of "
        f"{settings.strength:g} times its norm at other orders, seed {settings.seed}"
    )


def domain_signals(
    settings: ChirpSettings, domain: int
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Return VIS and TAC (N, D) of one domain, class by class, independent of other domains."""
    label = np.repeat(np.arange(settings.classes), settings.pairs_per_class)
    orders = interference_orders(settings)[domain]
    made = []
    for name, order in zip(IMAGES, orders, strict=True):
        random = np.random.default_rng(derive_seed(settings.seed, "chirps", domain, name))
        made.append(_signals(settings, label, order, random))
    return made[0], made[1]


def interference_orders(settings: ChirpSettings) -> list[tuple[float, float]]:
    """Return each domain's interference orders of VIS and of TAC.

    They are spread evenly over [0, 1] outside p* ± 0.25 and then shuffled, so no two are equal.
    With shift < 1, later domains' orders lie between the source's and their own.
    """
    low, high = settings.order - CLEARANCE, settings.order + CLEARANCE
    below, above = max(low, 0.0), max(1.0 - high, 0.0)
    places = np.linspace(0.0, below + above, 2 * settings.domains)
    orders = np.where(places <= below, places, places - below + high)
    drawn = np.random.default_rng(derive_seed(settings.seed, "orders")).permutation(orders)
    pairs = drawn.reshape(settings.domains, 2)
    if low < 0.0:  # nothing fits below p*
        pairs = np.maximum(pairs, high)
    moved = pairs[0] + settings.shift * (pairs - pairs[0])
    return [(float(vis), float(tac)) for vis, tac in moved]


def places(settings: ChirpSettings) -> NDArray[np.int64]:
    """Return the position (K,) of each class's spike, in the first half of the axis.

    A mirrored signal has its spike at D - position, which belongs to no other class.
    """
    room = (settings.width // 2 - 1) / settings.classes  # entries for each class
    random = np.random.default_rng(derive_seed(settings.seed, "places"))
    inside = np.arange(settings.classes) + 0.5 * random.random(settings.classes)
    chosen: NDArray[np.int64] = 1 + np.floor(room * inside).astype(np.int64)
    return chosen


def _signals(
    settings: ChirpSettings, label: NDArray[np.int64], order: float, random: np.random.Generator
) -> NDArray[np.float32]:
    """Return one modality's signals (N, D) of classes (N,): spike, interference and noise."""
    count, rows = len(label), np.arange(len(label))
    own = np.zeros((count, settings.width), complex)
    other = np.zeros_like(own)
    own[rows, places(settings)[label]] = _phases(random, count)
    for _ in range(settings.spikes):
        where = random.integers(0, settings.width, count)
        other[rows, where] += _phases(random, count)
    mixed = _unit(_real_at_zero(own, settings.order))
    mixed += settings.strength * _unit(_real_at_zero(other, order))
    mixed += settings.noise * random.standard_normal(mixed.shape)
    largest: NDArray[np.float64] = np.abs(mixed).max(1, keepdims=True)
    return (mixed / largest).astype(np.float32)


def _phases(random: np.random.Generator, count: int) -> NDArray[np.complex128]:
    drawn: NDArray[np.complex128] = np.exp(2j * np.pi * random.random(count))
    return drawn


def _real_at_zero(sparse: NDArray[np.complex128], order: float) -> NDArray[np.float64]:
    """Return the real part of signals (N, D) that look like `sparse` at `order`."""
    found: NDArray[np.float64] = dfrft(torch.from_numpy(sparse), -order).numpy().real
    return found


def _unit(rows: NDArray[np.float64]) -> NDArray[np.float64]:
    lengths: NDArray[np.float64] = np.linalg.norm(rows, axis=1, keepdims=True)
    return rows / np.maximum(lengths, 1e-12)


def pair_names(settings: ChirpSettings) -> dict[str, list[str]]:
    """Return the columns of the set's table, in the order of `chirp_embeddings`."""
    test = round(settings.test_share * settings.pairs_per_class)
    columns: dict[str, list[str]] = {name: [] for name in ROW_NAMES}
    for domain in settings.domain_names:
        for kind in settings.class_names:
            for number in range(settings.pairs_per_class):
                stem = f"{domain}/{kind}/{kind.replace(' ', '-')}-{number:03d}"
                cells = {
                    "vis": f"{stem}_vis.png",
                    "tac": f"{stem}_tac.png",
                    "object": f"{domain} {kind} {number}",
                    "split": "test" if number < test else "train",
                }
                for name, column in columns.items():
                    column.append(cells.get(name, ""))
    return columns
