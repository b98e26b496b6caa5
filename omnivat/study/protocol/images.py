"""The images behind embeddings, for methods that learn inside the image tower.

A set of embeddings stores image names relative to a folder, so that it can be moved. `omnivat
embed` stores that folder in this machine's cache; `--images` sets another.
"""

from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import torch
from PIL import Image
from torch import Tensor

from omnivat.data.images import central_square, read_image
from omnivat.data.store import Embeddings
from omnivat.encoders.clip_live import load_live
from omnivat.encoders.hub import images_key, recall
from omnivat.kit.errors import DataError
from omnivat.study.baselines.contract import Fitted, Live

TOGETHER = 32  # pairs with images in memory at once
MOST = 0.02  # largest relative difference of a recomputed embedding (bf16: 0.011)


def live_of(pairs: Embeddings) -> Live:
    """Return the images of pairs, and a loader of their CLIP.

    Raises DataError if the image folder is unknown on this machine.
    """
    root = recall(images_key(pairs.header))
    if root is None:
        raise DataError("Pass the folder or table of pairs that was embedded as --images PAIRS.")
    header = pairs.header
    return Live(
        read=partial(_read, pairs, root),
        load=partial(load_live, header.encoder, header.weights_hash),
        rows=torch.arange(len(pairs)),
    )


def _read(pairs: Embeddings, root: Path, name: str, row: int) -> Image.Image:
    crop = pairs.rows.get("tac_crop", [""] * len(pairs))[row] if name == "tac" else ""
    return central_square(read_image(root / pairs.rows[name][row]), int(crop or 0))


def require_own_images(pairs: Embeddings) -> None:
    """Check that the images belong to the embeddings, on the first pair.

    Raises DataError for missing or different images.
    """
    if not len(pairs):
        return
    live = live_of(pairs)
    clip = live.load()
    for name, rows in (("vis", pairs.vis), ("tac", pairs.tac)):
        with torch.no_grad():
            found = clip.embed(live.images(name, torch.tensor([0])).to(clip.device)).cpu()
        wanted = tensor(rows[:1])
        away = float((found - wanted).norm() / wanted.norm())
        if not away <= MOST:
            raise DataError(
                f"The image '{pairs.rows[name][0]}' and its embedding do not belong together (made"
                f" again, it lies {away:.0%} away): another image is there now. Methods that learn"
                " inside CLIP predict images as they were embedded."
            )


def inputs(fitted: Fitted, pairs: Embeddings) -> Iterator[tuple[Tensor, Tensor]]:
    """Yield a method's input: all embeddings, or images, some at a time."""
    if not fitted.images:
        yield tensor(pairs.vis), tensor(pairs.tac)
        return
    live = live_of(pairs)
    for rows in torch.arange(len(pairs)).split(TOGETHER):
        yield live.images("vis", rows), live.images("tac", rows)


def tensor(array: Any) -> Tensor:
    """Return a float32 copy as a tensor."""
    return torch.from_numpy(np.array(array, dtype=np.float32))
