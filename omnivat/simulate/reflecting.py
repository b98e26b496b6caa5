"""An object for Mitsuba: mesh, texture and BSDF."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from omnivat.simulate.noise import Array
from omnivat.simulate.shapes import Solid
from omnivat.simulate.texture import Texture
from omnivat.simulate.things import Thing


def mesh(mi: Any, solid: Solid, uv: Array, material: dict[str, Any]) -> Any:
    """Return a solid as a Mitsuba mesh with its own normals; `uv` (V, 2) are texture coordinates."""
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


def material(mi: Any, thing: Thing, texture: Texture) -> dict[str, Any]:
    """Return the BSDF; skin and unresolved relief widen its highlight."""
    sight = thing.sight
    along, across = (
        float(np.clip(np.hypot(sight.roughness, slope), 0.015, 0.6)) for slope in texture.slopes
    )
    if sight.gloss == "glass":
        alpha = (along + across) / 2
        kind = {"type": "dielectric"} if alpha < 0.03 else {
            "type": "roughdielectric", "alpha": alpha}  # fmt: skip
        clear = bitmap(mi, np.sqrt(texture.colour))  # two walls, two faces each
        return kind | {"int_ior": 1.5, "specular_transmittance": clear}
    colour = bitmap(mi, texture.colour)
    skin: dict[str, Any]
    if sight.gloss == "matte":
        skin = {"type": "diffuse", "reflectance": colour}
    elif sight.gloss == "metal":
        skin = {
            "type": "roughconductor", "material": "none", "distribution": "ggx",
            "alpha_u": along * (1 - 0.6 * sight.brushing), "alpha_v": across,
            "specular_reflectance": colour,
        }  # fmt: skip
    else:
        skin = {
            "type": "roughplastic", "distribution": "ggx", "alpha": (along + across) / 2,
            "int_ior": 1.5, "diffuse_reflectance": colour, "nonlinear": True,
        }  # fmt: skip
    bumps = bitmap(mi, texture.bumps[..., None])
    return {"type": "twosided", "bsdf": {"type": "bumpmap", "bumps": bumps, "bsdf": skin}}


def bitmap(mi: Any, pixels: NDArray[np.floating[Any]]) -> dict[str, Any]:
    """Return a picture (H, W, C) of linear values as a Mitsuba texture."""
    return {
        "type": "bitmap", "bitmap": mi.Bitmap(np.ascontiguousarray(pixels, dtype=np.float32)),
        "raw": True, "wrap_mode": "mirror",
    }  # fmt: skip
