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
from simulator.sensors import Sensor
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
    """Return `each` objects of every class, in rounds of the classes: one in three is for testing.

    Raises DataError for less than one.
    """
    if each < 1:
        raise DataError(f"{each} objects of a class were requested; choose 1 or more.")
    of_class = (planned(UNMET, material, pairs=each) for material in MATERIALS)
    return [pair for in_turn in zip(*of_class, strict=True) for pair in in_turn]


def simulate_twins(
    out: Path,
    *,
    each: int = PAIRS,
    gels: bool = False,
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

    gels  touches alone, by the five gels with a camera, which need neither Taxim nor Mitsuba. A
          third of the objects is for testing, the others are for training on one of the gels.
          Otherwise no head has met the objects, and all of them are for testing.

    Raises DataError for less than one object of a class, MissingPackageError if the renderer or
    Taxim is not installed.
    """
    domains = [
        domain for domain in SIMULATED.values() if not gels or isinstance(domain.sensor, Sensor)
    ]
    unmet = [pair if gels else replace(pair, split="test") for pair in unmet_objects(each)]
    twins = [twin(pair, domain) for pair in unmet for domain in domains]
    images = [(pair, kind) for kind in ("tac", "vis")[: 2 - gels] for pair in twins]
    return draw_set(
        out, twins, images, origin=f"twins simulated by omnivat, seed {seed}",
        seed=seed, size=size, workers=workers, renderer=renderer, on_step=on_step,
    )  # fmt: skip
