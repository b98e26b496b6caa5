"""VIS by Mitsuba 3: the object in its place, the light, the camera."""

from functools import lru_cache
from typing import Any

import numpy as np
from scipy.ndimage import median_filter

from omnivat.packages import need
from omnivat.simulate.denoising import denoised
from omnivat.simulate.environment import panorama
from omnivat.simulate.framing import Framing
from omnivat.simulate.noise import Array
from omnivat.simulate.props import props
from omnivat.simulate.reflecting import material, mesh
from omnivat.simulate.staging import clutter, place
from omnivat.simulate.texture import textured
from omnivat.simulate.things import Thing

SAMPLES = 4  # paths for each pixel; their grain is filtered
SAMPLES_GLASS = 8
_GUIDES = 2  # rays for each pixel for its colour and normal


@lru_cache(maxsize=1)
def _mitsuba() -> Any:
    """Return Mitsuba in scalar mode: without a compiler, with identical images in every run."""
    mitsuba = need("mitsuba", purpose="rendering VIS images")
    mitsuba.set_variant("scalar_rgb")
    mitsuba.set_log_level(mitsuba.LogLevel.Error)
    return mitsuba


def rendered(thing: Thing, framing: Framing, *, size: int) -> Array:
    """Return linear radiance (size, size, 3) of the thing under the framing.

    Raises MissingPackageError without mitsuba.
    """
    mi = _mitsuba()
    texture = textured(thing, framing)
    clear = thing.sight.gloss == "glass"
    depth, samples = (9, SAMPLES_GLASS) if clear else (3, SAMPLES)
    scene = mi.load_dict(
        props(mi, framing)
        | place(mi, thing, framing)
        | clutter(mi, thing, framing)
        | {
            "type": "scene",
            "integrator": {"type": "path", "max_depth": depth, "rr_depth": 6},
            "sensor": _camera(mi, framing, size, samples),
            "light": _light(mi, framing, clear=clear),
            "object": mesh(mi, thing.solid, texture.uv, material(mi, thing, texture)),
        }
    )
    seed = framing.seed % 2**31
    image = mi.render(scene, spp=samples, seed=seed)
    radiance = np.clip(_pixels(image)[..., :3], 0.0, 5.0)
    if clear:  # each path is reflected or transmitted, so single pixels stand out
        radiance = np.asarray(median_filter(radiance, size=(3, 3, 1), mode="nearest"))
    guides = mi.load_dict({"type": "aov", "aovs": "colour:albedo,normal:sh_normal"})
    guide = _pixels(mi.render(scene, spp=_GUIDES, seed=seed, integrator=guides))
    return denoised(radiance, guide[..., :3], guide[..., 3:6])


def _pixels(image: Any) -> Array:
    """Return an image's values; a path through a degenerate triangle counts as dark."""
    return np.nan_to_num(np.asarray(image, dtype=np.float64), nan=0.0, posinf=5.0, neginf=0.0)


def _camera(mi: Any, framing: Framing, size: int, samples: int) -> dict[str, Any]:
    view = mi.ScalarTransform4f().look_at(
        origin=framing.eye.tolist(), target=framing.target.tolist(), up=[0, 0, 1]
    )
    return {
        "type": "perspective",
        "fov": float(np.rad2deg(framing.lens)),
        "to_world": view,
        "film": {
            "type": "hdrfilm", "width": size, "height": size, "pixel_format": "rgb",
            "rfilter": {"type": "box"},
        },
        "sampler": {"type": "independent", "sample_count": samples},
    }  # fmt: skip


def _light(mi: Any, framing: Framing, *, clear: bool) -> dict[str, Any]:
    # Light through clear glass is found by chance, so a small lamp would sparkle.
    sky = panorama(framing, least_softness=0.6 if clear else 0.0).astype(np.float32)
    upright = mi.ScalarTransform4f().rotate([1, 0, 0], 90)
    return {"type": "envmap", "bitmap": mi.Bitmap(sky), "to_world": upright}
