"""VIS by Mitsuba 3: the surface as a displaced mesh, its material, the light, the camera."""

from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter, median_filter

from omnivat.packages import need
from omnivat.simulate.environment import panorama
from omnivat.simulate.framing import Framing
from omnivat.simulate.grounds import ground
from omnivat.simulate.mesh import Mesh, colours, object_mesh, unresolved_slopes
from omnivat.simulate.noise import Array
from omnivat.simulate.props import props
from omnivat.simulate.surfaces import Surface

SAMPLES = 4  # paths a pixel: what grain is left passes for a camera's
SAMPLES_GLASS = 16
_FIELD_OF_VIEW = 32.0  # degrees
_GROUND_PIXELS = 320
_GROUND_VIEWS = 3.0  # side of the ground, in widths of the view


@lru_cache(maxsize=1)
def _mitsuba() -> Any:
    """Return Mitsuba in its scalar mode: no compiler needed, the same image on every run."""
    mitsuba = need("mitsuba", purpose="rendering VIS images")
    mitsuba.set_variant("scalar_rgb")
    mitsuba.set_log_level(mitsuba.LogLevel.Error)
    return mitsuba


def rendered(surface: Surface, framing: Framing, *, size: int) -> Array:
    """Return linear radiance (size, size, 3) of the surface under the framing.

    Raises MissingPackageError without mitsuba.
    """
    mi = _mitsuba()
    mesh = object_mesh(surface, framing)
    clear = surface.gloss == "glass"
    depth, samples = (8, SAMPLES_GLASS) if clear else (3, SAMPLES)
    scene = mi.load_dict(
        props(mi, framing)
        | {
            "type": "scene",
            "integrator": {"type": "path", "max_depth": depth, "rr_depth": 5},
            "sensor": _camera(mi, framing, size, samples),
            "light": _light(mi, surface, framing),
            "ground": _ground(mi, surface, framing, mesh.ground),
            "object": _object(mi, mesh, _material(mi, surface, framing)),
        }
    )
    image = mi.render(scene, spp=samples, seed=framing.seed % 2**31)
    radiance = np.clip(np.asarray(image, dtype=np.float64)[..., :3], 0.0, 5.0)
    if clear:  # each path is mirrored or let through: single pixels stand out
        radiance = np.asarray(median_filter(radiance, size=(3, 3, 1), mode="nearest"))
    return np.asarray(gaussian_filter(radiance, (0.5, 0.5, 0.0), mode="nearest"))


def _camera(mi: Any, framing: Framing, size: int, samples: int) -> dict[str, Any]:
    distance = framing.view / 2 / np.tan(np.deg2rad(_FIELD_OF_VIEW / 2))
    sin, cos = np.sin(framing.tilt), np.cos(framing.tilt)
    back = np.array([np.cos(framing.turn), np.sin(framing.turn), 0.0])
    side = np.array([-back[1], back[0], 0.0])
    target = framing.off[0] * side + framing.off[1] * back
    origin = target + distance * (sin * back + cos * np.array([0.0, 0.0, 1.0]))
    up = cos * -back + sin * np.array([0.0, 0.0, 1.0])
    view = mi.ScalarTransform4f().look_at(
        origin=origin.tolist(), target=target.tolist(), up=up.tolist()
    )
    return {
        "type": "perspective",
        "fov": _FIELD_OF_VIEW,
        "to_world": view,
        "film": {
            "type": "hdrfilm", "width": size, "height": size, "pixel_format": "rgb",
            "rfilter": {"type": "gaussian"},
        },
        "sampler": {"type": "independent", "sample_count": samples},
    }  # fmt: skip


def _light(mi: Any, surface: Surface, framing: Framing) -> dict[str, Any]:
    # Light that reaches the eye through clear glass is found by chance: a small lamp would sparkle.
    least = 0.6 if surface.gloss == "glass" else 0.0
    sky = panorama(framing, least_softness=least).astype(np.float32)
    upright = mi.ScalarTransform4f().rotate([1, 0, 0], 90)
    return {"type": "envmap", "bitmap": mi.Bitmap(sky), "to_world": upright}


def _ground(mi: Any, surface: Surface, framing: Framing, z: float) -> dict[str, Any]:
    half = _GROUND_VIEWS * framing.view / 2
    axis = np.linspace(-half, half, _GROUND_PIXELS)
    x, y = np.meshgrid(axis, axis)
    colour = ground(framing.ground, x, y, seed=framing.seed).astype(np.float32)
    place = mi.ScalarTransform4f().translate([0, 0, z]).scale([half, half, 1])
    plane = {"type": "rectangle", "to_world": place}
    if surface.gloss == "glass":
        # Its own evenly lit radiance: under glass, light from the lamp is found too seldom.
        lit = colour * (np.asarray(framing.sky) + 0.35 * np.asarray(framing.sun)) * 0.8
        glow = {"type": "area", "radiance": _bitmap(mi, lit)}
        return plane | {"emitter": glow, "bsdf": {"type": "diffuse", "reflectance": 0.0}}
    return plane | {"bsdf": {"type": "diffuse", "reflectance": _bitmap(mi, colour)}}


def _bitmap(mi: Any, pixels: NDArray[np.floating[Any]]) -> dict[str, Any]:
    return {
        "type": "bitmap", "bitmap": mi.Bitmap(np.ascontiguousarray(pixels, dtype=np.float32)),
        "raw": True, "wrap_mode": "clamp",
    }  # fmt: skip


def _material(mi: Any, surface: Surface, framing: Framing) -> dict[str, Any]:
    """Return the BSDF: its highlight is as wide as the skin and the unresolved relief make it."""
    colour = _bitmap(mi, colours(surface, framing))
    along, across = (
        float(np.clip(np.hypot(surface.roughness, slope), 0.015, 0.6))
        for slope in unresolved_slopes(surface, framing)
    )
    if surface.gloss == "matte":
        return {"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": colour}}
    if surface.gloss == "metal":
        metal = {
            "type": "roughconductor", "material": "none", "distribution": "ggx",
            "alpha_u": along * (1 - 0.6 * surface.brushing), "alpha_v": across,
            "specular_reflectance": colour,
        }  # fmt: skip
        return {"type": "twosided", "bsdf": metal}
    alpha = (along + across) / 2
    if surface.gloss == "coated":
        coat = {
            "type": "roughplastic", "distribution": "ggx", "alpha": alpha, "int_ior": 1.5,
            "diffuse_reflectance": colour, "nonlinear": True,
        }  # fmt: skip
        return {"type": "twosided", "bsdf": coat}
    kind = {"type": "dielectric"} if alpha < 0.03 else {"type": "roughdielectric", "alpha": alpha}
    return kind | {"int_ior": 1.5, "specular_transmittance": colour}


def _object(mi: Any, mesh: Mesh, material: dict[str, Any]) -> Any:
    properties = mi.Properties()
    properties["bsdf"] = mi.load_dict(material)
    shape = mi.Mesh(
        "object", vertex_count=len(mesh.vertices), face_count=len(mesh.faces),
        has_vertex_normals=True, has_vertex_texcoords=True, props=properties,
    )  # fmt: skip
    values = mi.traverse(shape)
    values["vertex_positions"] = mesh.vertices.astype(np.float32).ravel()
    values["vertex_texcoords"] = mesh.texture.astype(np.float32).ravel()
    values["faces"] = mesh.faces.ravel()
    values.update()
    return shape
