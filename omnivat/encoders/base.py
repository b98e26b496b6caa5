"""The contract of an encoder, the table of those there are, and how one is loaded."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from omnivat.tables import load

if TYPE_CHECKING:
    import numpy as np
    import torch
    from PIL import Image

DEFAULT_ENCODER = "efficientnet-lite0"
ENCODERS = {
    "efficientnet-lite0": "omnivat.encoders.efficientnet:load_lite0",
    "clip-rn50": "omnivat.encoders.clip_resnet:load_rn50",
    "clip-vit-b16": "omnivat.encoders.clip_vit:load_vit_b16",
    "clip-vit-l14": "omnivat.encoders.clip_vit:load_vit_l14",
}


class Encoder(Protocol):
    """An image encoder with frozen weights.

    name            its entry in ENCODERS
    width           D, the length of an embedding
    preprocessing   what happens to an image first, for people and for the header of a file
    weights_hash    tells two sets of weights apart
    precision       "fp32", "bf16" or "fp32-onnx": how it computes; embeddings are float32
    """

    @property
    def name(self) -> str: ...
    @property
    def width(self) -> int: ...
    @property
    def preprocessing(self) -> str: ...
    @property
    def weights_hash(self) -> str: ...
    @property
    def precision(self) -> str: ...

    def preprocess(self, image: "Image.Image") -> "torch.Tensor":
        """Return an RGB image as the (3, H, W) float32 tensor that `embed` takes."""
        ...

    def embed(self, images: "torch.Tensor") -> "torch.Tensor":
        """Return the embeddings (B, D), float32, of preprocessed images (B, 3, H, W).

        An image has the same embedding, to the last bit, alone and in any batch.
        """
        ...


def load_encoder(
    name: str, *, weights: Path | None = None, device: str = "cpu", precision: str = "fp32"
) -> Encoder:
    """Load the encoder called `name`.

    weights     a checkpoint to use in place of the one found by default
    device      "cpu", "cuda" or "auto"
    precision   "fp32"; for less time "bf16", whose embeddings differ a little, or, for the default
                encoder on a CPU, "fp32-onnx", whose last digits differ

    Raises MissingNameError for an unknown name, SettingsError for a precision or device that is not
    there, and DataError, saying what to fetch, when a checkpoint is missing.
    """
    loader = load(ENCODERS, name, kind="encoder")
    from omnivat.devices import device_from

    encoder: Encoder = loader(weights=weights, device=device_from(device), precision=precision)
    return encoder


def text_encoder(
    name: str, *, weights: Path | None = None, device: str = "cpu"
) -> "Callable[[Sequence[str]], np.ndarray[Any, Any]]":
    """Return what embeds texts (B) as float32 (B, D) in the space of the image encoder `name`.

    Raises MissingNameError for an encoder without a text tower, DataError when a checkpoint is
    missing.
    """
    from omnivat.encoders.clip_text import load_text_encoder

    tower = load_text_encoder(name, weights=weights, device=device)
    return lambda texts: tower.embed_texts(texts).cpu().numpy()
