"""The contract of an encoder, the table of encoders, their loading, and two encoders as one."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from omnivat.errors import DataError

if TYPE_CHECKING:
    import numpy as np
    import torch
    from PIL import Image


JOINED = " | "  # separator of the two names, VIS first


class PairEncoder:
    """Two encoders: `vis` for photos, `tac` for tactile images.

    If their widths differ, the narrower embeddings are padded with zeros, which changes no length,
    distance or cosine within a modality. The name combines both names, so it can be loaded again.
    """

    def __init__(self, vis: "Encoder", tac: "Encoder") -> None:
        from omnivat.encoders.wrapping import NamedEncoder

        self.width = max(vis.width, tac.width)
        self.vis, self.tac = (
            one if one.width == self.width else NamedEncoder(one, one.name, self.width) for one in (vis, tac)
        )
        self.name = JOINED.join((vis.name, tac.name))
        self.weights_hash = JOINED.join((vis.weights_hash, tac.weights_hash))
        self.precision = vis.precision if vis.precision == tac.precision else f"{vis.precision}/{tac.precision}"
        self.preprocessing = f"VIS: {self.vis.preprocessing}; TAC: {self.tac.preprocessing}"

    def preprocess(self, _: Any) -> "torch.Tensor":
        """Refuse: each modality has its own (`for_modality`). Raises DataError."""
        raise DataError(f"'{self.name}' has an encoder for each modality; say which one is meant.")

    embed = preprocess


def for_modality(encoder: "Encoder", modality: str) -> "Encoder":
    """Return the encoder for "vis" or "tac"; a single encoder serves both."""
    if not isinstance(encoder, PairEncoder):
        return encoder
    found: Encoder = encoder.vis if modality == "vis" else encoder.tac
    return found


DEFAULT_ENCODER = "efficientnet-lite0"
ENCODERS = {
    "efficientnet-lite0": "omnivat.encoders.efficientnet:load_lite0",
    "clip-vit-b32": "omnivat.encoders.clip:load",
    "clip-vit-b16": "omnivat.encoders.clip:load",
    "clip-vit-l14": "omnivat.encoders.clip:load",
    "clip-vit-l14-336": "omnivat.encoders.clip:load",
    "clip-rn50": "omnivat.encoders.clip:load",
    "clip-rn101": "omnivat.encoders.clip:load",
    "clip": "omnivat.encoders.clip:load",
    "sitr": "omnivat.encoders.sitr:load",
    "strip": "omnivat.encoders.strip:load_strip",
}


class Encoder(Protocol):
    """An image encoder with frozen weights.

    name            its name for `load_encoder`
    width           D, the length of an embedding
    preprocessing   a description of the preprocessing, also written to file headers
    weights_hash    a hash of the weights
    precision       "fp32", "bf16" or "fp32-onnx", for computation; embeddings are float32

    An encoder with a text tower also has `text_hash`, a hash of the tower's weights.
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
        """Convert an RGB image to the (C, H, W) float32 tensor for `embed`."""
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
                    `module:function` or `file.py:function` for your own; the name of an entry point
                    of the group "omnivat.encoders"; or two of these, "VIS | TAC", one for each
    weights         a checkpoint instead of the default one
    tac_weights     the same for the TAC encoder of two
    device          "cpu", "cuda" or "auto"
    precision       "fp32"; "bf16" is faster, with slightly different embeddings; "fp32-onnx" (the
                    default encoder on a CPU) is faster and changes only the last digits
    download        "ask", "yes" or "no": permission to fetch missing weights from the hub
    weights_hash    expected hash, if known: without `weights`, the last file with that hash is read

    Raises MissingNameError for an unknown name, SettingsError for an unavailable precision or device, DataError if the
    encoder violates the contract or a checkpoint is missing; the message then has the command that fetches it.
    """
    settings = {"device": device, "precision": precision, "download": download}
    if JOINED not in name:
        return _load_one(name, weights, weights_hash, settings)
    names, hashes = name.partition(JOINED)[::2], weights_hash.partition(JOINED)[::2]
    return PairEncoder(*map(_load_one, names, (weights, tac_weights), hashes, (settings,) * 2))


def _load_one(name: str, weights: Path | None, weights_hash: str, settings: dict[str, Any]) -> Encoder:
    from omnivat.devices import device_from
    from omnivat.encoders.hub import recall, remember
    from omnivat.encoders.names import accepted, loader_of
    from omnivat.encoders.wrapping import checked

    place = weights or (recall(weights_hash) if weights_hash else None)
    loader, own = loader_of(name, ENCODERS), {"name": name} if name in ENCODERS else {}
    wanted = {**settings, "device": device_from(settings["device"]), "weights": place, **own}
    found = loader(**accepted(loader, name, wanted))
    encoder = found if name in ENCODERS else checked(found, name)
    if weights is not None:
        remember(encoder.weights_hash, weights)
    elif name.startswith("hf:") and (folder := Path(name.removeprefix("hf:"))).is_dir():
        remember(encoder.weights_hash, folder)
    return encoder


def text_encoder(
    name: str, *, weights: Path | None = None, device: str = "cpu"
) -> "Callable[[Sequence[str]], np.ndarray[Any, Any]]":
    """Return a function that embeds texts (B) as float32 (B, D) in the space of encoder `name`.

    Raises MissingNameError for an encoder without a text tower, DataError if a checkpoint is missing.
    """
    from omnivat.encoders.clip_text import load_text_encoder

    tower = load_text_encoder(name, weights=weights, device=device)
    return lambda texts: tower.embed_texts(texts).cpu().numpy()
