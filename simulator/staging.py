"""What Mitsuba renders: surfaces as textures and materials, the ground, other things."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from simulator.grounds import ground
from simulator.noise import Array, turned
from simulator.photograph import Framing
from simulator.props import others
from simulator.renderer import mitsuba
from simulator.shapes import Solid
from simulator.surfaces import Surface
from simulator.things import Thing

_TEXELS = 28_000
_FINER = 2  # samples along each side of a texel
_MARGIN = 1.3  # of the view, around the contact; parts farther away are not in the picture


@dataclass(frozen=True, slots=True, kw_only=True)
class Texture:
    """Pictures on the solid's uv; the first row is the smallest v.

    uv         (V, 2) of each vertex, 0 to 1 over the pictures
    colour     (H, W, 3) linear
    bumps      (H, W) mm
    slopes     root-mean-square slopes along u and v, too fine for the pictures
    """

    uv: Array
    colour: Array
    bumps: Array
    slopes: tuple[float, float]


def textured(thing: Thing, framing: Framing) -> Texture:
    """Return the thing's appearance on its solid, at the resolution of a photograph."""
    uv = thing.solid.uv
    reach = _MARGIN * framing.view
    low = np.maximum(uv.min(0), thing.spot.uv - reach)
    high = np.maximum(np.minimum(uv.max(0), thing.spot.uv + reach), low + 1.0)
    step = float(np.sqrt(np.prod(high - low) / _TEXELS))
    columns, rows = (int(n) for n in np.maximum(np.ceil((high - low) / step), 2))
    fine = ((np.arange(_FINER * count) + 0.5) / (_FINER * count) for count in (columns, rows))
    u, v = np.meshgrid(*(at * (b - a) + a for at, a, b in zip(fine, low, high, strict=True)))
    shape = (rows, _FINER, columns, _FINER)
    return Texture(
        uv=(uv - low) / (high - low),
        colour=thing.sight.colour(u, v).reshape(*shape, 3).mean((1, 3)),
        bumps=thing.sight.relief(u, v).reshape(shape).mean((1, 3)),
        slopes=unresolved_slopes(thing.sight, thing.spot.uv, spacing=step),
    )


def unresolved_slopes(surface: Surface, at: Array, *, spacing: float) -> tuple[float, float]:
    """Return root-mean-square slopes along and across the axis that texels of `spacing` mm lose.

    They widen the highlight, as in nature: from a distance, a brushed sheet is a rough mirror.
    """
    axis = np.arange(-48, 48) * (spacing / 6)
    along, across = np.meshgrid(axis, axis)
    u, v = turned(along, across, -surface.angle)
    relief = surface.relief(u + at[0], v + at[1])
    fine = np.gradient(relief, spacing / 6)
    coarse = np.gradient(relief.reshape(16, 6, 16, 6).mean((1, 3)), spacing)
    lost = [max(float(f.var() - c.var()), 0.0) for f, c in zip(fine, coarse, strict=True)]
    return float(np.sqrt(lost[1])), float(np.sqrt(lost[0]))


def mesh(solid: Solid, uv: Array, material: dict[str, Any]) -> Any:
    """Return a solid as a Mitsuba mesh with its own normals; `uv` (V, 2) are texture
    coordinates.
    """
    mi = mitsuba()
    properties = mi.Properties()
    properties["bsdf"] = mi.load_dict(material)
    shape = mi.Mesh(
        "object", vertex_count=len(solid.vertices), face_count=len(solid.faces),
        has_vertex_normals=True, has_vertex_texcoords=True, props=properties,
    )  # fmt: skip
    values = mi.traverse(shape)
    values["vertex_positions"] = solid.vertices.astype(np.float32).ravel()
    values["vertex_texcoords"] = uv.astype(np.float32).ravel()
    values["faces"] = solid.faces.astype(np.uint32).ravel()
    values.update()
    values["vertex_normals"] = solid.normals().astype(np.float32).ravel()
    values.update()
    return shape


def material(thing: Thing, texture: Texture) -> dict[str, Any]:
    """Return the BSDF; skin and unresolved relief widen its highlight."""
    sight = thing.sight
    along, across = (
        float(np.clip(np.hypot(sight.roughness, slope), 0.015, 0.6)) for slope in texture.slopes
    )
    if sight.gloss == "glass":
        alpha = (along + across) / 2
        kind = (
            {"type": "dielectric"} if alpha < 0.03 else {"type": "roughdielectric", "alpha": alpha}
        )
        clear = bitmap(np.sqrt(texture.colour))  # two walls, two faces each
        return kind | {"int_ior": 1.5, "specular_transmittance": clear}
    colour = bitmap(texture.colour)
    skin: dict[str, Any] = {"type": "diffuse", "reflectance": colour}
    if sight.gloss == "metal":
        skin = {
            "type": "roughconductor",
            "material": "none",
            "distribution": "ggx",
            "specular_reflectance": colour,
            "alpha_u": along * (1 - 0.6 * sight.brushing),
            "alpha_v": across,
        }
    elif sight.gloss == "coated":
        skin = {
            "type": "roughplastic",
            "distribution": "ggx",
            "alpha": (along + across) / 2,
            "int_ior": 1.5,
            "diffuse_reflectance": colour,
            "nonlinear": True,
        }
    bumps = bitmap(texture.bumps[..., None])
    return {"type": "twosided", "bsdf": {"type": "bumpmap", "bumps": bumps, "bsdf": skin}}


def bitmap(pixels: NDArray[np.floating[Any]]) -> dict[str, Any]:
    """Return a picture (H, W, C) of linear values as a Mitsuba texture."""
    values = mitsuba().Bitmap(np.ascontiguousarray(pixels, dtype=np.float32))
    return {"type": "bitmap", "bitmap": values, "raw": True, "wrap_mode": "mirror"}


_PIXELS = 160  # of the grounds' pictures
_SIDE = 4.0  # of the ground, in widths of the view
_PLAIN = 40.0  # the same where nothing is seen beyond it
_TURNTABLE = (0.62, 1.1)  # radius, in extents of the object
_STEP_DOWN = 14.0  # mm from the turntable to the cloth


def place(thing: Thing, framing: Framing) -> dict[str, Any]:
    """Return the ground, the background, and the turntable if there is one."""
    clear = thing.sight.gloss == "glass"
    half = (_SIDE if framing.behind else _PLAIN) * max(framing.view, 300.0) / 2
    middle = np.array([framing.target[0], framing.target[1], -0.3])
    transform = mitsuba().ScalarTransform4f()
    shapes: dict[str, Any] = {}
    if framing.ground == "turntable":
        radius = np.random.default_rng(framing.seed + 3).uniform(*_TURNTABLE)
        radius *= _extent(thing)
        disc = {"type": "disk", "to_world": transform.translate([0, 0, -0.3]).scale(radius)}
        rim = {"type": "cylinder", "p0": [0, 0, -_STEP_DOWN], "p1": [0, 0, -0.3], "radius": radius}
        tone = np.full((2, 2, 3), 0.82)
        shapes["top"] = disc | _shown(tone, framing, clear)
        shapes["rim"] = rim | _shown(0.8 * tone, framing, clear)
        middle[2] = -_STEP_DOWN
    axis = np.linspace(-half, half, _PIXELS)
    x, y = np.meshgrid(axis, axis)
    flat = transform.translate(middle.tolist()).scale([half, half, 1])
    colour = ground(framing.ground, x, y, seed=framing.seed)
    shapes["ground"] = {"type": "rectangle", "to_world": flat} | _shown(colour, framing, clear)
    if framing.behind:
        shapes["behind"] = _backdrop(framing, clear)
    return shapes


def _backdrop(framing: Framing, clear: bool) -> dict[str, Any]:
    far = (framing.target - framing.eye) * [1.0, 1.0, 0.0]
    far = far / max(float(np.linalg.norm(far)), 1e-6)
    middle = framing.target * [1.0, 1.0, 0.0] + framing.away * far
    half = 1.6 * (framing.view + framing.away)
    axis = np.linspace(-half, half, _PIXELS)
    x, z = np.meshgrid(axis, axis + half)
    colour = ground(framing.behind, x, z, seed=framing.seed + 4)
    centre = middle + np.array([0.0, 0.0, half - 15.0])
    stand = (
        mitsuba()
        .ScalarTransform4f()
        .look_at(origin=centre.tolist(), target=(centre - far).tolist(), up=[0, 0, 1])
    )
    return {"type": "rectangle", "to_world": stand.scale([half, half, 1])} | _shown(
        colour, framing, clear
    )


def _shown(colour: Array, framing: Framing, clear: bool) -> dict[str, Any]:
    """Return the material of a ground; behind clear glass it emits light.

    Under glass, few paths reach the lamp.
    """
    if clear:
        lit = colour * (framing.sky + 0.35 * framing.sun) * 0.8
        glow = {"type": "area", "radiance": bitmap(lit)}
        return {"emitter": glow, "bsdf": {"type": "diffuse", "reflectance": 0.0}}
    plain = {"type": "diffuse", "reflectance": bitmap(colour)}
    return {"bsdf": {"type": "twosided", "bsdf": plain}}


def clutter(thing: Thing, framing: Framing) -> dict[str, Any]:
    """Return other things about the object."""
    return {
        f"other{index}": mesh(solid, np.zeros((len(solid.vertices), 2)), bsdf)
        for index, (solid, bsdf) in enumerate(others(framing, extent=_extent(thing)))
    }


def _extent(thing: Thing) -> float:
    """Return the diagonal of the ground that the object takes, mm."""
    return float(np.linalg.norm(np.ptp(thing.solid.vertices, axis=0)[:2]))
