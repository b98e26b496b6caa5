"""Wrap any torch network as an encoder, in a few lines of code, or check an encoder of one's own.

    from omnivat import TorchEncoder

    def load(weights, device):
        network = TheirModel()
        network.load_state_dict(torch.load(weights, weights_only=True))
        return TorchEncoder(network, side=224, device=device)

Used as `--encoder their_module:load --weights FILE`; docs/encoders.md has whole examples."""

from collections.abc import Callable, Sequence
from functools import partial
from hashlib import blake2b
from inspect import Parameter, signature
from typing import Any

import numpy as np
import torch
from PIL import Image
from torch import Tensor, nn

from omnivat.data.arrays import require_range
from omnivat.data.dots import FILLED, fill_dots
from omnivat.data.relief import Lamps, drawn
from omnivat.data.relief.files import MARKS, packed
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
from omnivat.kit.errors import DataError, SettingsError

NOISE = Image.fromarray(  # a test picture, on which two encoders differ
    np.random.default_rng(0).integers(0, 256, (64, 64, 3), dtype=np.uint8)
)
CONTEXT = {  # what an encoder may take beside its image, and where it comes from
    "before": "the touch of a moment before: name it in the table's column tac_before",
    "rest": "the picture of the untouched sensor: give it with --tac-rest all",
    "sensor": "the kind of sensor: name the domain after it, or write ENCODER@SENSOR",
}
IMAGENET_MEAN, IMAGENET_STD = (0.485, 0.456, 0.406), (0.229, 0.224, 0.225)


class TorchEncoder:
    """A torch network as an `Encoder`.

    network     (B, C, H, W) -> (B, D), or any output that `pool` converts to (B, D)
    side        side in pixels after resizing
    mean, std   of red, green and blue, for values in 0 to 1
    prepare     Image -> (C, H, W) float32, instead of resizing and normalising. It may have more
                arguments: `before`, the image of a moment before; `rest`, one of the untouched
                sensor; `sensor`, the kind of sensor. One without a default has to be there
    pool        output of the network -> (B, D), such as `lambda tokens: tokens[:, 0]`
    about       one line on `prepare` and `pool`, for the header of a file
    device      device of the computation
    precision   "fp32", "bf16", or "fp32-onnx" where `onnx` allows it
    onnx        True if the network was checked in ONNX Runtime
    width       D, if it is known; 0 finds and checks it by two runs on a test picture
    name        its name; load_encoder replaces it by the name used for loading
    weights_hash, text_hash  hashes of its weights, "" for those of the network, and of a text tower

    The attribute `takes` names the further arguments of `prepare`. `load_encoder` sets `sensor` to
    the kind in a name such as "t3@digit", which then holds for every image.

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
        prepare: Callable[..., Tensor] | None = None,
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
        self._prepare, self._pool = prepare or partial(pixels, mean=mean, std=std, side=side), pool
        taken = signature(self._prepare).parameters
        self.takes = tuple(name for name in CONTEXT if name in taken)
        self._needs = [name for name in self.takes if taken[name].default is Parameter.empty]
        self.sensor = ""
        steps = [resized(side, self.mean, self.std)] if prepare is None else []
        self.preprocessing = ", ".join([*steps, about] if about else steps) or "own preprocessing"
        self._device = torch.device(device)
        self._type = precision_type(precision, self._device, onnx=onnx)
        self.network: Any = placed(network, self._device, self._type)
        if precision == ONNX:
            self.network = in_onnx_runtime(self.network, torch.zeros(1, 3, side, side))
        self.width = width or len(probed(self))

    def preprocess(self, image: Image.Image, **context: Any) -> Tensor:
        """Convert an RGB image to the tensor (C, H, W) for `embed`; `context` by `takes`."""
        for name in self._needs:
            if not context.get(name):
                raise DataError(f"'{self.name}' needs {CONTEXT[name]}.")
        return self._prepare(image, **context).to(torch.float32)

    def embed(self, images: Tensor) -> Tensor:
        """Return the embeddings (B, D) of preprocessed images (B, C, H, W)."""
        return one_by_one(self._forward, images.to(self._device, self._type))

    def _forward(self, images: Tensor) -> Tensor:
        output: Tensor = self.network(images)
        return output if self._pool is None else self._pool(output)

    def at(self, layer: str) -> "TorchEncoder":
        """Return an encoder of the mean of one layer's output over its places.

        layer  its number, from 1, in the network's longest list of layers, or the name of any part

        Raises SettingsError for a layer that the network does not have.
        """
        if self.precision == ONNX:
            raise SettingsError(
                f"--layer and --precision {ONNX} exclude one another; leave one out."
            )
        return TorchEncoder(
            Until(self.network, layer), prepare=self._prepare, pool=averaged, device=self._device,
            about=f"{self.preprocessing}, layer {layer}, mean of its places",
            precision=self.precision, name=self.name, weights_hash=self.weights_hash,
        )  # fmt: skip


class Reached(Exception):
    """Ends a network's run with a layer's output."""


class Until(nn.Module):
    """A network up to one of its layers, whose output it returns."""

    def __init__(self, network: nn.Module, layer: str) -> None:
        super().__init__()
        self.network = network
        lists = [m for m in network.modules() if isinstance(m, nn.ModuleList | nn.Sequential)]
        longest = max(lists, key=len, default=nn.Sequential())
        parts = dict(network.named_modules()) | {str(k): m for k, m in enumerate(longest, 1)}
        if layer not in parts:
            names = ", ".join(name for name, _ in network.named_children())
            raise SettingsError(
                f"There is no layer '{layer}'; give a number from 1 to {len(longest)}, or a part of"
                f" {names}."
            )
        parts[layer].register_forward_hook(self._stop)

    @staticmethod
    def _stop(module: nn.Module, given: Any, output: Any) -> None:
        raise Reached(output[0] if isinstance(output, tuple) else output)

    def forward(self, images: Tensor) -> Any:
        """Return the layer's output for images (B, C, H, W)."""
        try:
            self.network(images)
        except Reached as reached:
            return reached.args[0]
        raise DataError("The network does not run this layer; choose another one.")


def averaged(output: Tensor) -> Tensor:
    """Return the mean (B, D) of maps (B, D, H, W) or tokens (B, N, D) over their places."""
    if output.ndim == 4:
        return output.mean(dim=(2, 3))
    return output.mean(dim=1) if output.ndim == 3 else output


def probed(encoder: Any) -> Tensor:
    """Return an encoder's vector (D,) of a test picture.

    Raises DataError if the vector is not finite or not of shape (1, D), or if a second run gives
    another one.
    """
    context = {"before": NOISE, "rest": NOISE, "sensor": getattr(encoder, "sensor", "") or "DIGIT"}
    image = encoder.preprocess(NOISE, **{name: context[name] for name in takes_of(encoder)})
    first, second = (encoder.embed(image[None]) for _ in range(2))
    known = not first.is_meta  # a device without values
    if first.ndim != 2 or len(first) != 1 or (known and not first.isfinite().all()):
        raise DataError(
            f"'{encoder.name}' gave a tensor of shape {tuple(first.shape)} for one image; expected "
            "a finite vector (1, D). With TorchEncoder, set pool=."
        )
    if known and not torch.equal(first, second):
        raise DataError(
            f"'{encoder.name}' gives another embedding each time; switch off dropout, masks and "
            "other random parts of the network."
        )
    if known:  # a set would be refused at its end
        list(require_range([first.float().cpu().numpy()], f"A vector of '{encoder.name}'"))
    vector: Tensor = first[0]
    return vector


def takes_of(encoder: Any) -> tuple[str, ...]:
    """Return what of `CONTEXT` an encoder takes beside an image."""
    return tuple(getattr(encoder, "takes", ()))


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
    if isinstance(encoder, TorchEncoder):
        encoder.name = name
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
        self.takes, self.sensor = takes_of(inner), str(getattr(inner, "sensor", ""))

    def preprocess(self, image: Image.Image, **context: Any) -> Tensor:
        """Convert an RGB image to the tensor (C, H, W) for `embed`; `context` by `takes`."""
        pixels: Tensor = self._inner.preprocess(image, **context)
        return pixels

    def embed(self, images: Tensor) -> Tensor:
        """Return the embeddings (B, D), float32."""
        with torch.inference_mode():
            return nn.functional.pad(self._inner.embed(images).float(), (0, self._zeros))


class WithoutDots(NamedEncoder):
    """An encoder of tactile images that fills their printed dots first.

    touch  "relief": it then draws their relief in place of their colours; "both": an embedding in
           colours is followed by that of the relief
    lamps  of the sensor, for the relief; None: those that each picture gives alone
    """

    def __init__(self, inner: Any, lamps: Lamps | None = None, *, touch: str = "colours") -> None:
        super().__init__(inner, inner.name)
        self.preprocessing += FILLED + MARKS.get(touch, "")
        self.inner, self.lamps, self.touch = inner, lamps, touch
        self.width *= 1 + (touch == "both")
        if lamps is not None:
            self.probe += blake2b(packed(lamps).encode(), digest_size=8).hexdigest()

    def preprocess(self, image: Image.Image, **context: Any) -> Tensor:
        """Convert an RGB image, without its dots or drawn as its relief, to the tensor (C, H, W)
        for `embed`, or both to (2, C, H, W); `context` by `takes`.
        """
        looks = (self.cleaned, self.drawn) if self.touch == "both" else (self.drawn,)
        made = []
        for look in looks:
            reads = {"before": look, "rest": self.cleaned}
            more = {name: reads[name](value) for name, value in context.items() if name in reads}
            made.append(super().preprocess(look(image), **context | more))
        return torch.stack(made) if self.touch == "both" else made[0]

    def embed(self, images: Tensor) -> Tensor:
        """Return the embeddings (B, D), float32; of both drawings side by side, if there are
        both.
        """
        looks = images.unbind(1) if self.touch == "both" else (images,)
        return torch.cat([NamedEncoder.embed(self, look) for look in looks], 1)

    def drawn(self, image: Image.Image) -> Image.Image:
        """Return the image as the encoder sees it, of both its relief; the same object if nothing
        changes.
        """
        clean = self.cleaned(image)
        if self.touch == "colours":
            return clean
        return Image.fromarray(drawn(np.asarray(clean), self.lamps, dots="keep"))

    def cleaned(self, image: Image.Image) -> Image.Image:
        """Return the image without its dots, or as it is if it has none."""
        filled, dots = fill_dots(np.asarray(image))
        return image if dots is None else Image.fromarray(filled)
