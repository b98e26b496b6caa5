"""Twins: one press of one object, imaged by every sensor and photographed in every scene.

No head has met the objects. All images of an object come from one solid, one spot, one press and
one seed, so that two of its touches differ in the sensor only, and two of its photographs in the
scene only.
"""

from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

from omnivat.data.materials import MATERIALS
from omnivat.data.pairs import PairSet
from omnivat.kit.errors import DataError
from omnivat.kit.progress import OnStep, ignore
from omnivat.kit.seeding import derive_seed
from omnivat.kit.tables import load
from omnivat.simulate.build import RENDERERS, finish, image_path, is_whole, on_disk, write_image
from omnivat.simulate.domains import SIMULATED, SimulatedDomain
from omnivat.simulate.drawing import tactile
from omnivat.simulate.noise import Array
from omnivat.simulate.photograph import photograph
from omnivat.simulate.plan import PAIRS, Planned, planned, write_table
from omnivat.simulate.things import Thing, thing

# Objects in TAG's mixture, with numbers that no domain uses.
UNMET = replace(SIMULATED["TAG"], name="Twins", seed_base=85_000)


@dataclass(frozen=True, slots=True, kw_only=True)
class Twin:
    """An object, and the domain whose sensor presses it and whose scene it stands in."""

    unmet: Planned
    domain: SimulatedDomain

    def pair(self) -> Planned:
        """Return the pair of the domain. It keeps the object's name, so `object` says whose twin
        it is.
        """
        series = self.domain.series
        part = series[self.unmet.number % len(series)] if series else ""
        return replace(self.unmet, made=self.domain, part=part)

    def image(self, kind: str, *, seed: int, size: int, renderer: str) -> Array:
        """Return the touch ("tac") or the photograph ("vis"), (size, size, 3) from 0 to 1."""
        made, stream = pressed(self.unmet, seed=seed)
        if kind == "tac":
            return tactile(made, self.domain.sensor, stream, size=size)
        return photograph(
            made,
            self.pair(),
            stream,
            size=size,
            renderer=load(RENDERERS, renderer, kind="renderer"),
        )


def unmet_objects(each: int = PAIRS) -> list[Planned]:
    """Return `each` objects of every class, in rounds of the classes; all are test objects.

    Raises DataError for less than one.
    """
    if each < 1:
        raise DataError(f"{each} objects of a class were requested; choose 1 or more.")
    of_class = (planned(UNMET, material, pairs=each) for material in MATERIALS)
    return [
        replace(pair, split="test") for in_turn in zip(*of_class, strict=True) for pair in in_turn
    ]


def pressed(unmet: Planned, *, seed: int) -> tuple[Thing, int]:
    """Return the object and the seed of its press, its photographs and their noise: one for all
    of its images.
    """
    return thing(unmet, seed=seed), derive_seed(
        seed, "pair", unmet.domain, unmet.material, unmet.object
    )


def simulate_twins(
    out: Path,
    *,
    each: int = PAIRS,
    seed: int = 0,
    size: int = 224,
    workers: int | None = None,
    renderer: str = "mitsuba",
    on_step: OnStep = ignore,
) -> PairSet:
    """Write `<out>/<domain>/<class>/<name>_{vis,tac}.png` and `<out>/pairs.csv`; return the pairs.

    A pair is a touch by the domain's sensor and a photograph in its scene. Pairs with the same
    `object` are twins. Touches come first, because a photograph costs ten times as much. Bytes,
    resuming and the other arguments are as for `omnivat.simulate.build.simulate`.

    Raises DataError for less than one object of a class, MissingPackageError if the renderer or
    Taxim is not installed.
    """
    twins = [
        Twin(unmet=unmet, domain=domain)
        for unmet in unmet_objects(each)
        for domain in SIMULATED.values()
    ]
    images = [(twin, kind) for kind in ("tac", "vis") for twin in twins]
    todo = [
        (twin, kind)
        for twin, kind in images
        if not is_whole(image_path(out, twin.pair(), kind), size)
    ]
    work = partial(_draw_to, out=out, seed=seed, size=size, renderer=renderer)
    finish(work, todo, total=len(images), workers=workers, on_step=on_step)
    pairs = tuple(on_disk(out, twin.pair()) for twin in twins)
    write_table(out, pairs)
    return PairSet(
        pairs=pairs,
        origin=f"twins simulated by omnivat, seed {seed}, {renderer} renderer",
        simulated=True,
    )


def _draw_to(image: tuple[Twin, str], *, out: Path, seed: int, size: int, renderer: str) -> str:
    twin, kind = image
    path = image_path(out, twin.pair(), kind)
    write_image(path, twin.image(kind, seed=seed, size=size, renderer=renderer))
    return path.relative_to(out).as_posix()
