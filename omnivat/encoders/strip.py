"""An encoder without weights that reads the signal of a picture of stripes."""

from pathlib import Path

import torch
from PIL import Image
from torch import nn

from omnivat.data.strips import ENCODER, MIDDLE, PREPROCESSING, READER, STRIPES, SWING, strip_signal
from omnivat.encoders.onnx_runtime import translate
from omnivat.kit.files import replacing
from omnivat.kit.shapes import require_shapes


class StripReader:
    """Reads 64 numbers from a picture of vertical stripes; see `omnivat.data.strips`."""

    name, width, precision = ENCODER, STRIPES, "fp32"
    preprocessing, weights_hash = PREPROCESSING, READER

    def preprocess(self, image: Image.Image) -> torch.Tensor:
        """Return the signal of an image as (3, 1, 64) float32, the same in each channel."""
        return torch.from_numpy(strip_signal(image)).expand(3, 1, STRIPES).clone()

    def embed(self, images: torch.Tensor) -> torch.Tensor:
        """Return the signals (B, 64) of preprocessed images (B, 3, 1, 64)."""
        require_shapes(images=(images, "B C H W"))
        return images.mean(dim=(1, 2))

    def write_onnx(self, file: Path) -> None:
        """Write the reader as ONNX: a picture (1, H, W, 3) uint8 of any size -> (1, 64).

        Raises MissingPackageError if a package of ONNX is not installed.
        """
        sides = {1: torch.export.Dim("height"), 2: torch.export.Dim("width")}
        picture = torch.zeros(1, 5, 7, 3, dtype=torch.uint8)
        with replacing(file) as whole:
            translate(_OfBytes(), picture, whole, input_names=["picture"], dynamic_shapes=(sides,))


class _OfBytes(nn.Module):
    """Reads a picture's signal as `strip_signal` does: of each band, the pixels with a centre in
    it.
    """

    def forward(self, picture: torch.Tensor) -> torch.Tensor:
        grey = (picture[0].int() * torch.tensor((19595, 38470, 7471))).sum(-1) + 0x8000  # Pillow's
        columns = (grey >> 16).float().mean(0)
        width = columns.shape[0]
        centres = (torch.arange(STRIPES) + 0.5) * width / STRIPES
        away = (torch.arange(width) + 0.5 - centres[:, None]) * STRIPES / max(width, STRIPES)
        bands = ((away > -0.5) & (away <= 0.5)).float()
        return ((bands @ columns / bands.sum(1) - MIDDLE) / SWING)[None]
