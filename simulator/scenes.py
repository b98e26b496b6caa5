"""One row for each scene: camera, light, place and camera errors of its photographs.

The eight rows follow how each data set was collected: by hand, indoors and outdoors (Touch-and-Go),
on a white turntable (OF Real), rendered on a plain ground (OF 2.0), at a desk with the sensor's rig
in view (TacQuad).
"""

from dataclasses import dataclass

from simulator.noise import Colour


@dataclass(frozen=True, slots=True, kw_only=True)
class Scene:
    """Camera settings of a scene. Pairs in brackets are ranges."""

    whole: bool  # True if the whole object is in the picture
    view: tuple[float, float]  # width of the picture: relative to the object, or mm if not whole
    rise: tuple[float, float]  # degrees of the camera over the horizon
    lens: float  # degrees of the field of view
    ground: tuple[str, ...]  # ground
    behind: tuple[str, ...]  # background
    sun: Colour  # key light, radiance
    sky: Colour  # light from everywhere
    height: tuple[float, float]  # degrees of the key light over the horizon
    softness: float  # size of the key light: 0.05 a bulb, 0.6 a window or a light box
    noise: float
    goal: float  # target brightness of the exposure
    blur: float = 0.0  # pixels of 224
    balance: Colour = (1.0, 1.0, 1.0)  # white balance error
    drift: float = 0.04  # variation of the white balance
    contrast: float = 1.0
    prop: str = ""  # holder of the sensor: "hand", "rig" or none
    seen: float = 0.0  # share of pictures with the sensor in view
    clutter: float = 0.0  # other things on the ground, on average
    parts: float = 0.0  # share of objects that are parts of rooms and buildings
    outdoors: float = 0.0  # share of outdoor pictures, in domains without series


SCENES = {
    "TAG": Scene(
        whole=False, view=(280, 650), rise=(15, 60), lens=62, ground=("carpet", "parquet", "stone"),
        behind=("shelf", "wall", "door"), sun=(3.0, 2.8, 2.4), sky=(0.55, 0.65, 0.85),
        height=(30, 65), softness=0.2, noise=0.008, goal=0.6, blur=0.5, drift=0.08, prop="hand",
        seen=0.55, clutter=0.5, parts=0.8, outdoors=0.55,
    ),
    "OF Real": Scene(
        whole=True, view=(1.15, 2.2), rise=(18, 50), lens=32, ground=("turntable",),
        behind=("turntable",), sun=(1.6, 1.6, 1.6), sky=(0.6, 0.62, 0.66), height=(50, 80),
        softness=0.5, noise=0.008, goal=0.85, blur=0.5, balance=(0.97, 1.0, 1.04), contrast=0.95,
    ),
    "OF 2.0 A": Scene(
        whole=True, view=(1.05, 1.5), rise=(28, 65), lens=40, ground=("white",), behind=(),
        sun=(2.0, 2.0, 2.0), sky=(0.7, 0.7, 0.7), height=(40, 80), softness=0.25, noise=0.0,
        goal=0.75, drift=0.0,
    ),
    "OF 2.0 B": Scene(
        whole=True, view=(1.05, 1.5), rise=(28, 65), lens=40, ground=("black",), behind=(),
        sun=(2.6, 2.6, 2.6), sky=(0.4, 0.4, 0.4), height=(35, 80), softness=0.12, noise=0.0,
        goal=0.5, drift=0.0, contrast=1.1,
    ),
    "TQ-DIGIT": Scene(
        whole=False, view=(150, 300), rise=(20, 50), lens=50, ground=("oak",),
        behind=("wall", "shelf"), sun=(2.0, 1.75, 1.35), sky=(0.5, 0.46, 0.4), height=(35, 65),
        softness=0.35, noise=0.012, goal=0.5, blur=0.6, balance=(1.08, 1.0, 0.84), prop="rig",
        seen=0.7, clutter=0.8, parts=0.15,
    ),
    "TQ-GelMini": Scene(
        whole=False, view=(170, 340), rise=(30, 65), lens=50, ground=("laminate",),
        behind=("wall", "door"), sun=(2.2, 2.2, 2.2), sky=(0.6, 0.63, 0.68), height=(45, 75),
        softness=0.4, noise=0.008, goal=0.65, blur=0.4, contrast=1.08, prop="rig", seen=0.7,
        clutter=0.8, parts=0.15,
    ),
    "TQ-DuraGel": Scene(
        whole=False, view=(160, 320), rise=(20, 45), lens=58, ground=("cloth",),
        behind=("shelf", "wall"), sun=(1.6, 1.75, 2.0), sky=(0.4, 0.45, 0.54), height=(30, 60),
        softness=0.45, noise=0.014, goal=0.45, blur=0.8, balance=(0.88, 1.0, 1.14), contrast=0.88,
        prop="rig", seen=0.7, clutter=0.8, parts=0.15,
    ),
    "TQ-T3D": Scene(
        whole=False, view=(170, 330), rise=(25, 55), lens=46, ground=("bench",), behind=("wall",),
        sun=(2.4, 2.2, 1.9), sky=(0.42, 0.42, 0.42), height=(35, 60), softness=0.18, noise=0.012,
        goal=0.45, blur=0.5, balance=(1.02, 1.0, 0.95), prop="rig", seen=0.8, clutter=0.5,
        parts=0.1,
    ),
}  # fmt: skip
OUTDOORS = (("grass", "paving", "gravel", "soil"), ("foliage", "foliage", "street"))
