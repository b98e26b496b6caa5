"""The tactile sensors: a gel with lamps and a camera, a calibration of Taxim, or Tac3D.

The parameters of the gels come from published pictures and descriptions of the sensors, not from
measurements on devices. They set the visible differences (lamps, tint, markers, softness, field),
not calibrated colour.
"""

from dataclasses import dataclass
from typing import NamedTuple

from simulator.noise import Colour


class Lamp(NamedTuple):
    """A row of LEDs at one side of the gel."""

    azimuth: float  # degrees: 0 lights from the right, 90 from the top
    colour: Colour  # added light on a 45-degree slope towards it
    spill: float  # unevenness on the flat gel; 0 is even


@dataclass(frozen=True, slots=True, kw_only=True)
class Markers:
    """Dark dots printed on the gel."""

    pitch: float  # mm
    radius: float  # mm
    uneven: float = 0.1  # spread of radius and place, share of pitch
    darkness: float = 0.85
    shift: tuple[float, float] = (0.0, 0.0)  # of the print against the gel's middle, pitches
    turn: float = 0.0  # of the print, rad


@dataclass(frozen=True, slots=True, kw_only=True)
class Gel:
    """Mechanics of a gel."""

    field: float  # mm across the square image, or the markers
    depth: tuple[float, float]  # press depth, mm
    skin: float  # mm: the gel's coat smooths narrower relief
    give: float  # mm: reach of the gel's deformation around a contact
    dome: float  # mm: height of the gel's middle over its rim


@dataclass(frozen=True, slots=True, kw_only=True)
class Sensor(Gel):
    """A gel that a camera sees (`tactile.py`)."""

    base: Colour  # mean colour of the untouched gel
    lamps: tuple[Lamp, ...]
    gain: float = 1.0  # strength of the colour of slopes
    markers: Markers | None = None
    plain_gels: float = 0.0  # share of its gels that have no markers
    vignette: float = 0.15
    noise: float = 0.012
    blur: float = 0.0  # pixels of 224


@dataclass(frozen=True, slots=True, kw_only=True)
class TaximSensor:
    """A sensor that the package taxim draws with one of its calibrations."""

    calibration: str  # name in taxim


@dataclass(frozen=True, slots=True, kw_only=True)
class Tac3DSensor(Gel):
    """A grid of displacements, drawn as colours (`contact.displacements`)."""


SensorModel = Sensor | TaximSensor | Tac3DSensor
GELS = {
    "GelSight": Sensor(
        field=16.0, depth=(0.7, 1.4), skin=0.06, give=0.9, dome=0.35, base=(0.60, 0.55, 0.62),
        lamps=(
            Lamp(-5, (0.75, 0.02, 0.12), 0.62),
            Lamp(120, (0.03, 0.70, 0.25), 0.55),
            Lamp(235, (0.10, 0.12, 0.80), 0.55),
        ),
        gain=1.6, markers=Markers(pitch=2.0, radius=0.28, uneven=0.06), vignette=0.20, noise=0.02,
    ),
    "GelSlim": Sensor(
        field=18.0, depth=(0.7, 1.3), skin=0.09, give=0.7, dome=0.12, base=(0.46, 0.42, 0.52),
        lamps=(
            Lamp(75, (0.55, 0.10, 0.30), 0.30),
            Lamp(195, (0.06, 0.50, 0.18), 0.30),
            Lamp(315, (0.10, 0.16, 0.52), 0.25),
        ),
        gain=1.5, markers=Markers(pitch=1.5, radius=0.17, uneven=0.04, darkness=0.6),
        plain_gels=0.4, vignette=0.30, noise=0.015, blur=0.6,
    ),
    "DIGIT": Sensor(
        field=15.0, depth=(0.7, 1.4), skin=0.08, give=1.2, dome=0.55, base=(0.44, 0.50, 0.58),
        lamps=(
            Lamp(90, (0.55, 0.10, 0.05), 0.55),
            Lamp(210, (0.05, 0.50, 0.14), 0.50),
            Lamp(330, (0.06, 0.14, 0.62), 0.60),
        ),
        gain=1.5, vignette=0.05, noise=0.018, blur=0.8,
    ),
    "GelSight Mini": Sensor(
        field=15.5, depth=(0.65, 1.3), skin=0.06, give=0.6, dome=0.25, base=(0.52, 0.47, 0.40),
        lamps=(
            Lamp(180, (0.50, 0.22, 0.05), 0.20),
            Lamp(60, (0.12, 0.48, 0.10), 0.35),
            Lamp(300, (0.30, 0.06, 0.55), 0.25),
        ),
        gain=1.5, vignette=0.45, noise=0.010,
    ),
    "DuraGel": Sensor(
        field=17.0, depth=(0.7, 1.3), skin=0.09, give=1.0, dome=0.20, base=(0.58, 0.60, 0.60),
        lamps=(
            Lamp(0, (0.12, 0.40, 0.20), 0.30),
            Lamp(120, (0.14, 0.22, 0.50), 0.25),
            Lamp(240, (0.50, 0.20, 0.14), 0.30),
        ),
        gain=1.6, markers=Markers(pitch=3.0, radius=0.36, uneven=0.02, darkness=0.5),
        plain_gels=0.5, vignette=0.15, noise=0.014, blur=0.5,
    ),
}  # fmt: skip
SENSORS: dict[str, SensorModel] = {
    **GELS,
    "Taxim GelSight": TaximSensor(calibration="CALIB_GELSIGHT"),
    "Taxim GelSight Mini": TaximSensor(calibration="CALIB_GELSIGHT_MINI"),
    "Tac3D": Tac3DSensor(field=16.0, depth=(0.4, 0.85), skin=0.22, give=0.8, dome=0.25),
}
