"""The simulated domains: which sensor touches, which scene is photographed, where objects start.

A new domain is one row: a model of `sensors.py`, any scene, and a free `seed_base`.
"""

from dataclasses import dataclass

from omnivat.data.domains import DOMAINS
from omnivat.simulate.scenes import SCENES, Scene
from omnivat.simulate.sensors import SENSORS, SensorModel

NUMBERS = 10_000  # of objects of each class in a domain


@dataclass(frozen=True, slots=True, kw_only=True)
class SimulatedDomain:
    """One way of making pairs."""

    name: str  # its folder adds "-sim"
    sensor: SensorModel
    scene: Scene
    seed_base: int  # number of its first object; those of two domains are `NUMBERS` apart
    series: tuple[str, ...] = ()  # parts, such as "indoor" and "outdoor"
    ceramic: bool = True  # False: without ceramic objects


def _of_paper(name: str, sensor: str, seed_base: int) -> SimulatedDomain:
    own = DOMAINS[name]
    return SimulatedDomain(
        name=name,
        sensor=SENSORS[sensor],
        scene=SCENES[name],
        seed_base=seed_base,
        series=own.series,
        ceramic=own.ceramic,
    )


_PAPER = (
    _of_paper("TAG", "GelSight", 0),
    _of_paper("OF Real", "GelSlim", 10_000),
    _of_paper("OF 2.0 A", "Taxim GelSight", 20_000),  # two calibrations
    _of_paper("OF 2.0 B", "Taxim GelSight Mini", 30_000),
    _of_paper("TQ-DIGIT", "DIGIT", 40_000),
    _of_paper("TQ-GelMini", "GelSight Mini", 50_000),
    _of_paper("TQ-DuraGel", "DuraGel", 60_000),
    _of_paper("TQ-T3D", "Tac3D", 70_000),
)
SIMULATED = {domain.name: domain for domain in _PAPER}
