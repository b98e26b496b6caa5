"""One row for each domain: camera, light, table and camera faults of its photographs.

The eight rows follow how each data set was collected: outdoors by hand (Touch-and-Go), from the
gripper (OF Real), rendered on a plain ground (OF 2.0), on a bench with each sensor (TacQuad).
"""

from dataclasses import dataclass

Colour = tuple[float, float, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class Scene:
    """How a domain's camera sees an object. Pairs in brackets are ranges."""

    view: tuple[float, float]  # mm across the image at the object
    extent: tuple[float, float]  # object's width, as a share of the view; above 1 fills it
    tilt: tuple[float, float]  # degrees between the line of sight and the surface's normal
    ground: tuple[str, ...]  # what lies behind
    sun: Colour  # key light, radiance
    sky: Colour  # light from everywhere
    height: tuple[float, float]  # degrees of the key light over the surface
    softness: float  # size of the key light: 0.05 a bulb, 0.6 a window or a light box
    noise: float
    blur: float = 0.0  # pixels of 224
    balance: Colour = (1.0, 1.0, 1.0)  # the camera's error of white
    contrast: float = 1.0
    prop: str = ""  # what holds the sensor: "hand", "clamp" or nothing in view


SCENES = {
    "TAG": Scene(
        view=(60, 100), extent=(0.9, 1.5), tilt=(15, 50), ground=("grass", "paving"),
        sun=(3.0, 2.8, 2.4), sky=(0.55, 0.65, 0.85), height=(30, 65), softness=0.12,
        noise=0.008, blur=0.5, prop="hand",
    ),
    "OF Real": Scene(
        view=(55, 80), extent=(1.0, 1.6), tilt=(25, 45), ground=("cloth",),
        sun=(1.8, 1.75, 1.7), sky=(0.45, 0.45, 0.48), height=(45, 75), softness=0.55,
        noise=0.016, blur=0.9, balance=(0.92, 1.0, 1.06), contrast=0.9, prop="clamp",
    ),
    "OF 2.0 A": Scene(
        view=(60, 90), extent=(0.75, 0.95), tilt=(0, 40), ground=("white",),
        sun=(2.0, 2.0, 2.0), sky=(0.7, 0.7, 0.7), height=(40, 80), softness=0.2, noise=0.0,
    ),
    "OF 2.0 B": Scene(
        view=(50, 80), extent=(0.75, 0.95), tilt=(0, 45), ground=("black",),
        sun=(2.6, 2.6, 2.6), sky=(0.35, 0.35, 0.35), height=(35, 80), softness=0.1, noise=0.0,
        contrast=1.1,
    ),
    "TQ-DIGIT": Scene(
        view=(45, 70), extent=(1.0, 1.6), tilt=(20, 40), ground=("desk",),
        sun=(2.0, 1.8, 1.45), sky=(0.5, 0.47, 0.42), height=(35, 65), softness=0.35,
        noise=0.012, blur=0.6, balance=(1.06, 1.0, 0.88), prop="clamp",
    ),
    "TQ-GelMini": Scene(
        view=(50, 75), extent=(0.9, 1.5), tilt=(10, 30), ground=("desk",),
        sun=(2.2, 2.2, 2.2), sky=(0.55, 0.57, 0.6), height=(40, 70), softness=0.3,
        noise=0.008, blur=0.4, contrast=1.1, prop="clamp",
    ),
    "TQ-DuraGel": Scene(
        view=(55, 80), extent=(0.9, 1.4), tilt=(25, 50), ground=("cloth",),
        sun=(1.7, 1.8, 2.0), sky=(0.42, 0.46, 0.52), height=(30, 60), softness=0.4,
        noise=0.014, blur=0.7, balance=(0.9, 1.0, 1.12), contrast=0.85, prop="clamp",
    ),
    "TQ-T3D": Scene(
        view=(55, 85), extent=(0.9, 1.4), tilt=(30, 50), ground=("bench",),
        sun=(2.4, 2.2, 1.9), sky=(0.4, 0.4, 0.4), height=(35, 60), softness=0.15,
        noise=0.012, blur=0.5, balance=(1.02, 1.0, 0.95), prop="clamp",
    ),
}  # fmt: skip
