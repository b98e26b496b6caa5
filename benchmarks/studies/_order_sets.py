"""Sets of signals for the study of the order: chirps, channels of embeddings, rows of pictures."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from omnivat.data.store import Embeddings, load_embeddings
from omnivat.maps.thumbnails import sheet_of

WIDTH = 64


def permuted(embeddings: Embeddings, seed: int = 0) -> Embeddings:
    """Return the set with its channels in another order, the same for every pair and modality."""
    order = np.random.default_rng(seed).permutation(embeddings.width)
    return _with(embeddings, embeddings.vis[:, order], embeddings.tac[:, order])


def some_channels(embeddings: Embeddings, seed: int = 0) -> Embeddings:
    """Return 64 random channels of the set, in their original order."""
    chosen = np.random.default_rng(seed).permutation(embeddings.width)[:WIDTH]
    chosen.sort()
    return _with(embeddings, embeddings.vis[:, chosen], embeddings.tac[:, chosen])


def picture_rows(file: Path) -> Embeddings:
    """Return the middle rows of the set's thumbnails as signals of 64 samples.

    The middle eight rows of each picture are converted to grey, averaged, resampled to 64 samples
    and centred. VIS is the photo's row, TAC that of the tactile image.
    """
    embeddings = load_embeddings(file)
    signals = np.stack([_row(tile) for tile in pictures(file)]).astype(np.float32)
    return _with(embeddings, signals[: len(embeddings)], signals[len(embeddings) :])


def pictures(file: Path) -> list[Image.Image]:
    """Return the set's 2N thumbnails: photos, then tactile images."""
    sheet = Image.open(sheet_of(file)).convert("RGB")
    layout = json.loads(sheet_of(file).with_suffix(".json").read_text(encoding="utf-8"))
    tile, columns = layout["tile"], layout["columns"]
    corners = ((tile * (place % columns), tile * (place // columns)) for place in range(2 * len(load_embeddings(file))))
    return [sheet.crop((x, y, x + tile, y + tile)) for x, y in corners]


def _row(tile: Image.Image) -> NDArray[np.float32]:
    middle = tile.height // 2
    strip = tile.convert("L").crop((0, middle - 4, tile.width, middle + 4)).convert("F")
    row = np.asarray(strip.resize((WIDTH, 1), Image.Resampling.BOX), dtype=np.float32)[0]
    signal: NDArray[np.float32] = row - row.mean() + np.float32(1e-3)  # never of length zero
    return signal


def _with(embeddings: Embeddings, vis: NDArray[np.float32], tac: NDArray[np.float32]) -> Embeddings:
    return replace(embeddings, vis=vis, tac=tac, vis_flip=None, tac_flip=None)
