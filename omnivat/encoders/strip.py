"""An encoder without weights that reads the signal of a picture of stripes."""

from pathlib import Path

import torch
from PIL import Image

from omnivat.data.strips import ENCODER, PREPROCESSING, READER, STRIPES, strip_signal
from omnivat.kit.errors import SettingsError
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


def load_strip(*, weights: Path | None, device: torch.device, precision: str) -> StripReader:
    """Return the reader. It has no weights and uses fp32 on the device of its input.

    Raises SettingsError for a checkpoint or another precision.
    """
    if weights is not None:
        raise SettingsError(f"The encoder '{ENCODER}' has no weights; leave out '{weights}'.")
    if precision != "fp32":
        raise SettingsError(f"precision is '{precision}'; the encoder '{ENCODER}' has fp32 only.")
    return StripReader()
