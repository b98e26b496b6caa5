"""Two encoders, for photos and for tactile images, as one."""

from typing import TYPE_CHECKING

from omnivat.errors import DataError

if TYPE_CHECKING:
    import torch
    from PIL import Image

    from omnivat.encoders.base import Encoder

JOINED = " | "  # separator of the two names, VIS first


class PairEncoder:
    """Two encoders: `vis` for photos, `tac` for tactile images.

    If their widths differ, the narrower embeddings are padded with zeros, which changes no length,
    distance or cosine within a modality. The name combines both names, so it can be loaded again.
    """

    def __init__(self, vis: "Encoder", tac: "Encoder") -> None:
        self.width = max(vis.width, tac.width)
        self.vis, self.tac = (
            one if one.width == self.width else _Padded(one, self.width) for one in (vis, tac)
        )
        self.name = JOINED.join((vis.name, tac.name))
        self.weights_hash = JOINED.join((vis.weights_hash, tac.weights_hash))
        self.precision = (
            vis.precision if vis.precision == tac.precision else f"{vis.precision}/{tac.precision}"
        )
        self.preprocessing = f"VIS: {self.vis.preprocessing}; TAC: {self.tac.preprocessing}"

    def preprocess(self, image: "Image.Image") -> "torch.Tensor":
        """Refuse: each modality has its own (`for_modality`). Raises DataError."""
        raise DataError(f"'{self.name}' has an encoder for each modality; say which one is meant.")

    def embed(self, images: "torch.Tensor") -> "torch.Tensor":
        """Refuse: each modality has its own (`for_modality`). Raises DataError."""
        raise DataError(f"'{self.name}' has an encoder for each modality; say which one is meant.")


class _Padded:
    """An encoder with embeddings padded with zeros to `width`."""

    def __init__(self, inner: "Encoder", width: int) -> None:
        self._inner = inner
        self.name, self.weights_hash = inner.name, inner.weights_hash
        self.precision = inner.precision
        self.width = width
        self.preprocessing = f"{inner.preprocessing}, {inner.width} values and zeros up to {width}"

    def preprocess(self, image: "Image.Image") -> "torch.Tensor":
        return self._inner.preprocess(image)

    def embed(self, images: "torch.Tensor") -> "torch.Tensor":
        from torch.nn.functional import pad

        return pad(self._inner.embed(images), (0, self.width - self._inner.width))


def for_modality(encoder: "Encoder", modality: str) -> "Encoder":
    """Return the encoder for "vis" or "tac"; a single encoder serves both."""
    if not isinstance(encoder, PairEncoder):
        return encoder
    found: Encoder = encoder.vis if modality == "vis" else encoder.tac
    return found
