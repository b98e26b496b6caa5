"""Check a custom encoder against the contract, and name it."""

from typing import Any

import torch
from PIL import Image
from torch import Tensor

from omnivat.errors import DataError

TEXTS = ("preprocessing", "weights_hash")


def checked(encoder: Any, name: str) -> "NamedEncoder":
    """Return `encoder` under `name`. Raises DataError with the missing part.

    One test image must give one finite float32 vector of the stated width.
    """
    missing = [
        part for part in ("preprocess", "embed", "width", *TEXTS) if not hasattr(encoder, part)
    ]
    if missing:
        raise DataError(
            f"'{name}' returned {type(encoder).__name__}, which has no {', '.join(missing)}; return "
            "an omnivat.encoders.TorchEncoder, or an object with the contract in docs/encoders.md."
        )
    for part in TEXTS:
        if not isinstance(getattr(encoder, part), str) or not getattr(encoder, part):
            raise DataError(f"'{name}' has no text in {part}; it identifies the weights.")
    found = NamedEncoder(encoder, name)
    pixels = found.preprocess(Image.new("RGB", (64, 64), (128, 120, 110)))
    if not isinstance(pixels, Tensor) or pixels.ndim != 3:
        raise DataError(f"preprocess of '{name}' gave no tensor (C, H, W) for an image.")
    vector = found.embed(pixels[None])
    if tuple(vector.shape) != (1, found.width):
        raise DataError(
            f"embed of '{name}' gave shape {tuple(vector.shape)} for one image, expected "
            f"(1, {found.width})."
        )
    if not vector.is_meta and not vector.isfinite().all():
        raise DataError(f"embed of '{name}' gave NaN or infinite values for a grey image.")
    return found


class NamedEncoder:
    """A custom encoder under its name; embeddings become float32 on the CPU."""

    def __init__(self, inner: Any, name: str) -> None:
        self._inner = inner
        self.name = name
        self.width = int(inner.width)
        self.preprocessing, self.weights_hash = str(inner.preprocessing), str(inner.weights_hash)
        self.precision = str(getattr(inner, "precision", "fp32"))
        self.text_hash = str(getattr(inner, "text_hash", ""))

    def preprocess(self, image: Image.Image) -> Tensor:
        """Convert an RGB image to the tensor (C, H, W) for `embed`."""
        pixels: Tensor = self._inner.preprocess(image)
        return pixels

    def embed(self, images: Tensor) -> Tensor:
        """Return the embeddings (B, D), float32."""
        with torch.inference_mode():
            vectors: Tensor = self._inner.embed(images)
        return vectors.float()
