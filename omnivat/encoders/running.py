"""Shared by encoders: pixels to tensors, hashes of weights, and running image by image."""

from collections.abc import Callable, Mapping, Sequence
from hashlib import blake2b
from typing import TypeVar

import numpy as np
import torch
from PIL import Image
from torch.nn.functional import conv2d

from omnivat.kit.errors import SettingsError
from omnivat.kit.shapes import require_shapes
from omnivat.kit.tables import require_choice
from omnivat.kit.threads import one_thread

M = TypeVar("M", bound=torch.nn.Module)
SIDE = 224  # pixels, as in the paper; other sizes only if the weights require them
CLIP_MEAN = (0.48145466, 0.4578275, 0.40821073)
CLIP_STD = (0.26862954, 0.26130258, 0.27577711)
ONNX = "fp32-onnx"
PRECISIONS = {"fp32": torch.float32, "bf16": torch.bfloat16, ONNX: torch.float32}


def pixels(
    image: Image.Image,
    mean: Sequence[float],
    std: Sequence[float],
    side: int | tuple[int, int] = SIDE,
) -> torch.Tensor:
    """Return an RGB image as (3, side, side) float32: resized directly, then (0..1 - mean) / std.

    mean, std   of red, green and blue
    side        or height and width
    The aspect ratio is not kept, as the paper resizes (METHOD A44).
    """
    plain = image if image.mode == "RGB" else image.convert("RGB")  # converting would copy
    height, width = (side, side) if isinstance(side, int) else side
    values = np.array(plain.resize((width, height), Image.Resampling.BICUBIC), np.float32)
    values /= 255  # in numpy: for so few numbers torch's threads would wait for one another
    values -= np.array(mean, np.float32)
    values /= np.array(std, np.float32)
    return torch.from_numpy(values).permute(2, 0, 1)


def resized(side: int, mean: Sequence[float], std: Sequence[float]) -> str:
    """Return a description of `pixels` for file headers.

    >>> resized(224, (0.5, 0.5, 0.5), (0.5, 0.5, 0.5))
    'resize 224x224 bicubic, RGB, mean 0.5 0.5 0.5, std 0.5 0.5 0.5'
    """
    size = f"resize {side}x{side} bicubic, RGB"
    if (tuple(mean), tuple(std)) == (CLIP_MEAN, CLIP_STD):
        return f"{size}, CLIP mean and std"
    numbers = [" ".join(f"{value:.6g}" for value in values) for values in (mean, std)]
    return f"{size}, mean {numbers[0]}, std {numbers[1]}"


def state_hash(state: Mapping[str, torch.Tensor]) -> str:
    """Return a hash of weights, 16 hex digits, independent of file and format."""
    digest = blake2b(digest_size=8)
    for name in sorted(state):
        tensor = state[name].detach().cpu().contiguous()
        digest.update(f"{name} {tensor.dtype} {tuple(tensor.shape)}".encode())
        digest.update(tensor.view(-1).view(torch.uint8).numpy().data)
    return digest.hexdigest()


def precision_type(precision: str, device: torch.device, *, onnx: bool = False) -> torch.dtype:
    """Return the dtype for computation.

    onnx  True if the encoder supports ONNX Runtime

    Raises SettingsError for an unknown name, for "bf16" on a CPU that only emulates it, and for
    "fp32-onnx" if it is not supported.
    """
    require_choice("precision", precision, PRECISIONS)
    if precision == ONNX and not (onnx and device.type == "cpu"):
        raise SettingsError(
            f"precision is '{ONNX}', which is for efficientnet-lite0 on a CPU; use fp32 or bf16."
        )
    if precision == "bf16" and device.type == "cpu" and not cpu_has_bf16():
        raise SettingsError("precision is 'bf16' and this CPU cannot compute in it; use fp32.")
    return PRECISIONS[precision]


def cpu_has_bf16() -> bool:
    """True if this CPU has bf16 instructions.

    oneDNN reports bf16 for every processor with AVX-512, and emulates missing instructions, slower
    than fp32. On x86, the CPU's own flags are therefore read.
    """
    if not torch.backends.mkldnn.is_available() or not torch.ops.mkldnn._is_mkldnn_bf16_supported():
        return False
    found = torch.cpu.get_capabilities()
    native = found.get("avx512_bf16") or found.get("amx_bf16")
    return bool(native) or not str(found.get("architecture")).startswith("x86")


class FoldedConv(torch.nn.Module):
    """A convolution with its batch normalisation folded in, padded by half its kernel."""

    def __init__(
        self,
        state: Mapping[str, torch.Tensor],
        conv: str,
        norm: str,
        *,
        stride: int = 1,
        eps: float = 1e-5,
    ) -> None:
        super().__init__()
        scale = state[f"{norm}.weight"] / torch.sqrt(state[f"{norm}.running_var"] + eps)
        self.weight: torch.Tensor
        self.bias: torch.Tensor
        self.register_buffer("weight", state[f"{conv}.weight"] * scale[:, None, None, None])
        self.register_buffer("bias", state[f"{norm}.bias"] - state[f"{norm}.running_mean"] * scale)
        self.stride = stride

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        return conv2d(x, self.weight, self.bias, self.stride, padding=self.weight.shape[-1] // 2)


def placed(network: M, device: torch.device, dtype: torch.dtype) -> M:
    """Return the network ready to run: channels last, the fastest order on a CPU (1.6 times), but
    for films.
    """
    moved: M = network.eval().to(device, dtype)
    if any(value.ndim == 5 for value in moved.parameters()):
        return moved
    return moved.to(memory_format=torch.channels_last)  # type: ignore[call-overload,no-any-return]


def one_by_one(
    network: Callable[[torch.Tensor], torch.Tensor], images: torch.Tensor
) -> torch.Tensor:
    """Return float32 (B, D): `network` run on each image of (B, 3, H, W) separately.

    The last digits of a product depend on the batch size, the number of threads and the memory
    order. Each image is therefore copied to one memory order and run alone on one thread, so its
    embedding depends neither on its batch nor on the number of cores.
    """
    require_shapes(images=(images, "B C H W"))
    with torch.inference_mode(), one_thread():
        alone = (image[None].clone(memory_format=torch.channels_last) for image in images)
        return torch.cat([network(image).float() for image in alone])
