"""Inputs of methods that learn inside the image tower: images instead of embeddings."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import torch
from PIL import Image
from torch import Tensor

from omnivat.encoders.running import pixels
from omnivat.errors import DataError

if TYPE_CHECKING:
    from omnivat.baselines.contract import Source
    from omnivat.encoders.clip_live import LiveClip


@dataclass(frozen=True, slots=True, kw_only=True)
class ImageInput:
    """Image preprocessing: resize to `side` pixels, scale to 0..1, then (x - mean) / std."""

    side: int
    mean: tuple[float, ...]
    std: tuple[float, ...]

    def __call__(self, image: Image.Image) -> Tensor:
        """Return the image as (3, side, side)."""
        return pixels(image, self.mean, self.std, self.side)


@dataclass(frozen=True, slots=True, kw_only=True)
class Live:
    """The images of a source's embeddings, and the CLIP that made them.

    read    ("vis" or "tac", row among all pairs) -> an RGB image
    load    returns the live towers; they are frozen and shared, and no method changes them
    rows    (N,) indices of these pairs among all pairs
    """

    read: Callable[[str, int], Image.Image]
    load: "Callable[[], LiveClip]"
    rows: Tensor

    def select(self, rows: Tensor) -> "Live":
        """Return the pairs with these indices (n,)."""
        return replace(self, rows=self.rows[rows])

    def images(self, name: str, rows: Tensor, given: ImageInput) -> Tensor:
        """Return the "vis" or "tac" images (B, 3, side, side) of the pairs `rows` (B,)."""
        return torch.stack([given(self.read(name, int(row))) for row in self.rows[rows]])

    def drawn(self, rows: Tensor, given: ImageInput) -> Tensor:
        """Return VIS, then TAC of the pairs (2 B, 3, side, side), each mirrored at random."""
        found = torch.cat([self.images(name, rows, given) for name in ("vis", "tac")])
        mirror = torch.rand(len(found), 1, 1, 1) < 0.5
        return torch.where(mirror, found.flip(-1), found)


def live_towers(source: "Source", what: str) -> "tuple[Live, LiveClip, ImageInput]":
    """Return a source's images, live towers and preprocessing. Raises DataError without them."""
    if source.live is None:
        raise DataError(
            f"{what} learns inside CLIP and needs the images and the checkpoint behind these embeddings, "
            f"which are not at hand. {source.why_not_live}".strip()
        )
    clip = source.live.load()
    return source.live, clip, ImageInput(side=clip.side, mean=clip.mean, std=clip.std)
