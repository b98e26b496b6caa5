"""The simulated domains: which sensor touches, which scene is photographed, where objects start.

A new sensor is one row: a model of `sensors.py`, any scene, and a free `seed_base`.
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


# in the order of the paper, which numbers the objects; a new domain goes behind them
_TAXIM = {"OF 2.0 A": "Taxim GelSight", "OF 2.0 B": "Taxim GelSight Mini"}  # two calibrations
SIMULATED = {
    name: SimulatedDomain(
        name=name, sensor=SENSORS[_TAXIM.get(name, own.sensor)], scene=SCENES[name], seed_base=rank * NUMBERS,
        series=own.series, ceramic=own.ceramic,
    )
    for rank, (name, own) in enumerate(DOMAINS.items())
}  # fmt: skip
