"""The simulated domains: which sensor touches, which scene is photographed, where objects start.

A new domain is one row: a model of `sensors.py`, any scene, and a free `seed_base`.
"""

from dataclasses import dataclass

from omnivat.data.domains import DOMAINS
from simulator.scenes import SCENES, Scene
from simulator.sensors import SENSORS, SensorModel

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


_SENSORS = {  # name of the paper's domain -> its sensor
    "TAG": "GelSight",
    "OF Real": "GelSlim",
    "OF 2.0 A": "Taxim GelSight",  # two calibrations
    "OF 2.0 B": "Taxim GelSight Mini",
    "TQ-DIGIT": "DIGIT",
    "TQ-GelMini": "GelSight Mini",
    "TQ-DuraGel": "DuraGel",
    "TQ-T3D": "Tac3D",
}
SIMULATED = {
    name: SimulatedDomain(
        name=name,
        sensor=SENSORS[sensor],
        scene=SCENES[name],
        seed_base=NUMBERS * number,
        series=DOMAINS[name].series,
        ceramic=DOMAINS[name].ceramic,
    )
    for number, (name, sensor) in enumerate(_SENSORS.items())
}
