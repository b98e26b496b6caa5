"""The contract of an encoder, the table of those there are, and how one is loaded."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

if TYPE_CHECKING:
    import numpy as np
    import torch
    from PIL import Image

DEFAULT_ENCODER = "efficientnet-lite0"
ENCODERS = {
    "efficientnet-lite0": "omnivat.encoders.efficientnet:load_lite0",
    "clip-vit-b32": "omnivat.encoders.clip:load_vit_b32",
    "clip-vit-b16": "omnivat.encoders.clip:load_vit_b16",
    "clip-vit-l14": "omnivat.encoders.clip:load_vit_l14",
    "clip-vit-l14-336": "omnivat.encoders.clip:load_vit_l14_336",
    "clip-rn50": "omnivat.encoders.clip:load_rn50",
    "clip-rn101": "omnivat.encoders.clip:load_rn101",
    "clip": "omnivat.encoders.clip:load_any",
    "sitr": "omnivat.encoders.sitr:load",
    "strip": "omnivat.encoders.strip:load_strip",
}


class Encoder(Protocol):
    """An image encoder with frozen weights.

    name            what `load_encoder` loads it by
    width           D, the length of an embedding
    preprocessing   what happens to an image first, for people and for the header of a file
    weights_hash    tells two sets of weights apart
    precision       "fp32", "bf16" or "fp32-onnx": how it computes; embeddings are float32

    An encoder with a text tower beside it also has `text_hash`, which tells those apart.
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
        """Return an RGB image as the (C, H, W) float32 tensor that `embed` takes."""
        ...

    def embed(self, images: "torch.Tensor") -> "torch.Tensor":
        """Return the embeddings (B, D), float32, of preprocessed images (B, C, H, W).

        An image has the same embedding, to the last bit, alone and in any batch.
        """
        ...


def load_encoder(
    name: str,
    *,
    weights: Path | None = None,
    tac_weights: Path | None = None,
    device: str = "cpu",
    precision: str = "fp32",
    download: str = "ask",
    weights_hash: str = "",
) -> Encoder:
    """Load the encoder called `name`.

    name            a key of ENCODERS; `hf:NAME_OR_FOLDER` for a vision model of transformers;
                    `module:function` or `file.py:function` for one's own; the name of an entry point
                    of the group "omnivat.encoders"; or two of these, "VIS | TAC", one for each
    weights         a checkpoint to use in place of the one found by default
    tac_weights     the same for the second of two
    device          "cpu", "cuda" or "auto"
    precision       "fp32"; for less time "bf16", whose embeddings differ a little, or, for the
                    default encoder on a CPU, "fp32-onnx", whose last digits differ
    download        "ask", "yes" or "no": whether missing weights may be fetched from the hub
    weights_hash    of the weights that are wanted, where known: without `weights`, they are read
                    where weights of that hash were read last

    Raises MissingNameError for an unknown name, SettingsError for a precision or device that is not
    there, and DataError when a checkpoint is missing, which names the command that fetches it, or
    when the encoder does not keep the contract.
    """
    from omnivat.encoders.paired import JOINED, PairEncoder

    if JOINED in name:
        vis, _, tac = name.partition(JOINED)
        of_vis, _, of_tac = weights_hash.partition(JOINED)
        settings = {"device": device, "precision": precision, "download": download}
        return PairEncoder(
            _load_one(vis, weights, of_vis, settings), _load_one(tac, tac_weights, of_tac, settings)
        )
    settings = {"device": device, "precision": precision, "download": download}
    return _load_one(name, weights, weights_hash, settings)


def _load_one(
    name: str, weights: Path | None, weights_hash: str, settings: dict[str, Any]
) -> Encoder:
    from omnivat.devices import device_from
    from omnivat.encoders.checked import checked
    from omnivat.encoders.names import accepted, loader_of
    from omnivat.encoders.places import recall, remember

    place = weights or (recall(weights_hash) if weights_hash else None)
    loader = loader_of(name, ENCODERS)
    wanted = {**settings, "device": device_from(settings["device"]), "weights": place}
    found = loader(**accepted(loader, name, wanted))
    encoder = found if name in ENCODERS else checked(found, name)
    if weights is not None:
        remember(encoder.weights_hash, weights)
    elif name.startswith("hf:") and Path(name.removeprefix("hf:")).is_dir():
        remember(encoder.weights_hash, Path(name.removeprefix("hf:")))
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
