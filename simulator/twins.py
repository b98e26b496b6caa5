"""Twins: one press of one object, imaged by every sensor and photographed in every scene.

No head has met the objects. All images of an object come from one solid, one spot, one press and
one seed, so that two of its touches differ in the sensor only, and two of its photographs in the
scene only.
"""

from dataclasses import replace
from pathlib import Path

from omnivat.data.materials import MATERIALS
from omnivat.data.pairs import PairSet
from omnivat.kit.errors import DataError
from omnivat.kit.progress import OnStep, ignore
from simulator.build import draw_set
from simulator.domains import SIMULATED, SimulatedDomain
from simulator.photograph import Renderer
from simulator.plan import PAIRS, Planned, planned
from simulator.vision import rendered

# Objects in TAG's mixture, with numbers that no domain uses.
UNMET = replace(SIMULATED["TAG"], name="Twins", seed_base=85_000)


def twin(unmet: Planned, domain: SimulatedDomain) -> Planned:
    """Return the pair of an object that the domain's sensor presses and whose scene it stands in.

    It keeps the object's name, so `object` states whose twin it is.
    """
    series = domain.series
    part = series[unmet.number % len(series)] if series else ""
    return replace(unmet, made=domain, part=part, twin_of=unmet)


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


def simulate_twins(
    out: Path,
    *,
    each: int = PAIRS,
    seed: int = 0,
    size: int = 224,
    workers: int | None = None,
    renderer: Renderer = rendered,
    on_step: OnStep = ignore,
) -> PairSet:
    """Write `<out>/<domain>/<class>/<name>_{vis,tac}.png` and `<out>/pairs.csv`; return the pairs.

    A pair is a touch by the domain's sensor and a photograph in its scene. Pairs with the same
    `object` are twins. Touches come first, because a photograph costs ten times as much. Bytes,
    resuming and the other arguments are as for `simulator.build.simulate`.

    Raises DataError for less than one object of a class, MissingPackageError if the renderer or
    Taxim is not installed.
    """
    twins = [twin(unmet, domain) for unmet in unmet_objects(each) for domain in SIMULATED.values()]
    images = [(pair, kind) for kind in ("tac", "vis") for pair in twins]
    return draw_set(
        out, twins, images, origin=f"twins simulated by omnivat, seed {seed}",
        seed=seed, size=size, workers=workers, renderer=renderer, on_step=on_step,
    )  # fmt: skip
