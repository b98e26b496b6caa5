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
from omnivat.data.embeddings import Embeddings, Header
from omnivat.data.pairs import Pair, PairSet
from omnivat.data.store import COLUMNS, ROW_NAMES
from omnivat.data.strips import ENCODER, PREPROCESSING, READER, STRIPES, strip_picture
from omnivat.fractional import dfrft
from omnivat.kit.config import Within, require_declared
from omnivat.kit.errors import SettingsError
from omnivat.kit.files import replacing, require_writable
from omnivat.kit.progress import OnStep, Step, ignore
from omnivat.kit.seeding import derive_seed
from omnivat.kit.stages import IMAGES
from omnivat.simulate.noise import Rng
from omnivat.simulate.plan import write_table

MOST_DOMAINS = 8
CLEARANCE = 0.25  # least distance between p* and the order of any interference
Share = Annotated[float, Within(0.0, 1.0)]
Size = Annotated[float, Within(0.0, 1000.0)]


@dataclass(frozen=True, slots=True, kw_only=True)
class ChirpSettings:
    """A set of chirps; docs/order.md has the recipe. The defaults give the shipped set."""

    width: Annotated[int, Within(8, 8192)] = 64  # D, samples of a signal
    order: Share = 0.35  # p*, where the signal of a class is a single spike, in [0, 1]
    strength: Size = 2.0  # norm of the interference over that of the signal
    noise: Size = 0.05  # standard deviation of white noise on every sample
    shift: Share = 1.0  # 0: all domains share the source's interference orders; 1: each has its own
    spikes: Annotated[int, Within(1, 64)] = 3  # of interference, at random positions
    domains: Annotated[int, Within(1, MOST_DOMAINS)] = 4  # the first is the source
    classes: Annotated[int, Within(2, 16)] = 5
    pairs_per_class: Annotated[int, Within(2, 100_000)] = 40  # of each domain
    test_share: Annotated[float, Within(0.0, 0.9)] = 0.5  # of each class of each domain, rounded
    seed: int = 0

    def __post_init__(self) -> None:
        require_declared(self)
        if self.classes > self.width // 2 - 1:
            raise SettingsError(
                f"{self.classes} classes need a width of {2 * self.classes + 2} or more, got"
                f" {self.width}."
            )

    @property
    def class_names(self) -> tuple[str, ...]:
        """The classes, "chirp 1" first."""
        return tuple(f"chirp {number + 1}" for number in range(self.classes))

    @property
    def domain_names(self) -> tuple[str, ...]:
        """The domains, "Chirps A-sim" first."""
        return tuple(f"Chirps {chr(65 + k)}{SIMULATED_SUFFIX}" for k in range(self.domains))


def chirp_embeddings(settings: ChirpSettings) -> Embeddings:
    """Return the whole set in memory: VIS and TAC are signals (N, D).

    The same settings give the same numbers. The largest magnitude of a signal is 1, as after
    reading its picture.
    """
    count, domains = settings.pairs_per_class, settings.domains
    label = np.tile(np.repeat(np.arange(settings.classes), count), domains).astype(np.int64)
    domain = np.repeat(np.arange(domains), count * settings.classes).astype(np.int64)
    header = Header(
        encoder=ENCODER, weights_hash=READER, preprocessing=PREPROCESSING, simulated=True,
        domains=settings.domain_names, classes=settings.class_names, origin=origin(settings),
    )  # fmt: skip
    vis, tac = map(
        np.concatenate,
        zip(*(domain_signals(settings, number) for number in range(domains)), strict=True),
    )
    return Embeddings(
        header=header, vis=vis, tac=tac, domain=domain, label=label, rows=pair_names(settings)
    )


def origin(settings: ChirpSettings) -> str:
    """Return one line on the origin of the set."""
    louder = f"interference of {settings.strength:g} times its norm at other orders"
    return (
        f"made-up chirps: a class is a spike at order {settings.order:g}, {louder}, seed"
        f" {settings.seed}"
    )


def domain_signals(
    settings: ChirpSettings, domain: int
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Return VIS and TAC (N, D) of one domain, class by class, independent of other domains."""
    label = np.repeat(np.arange(settings.classes), settings.pairs_per_class)
    orders = interference_orders(settings)[domain]
    seeds = (derive_seed(settings.seed, "chirps", domain, name) for name in IMAGES)
    made = [
        _signals(settings, label, p, np.random.default_rng(s))
        for p, s in zip(orders, seeds, strict=True)
    ]
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
    return 1 + np.floor(room * inside).astype(np.int64)


def _signals(
    settings: ChirpSettings, label: NDArray[np.int64], order: float, random: Rng
) -> NDArray[np.float32]:
    """Return one modality's signals (N, D) of classes (N,): spike, interference and noise."""
    count, rows = len(label), np.arange(len(label))
    own, other = np.zeros((2, count, settings.width), complex)
    own[rows, places(settings)[label]] = _phases(random, count)
    for _ in range(settings.spikes):
        where = random.integers(0, settings.width, count)
        other[rows, where] += _phases(random, count)
    mixed = _unit(_real_at_zero(own, settings.order))
    mixed += settings.strength * _unit(_real_at_zero(other, order))
    mixed += settings.noise * random.standard_normal(mixed.shape)
    largest: NDArray[np.float64] = np.abs(mixed).max(1, keepdims=True)
    return (mixed / largest).astype(np.float32)


def _phases(random: Rng, count: int) -> NDArray[np.complex128]:
    return np.exp(2j * np.pi * random.random(count))


def _real_at_zero(sparse: NDArray[np.complex128], order: float) -> NDArray[np.float64]:
    """Return the real part of signals (N, D) that look like `sparse` at `order`."""
    return dfrft(torch.from_numpy(sparse), -order).numpy().real


def _unit(rows: NDArray[np.float64]) -> NDArray[np.float64]:
    return rows / np.maximum(np.linalg.norm(rows, axis=1, keepdims=True), 1e-12)


def pair_names(settings: ChirpSettings) -> dict[str, list[str]]:
    """Return the columns of the set's table, in the order of `chirp_embeddings`."""
    test, count = round(settings.test_share * settings.pairs_per_class), settings.pairs_per_class
    every = list(product(settings.domain_names, settings.class_names, range(count)))
    stems = [
        f"{domain}/{kind}/{kind.replace(' ', '-')}-{number:03d}" for domain, kind, number in every
    ]
    found = {name: [""] * len(every) for name in ROW_NAMES}
    found |= {name: [f"{stem}_{name}.png" for stem in stems] for name in IMAGES}
    found["object"] = [f"{domain} {kind} {number}" for domain, kind, number in every]
    return found | {"split": ["test" if number < test else "train" for *_, number in every]}


def write_chirps(out: Path, settings: ChirpSettings, *, on_step: OnStep = ignore) -> PairSet:
    """Write `<out>/<domain>/<class>/<name>_{vis,tac}.png` and `<out>/pairs.csv`; return the pairs.

    The same settings give the same bytes. `omnivat embed OUT --encoder strip --no-flips` reads the
    signals back.

    Raises SettingsError for a width that does not fit a picture, WriteError if the folder is not
    writable.
    """
    if settings.width != STRIPES:
        raise SettingsError(
            f"width is {settings.width}; a picture shows {STRIPES} stripes. Use width={STRIPES}, "
            "or chirp_embeddings(settings) for signals without pictures."
        )
    require_writable(out / "pairs.csv")
    made = chirp_embeddings(settings)
    for row in range(len(made)):
        for name in IMAGES:
            with replacing(out / made.rows[name][row]) as temporary:
                strip_picture(getattr(made, name)[row]).save(temporary, format="PNG")
        on_step(Step(done=row + 1, total=len(made), text=made.rows["object"][row]))
    columns = {**made.rows, **{name: [out / file for file in made.rows[name]] for name in IMAGES}}
    columns["domain"] = [made.header.domains[k] for k in made.domain]
    columns["material"] = [made.header.classes[k] for k in made.label]
    pairs = tuple(
        Pair(**dict(zip(columns, row, strict=True))) for row in zip(*columns.values(), strict=True)
    )
    write_table(out, pairs, COLUMNS)
    return PairSet(pairs=pairs, origin=origin(settings), simulated=True)
