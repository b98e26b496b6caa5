"""Small pairs of images on disk, and a quick encoder for them."""

from io import BytesIO

import numpy as np
import torch
from PIL import Image

from omnivat.data.pairs import Pair, PairSet
from omnivat.encoders.embed import embed_pairs


class MeanColour:
    """A quick encoder: the mean colour of each half of the image."""

    name, width = "efficientnet-lite0", 6
    preprocessing, precision, weights_hash = "none", "fp32", "0"

    def preprocess(self, image):
        return torch.from_numpy(np.array(image)).permute(2, 0, 1).float()

    def embed(self, images):
        half = images.shape[-1] // 2
        halves = (images[..., :half], images[..., half:])
        return torch.cat([part.mean(dim=(2, 3)) for part in halves], dim=1)


def load_mean(**_):
    return MeanColour()


def png(seed=0, size=(20, 16)):
    pixels = np.random.default_rng(seed).integers(0, 256, (*size[::-1], 3), dtype=np.uint8)
    buffer = BytesIO()
    Image.fromarray(pixels).save(buffer, "PNG")
    return buffer.getvalue()


def make_pairs(root, count=10, bad=()):
    """Write `count` pairs; the TAC images numbered in `bad` are no images."""
    pairs = []
    for i in range(count):
        domain, material = ("TAG", "OF Real")[i % 2], ("glass", "wood", "cork")[i % 3]
        folder = root / domain / material
        folder.mkdir(parents=True, exist_ok=True)
        vis, tac = folder / f"{i}_vis.png", folder / f"{i}_tac.png"
        vis.write_bytes(png(2 * i))
        tac.write_bytes(b"no image" if i in bad else png(2 * i + 1))
        pairs.append(
            Pair(vis=vis, tac=tac, domain=domain, material=material, object=f"o{i}", split="train")
        )
    return PairSet(pairs=tuple(pairs), origin="made by a test")


def embed(pairs, out, **settings):
    return embed_pairs(pairs, "efficientnet-lite0", out, **settings)
