"""Wrap any torch network as an encoder, in a few lines of code, or check an encoder of one's own.

    from omnivat import TorchEncoder

    def load(weights, device):
        network = TheirModel()
        network.load_state_dict(torch.load(weights, weights_only=True))
        return TorchEncoder(network, side=224, device=device)

Used as `--encoder their_module:load --weights FILE`; docs/encoders.md has whole examples."""

from collections.abc import Callable, Sequence
from hashlib import blake2b
from typing import Any

import numpy as np
import torch
from PIL import Image
from torch import Tensor, nn

from omnivat.data.dots import FILLED, fill_dots
from omnivat.data.relief import Lamps, drawn
from omnivat.data.relief.files import RELIEF, packed
from omnivat.encoders.onnx_runtime import in_onnx_runtime
from omnivat.encoders.running import (
    ONNX,
    one_by_one,
    pixels,
    placed,
    precision_type,
    resized,
    state_hash,
)
from omnivat.kit.errors import DataError

NOISE = Image.fromarray(  # a test picture, on which two encoders differ
    np.random.default_rng(0).integers(0, 256, (64, 64, 3), dtype=np.uint8)
)
IMAGENET_MEAN, IMAGENET_STD = (0.485, 0.456, 0.406), (0.229, 0.224, 0.225)


class TorchEncoder:
    """A torch network as an `Encoder`.

    network     (B, C, H, W) -> (B, D), or any output that `pool` converts to (B, D)
    side        side in pixels after resizing
    mean, std   of red, green and blue, for values in 0 to 1
    prepare     Image -> (C, H, W) float32, instead of resizing and normalising
    pool        output of the network -> (B, D), such as `lambda tokens: tokens[:, 0]`
    about       one line on `prepare` and `pool`, for the header of a file
    device      device of the computation
    precision   "fp32", "bf16", or "fp32-onnx" where `onnx` allows it
    onnx        True if the network was checked in ONNX Runtime
    width       D, if it is known; 0 finds and checks it by two runs on a test picture
    name        its name; load_encoder replaces it by the name used for loading
    weights_hash, text_hash  hashes of its weights, "" for those of the network, and of a text tower

    Raises DataError if the network does not return one finite vector for each image.

    >>> network = nn.Sequential(nn.Conv2d(3, 8, 4, 4), nn.AdaptiveAvgPool2d(1), nn.Flatten())
    >>> encoder = TorchEncoder(network, side=32)
    >>> picture = encoder.preprocess(Image.new("RGB", (64, 48)))
    >>> encoder.width, tuple(encoder.embed(picture[None]).shape)
    (8, (1, 8))
    """

    def __init__(
        self,
        network: nn.Module,
        *,
        side: int = 224,
        mean: Sequence[float] = IMAGENET_MEAN,
        std: Sequence[float] = IMAGENET_STD,
        prepare: Callable[[Image.Image], Tensor] | None = None,
        pool: Callable[..., Tensor] | None = None,
        about: str = "",
        device: torch.device | str = "cpu",
        precision: str = "fp32",
        onnx: bool = False,
        width: int = 0,
        name: str = "",
        weights_hash: str = "",
        text_hash: str = "",
    ) -> None:
        self.name = name or type(network).__name__
        self.side, self.mean, self.std = side, tuple(mean), tuple(std)
        self.precision = precision
        self.weights_hash = weights_hash or state_hash(network.state_dict())
        self.text_hash = text_hash
        self._prepare, self._pool = prepare, pool
        steps = [resized(side, self.mean, self.std)] if prepare is None else []
        self.preprocessing = ", ".join([*steps, about] if about else steps) or "own preprocessing"
        self._device = torch.device(device)
        self._type = precision_type(precision, self._device, onnx=onnx)
        self.network: Any = placed(network, self._device, self._type)
        if precision == ONNX:
            self.network = in_onnx_runtime(self.network, torch.zeros(1, 3, side, side))
        self.width = width or len(probed(self))

    def preprocess(self, image: Image.Image) -> Tensor:
        """Convert an RGB image to the tensor (C, H, W) for `embed`."""
        if self._prepare is not None:
            return self._prepare(image).to(torch.float32)
        return pixels(image, self.mean, self.std, self.side)

    def embed(self, images: Tensor) -> Tensor:
        """Return the embeddings (B, D) of preprocessed images (B, C, H, W)."""
        return one_by_one(self._forward, images.to(self._device, self._type))

    def _forward(self, images: Tensor) -> Tensor:
        output: Tensor = self.network(images)
        return output if self._pool is None else self._pool(output)


def probed(encoder: Any) -> Tensor:
    """Return an encoder's vector of a test picture: two runs have to give one that is finite.

    Raises DataError with what it gave instead.
    """
    image = encoder.preprocess(NOISE)
    first, second = (encoder.embed(image[None]) for _ in range(2))
    known = not first.is_meta  # a device without values
    if first.ndim != 2 or len(first) != 1 or (known and not first.isfinite().all()):
        raise DataError(
            f"'{encoder.name}' gave a tensor of shape {tuple(first.shape)} for one image, and one "
            "finite vector (1, D) is wanted; a TorchEncoder takes pool= for this."
        )
    if known and not torch.equal(first, second):
        raise DataError(
            f"'{encoder.name}' gives another embedding each time; switch off dropout, masks and "
            "other random parts of the network."
        )
    vector: Tensor = first[0]
    return vector


TEXTS = ("preprocessing", "weights_hash")


def checked(encoder: Any, name: str) -> "NamedEncoder":
    """Return `encoder` under `name`. Raises DataError with the missing part."""
    parts = ("preprocess", "embed", "width", *TEXTS)
    if missing := [part for part in parts if not hasattr(encoder, part)]:
        raise DataError(
            f"'{name}' returned {type(encoder).__name__}, which has no {', '.join(missing)}; return"
            " an omnivat.encoders.TorchEncoder, or an object with the contract in"
            " docs/encoders.md."
        )
    for part in TEXTS:
        if not isinstance(getattr(encoder, part), str) or not getattr(encoder, part):
            raise DataError(f"'{name}' has no text in {part}; it identifies the weights.")
    named = NamedEncoder(encoder, name)
    vector = probed(named)
    if len(vector) != named.width:
        raise DataError(
            f"'{name}' gave {len(vector)} values for one image, and its width is {named.width}."
        )
    named.probe = "" if vector.is_meta else state_hash({"probe": vector})
    return named


class NamedEncoder:
    """An encoder under a name: embeddings become float32, with zeros up to `width` if that is
    larger.
    """

    def __init__(self, inner: Any, name: str, width: int = 0) -> None:
        self._inner, self.name = inner, name
        self.width = max(width, int(inner.width))
        self._zeros = self.width - int(inner.width)
        more = f", {inner.width} values and zeros up to {width}" if self._zeros else ""
        self.preprocessing, self.weights_hash = inner.preprocessing + more, inner.weights_hash
        self.precision = str(getattr(inner, "precision", "fp32"))
        self.text_hash = str(getattr(inner, "text_hash", ""))
        self.probe = str(getattr(inner, "probe", ""))  # tells apart versions of one's own code

    def preprocess(self, image: Image.Image) -> Tensor:
        """Convert an RGB image to the tensor (C, H, W) for `embed`."""
        pixels: Tensor = self._inner.preprocess(image)
        return pixels

    def embed(self, images: Tensor) -> Tensor:
        """Return the embeddings (B, D), float32."""
        with torch.inference_mode():
            return nn.functional.pad(self._inner.embed(images).float(), (0, self._zeros))


class WithoutDots(NamedEncoder):
    """An encoder of tactile images that fills their printed dots first.

    relief  it then draws their relief in place of their colours
    lamps   of the sensor, for the relief; None: those that each picture gives alone
    """

    def __init__(self, inner: Any, lamps: Lamps | None = None, *, relief: bool = False) -> None:
        super().__init__(inner, inner.name)
        self.preprocessing += FILLED + RELIEF * relief
        self.inner, self.lamps, self.relief = inner, lamps, relief
        if lamps is not None:
            self.probe += blake2b(packed(lamps).encode(), digest_size=8).hexdigest()

    def preprocess(self, image: Image.Image) -> Tensor:
        """Convert an RGB image, without its dots or drawn as its relief, to the tensor (C, H, W)
        for `embed`.
        """
        clean = self.cleaned(image)
        if self.relief:
            clean = Image.fromarray(drawn(np.asarray(clean), self.lamps, dots="keep"))
        return super().preprocess(clean)

    def cleaned(self, image: Image.Image) -> Image.Image:
        """Return the image without its dots, or as it is if it has none."""
        filled, dots = fill_dots(np.asarray(image))
        return image if dots is None else Image.fromarray(filled)
