"""Draw a Tac3D displacement field as an RGB image. The paper's method is unknown; this one is ours.

The sensor tracks 20 x 20 markers in its skin. Displacements along x, y and z become red, green and
blue; no displacement is mid-grey. A data set has one scale for tangential and one for normal
displacement, because markers are pressed in several times as far as they are dragged.
"""

from collections.abc import Iterable, Iterator, Sequence
from hashlib import blake2b
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from omnivat.kit.files import replacing

MARKERS = 20  # markers on each side
SIDE = 224  # pixels of the image drawn
ROBUST = 99  # percent of the displacements within the scale
MOST_FOR_SCALE = 2000  # fields used for the scale, evenly spaced
Field = NDArray[np.float64]


def load_field(file: Path) -> Field | None:
    """Return the displacements (20, 20, 3) of a `.npy` file with that shape or (400, 3).

    None for anything else: another shape, text, objects, NaN.
    """
    try:
        with file.open("rb") as handle:
            field = np.asarray(np.load(handle, allow_pickle=False), np.float64)
        whole = field.reshape(MARKERS, MARKERS, 3)
    except Exception:  # a damaged file may raise any error
        return None
    shaped = field.shape in (whole.shape, (MARKERS**2, 3))
    return whole if shaped and np.isfinite(field).all() else None


def robust_scale(fields: Iterable[Field]) -> Field:
    """Return the 99 % quantiles (3,) of the displacements along x, y, z; 1 for none.

    x and y share one scale, so that the hue of a drag shows its direction.
    """
    seen = list(fields)
    if not seen:
        return np.ones(3)
    sizes = np.abs(np.stack(seen))
    skin, normal = (float(np.percentile(part, ROBUST)) for part in (sizes[..., :2], sizes[..., 2]))
    return np.array([skin or 1.0, skin or 1.0, normal or 1.0])


def field_to_rgb(field: Field, scale: Field, *, side: int = SIDE) -> NDArray[np.uint8]:
    """Return an image (side, side, 3) of a displacement field.

    field  (20, 20, 3) displacements along x, y, z
    scale  (3,) > 0, the displacements drawn as full colour; larger ones are clipped
    """
    colours = (np.clip(field / scale, -1, 1) * 127.5 + 127.5).astype(np.float32)
    axes = [
        Image.fromarray(colours[..., k]).resize((side, side), Image.Resampling.BICUBIC)
        for k in range(3)
    ]
    return np.clip(np.round(np.stack(list(map(np.asarray, axes)), axis=-1)), 0, 255).astype(
        np.uint8
    )


def draw_all(files: Sequence[Path], folder: Path) -> dict[Path, Path]:
    """Draw every field on one scale into `folder`; existing images are kept.

    files   `.npy` files of one data set
    folder  of the images, each named by a hash of its content
    return  the image of each field; files that hold none have none
    """
    drawn: dict[Path, Path] = {}
    some = files[:: -(-len(files) // MOST_FOR_SCALE) or 1]
    scale = robust_scale(field for _, field in _fields(some))
    for file, field in _fields(files):
        content = blake2b(field.tobytes() + scale.tobytes(), digest_size=12).hexdigest()
        drawn[file] = folder / f"tac3d-{content}.png"
        if not drawn[file].is_file():
            with replacing(drawn[file]) as temporary:
                Image.fromarray(field_to_rgb(field, scale)).save(temporary, format="PNG")
    return drawn


def _fields(files: Sequence[Path]) -> Iterator[tuple[Path, Field]]:
    for file in files:
        if (field := load_field(file)) is not None:
            yield file, field
