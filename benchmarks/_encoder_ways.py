"""Ways to run an encoder, for `benchmarks.encoders`: precision, memory order, batch, runtime."""

from collections.abc import Callable, Iterator
from copy import deepcopy
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import torch
from PIL import Image
from torch import Tensor

from omnivat.encoders import load_encoder, onnx_runtime
from omnivat.encoders.running import PRECISIONS, SIDE, cpu_has_bf16, one_by_one, placed

Run = Callable[[Tensor], Tensor]  # images (N, 3, 224, 224) -> embeddings (N, D), float32
CPU = torch.device("cpu")


def networks(folder: Path, batches: tuple[int, ...]) -> Iterator[tuple[str, dict[str, Run]]]:
    """Yield each network with the ways to run it; the first is the reference and the default."""
    lite: Any = load_encoder("efficientnet-lite0")
    yield "EfficientNet-Lite0", ways(lite._network, batches) | onnx_ways(lite._network, folder)
    yield "CLIP RN50 (random)", ways(rn50(), batches)
    if find_spec("transformers"):
        tower = vit_b16()
        yield "CLIP ViT-B/16 (random)", ways(tower, batches) | onnx_ways(tower, folder)


def ways(network: torch.nn.Module, batches: tuple[int, ...]) -> dict[str, Run]:
    """Return a network in each precision of this CPU: image by image, and batched."""
    found: dict[str, Run] = {}
    for kind in ("fp32", "bf16") if cpu_has_bf16() else ("fp32",):
        dtype = PRECISIONS[kind]
        ready = placed(deepcopy(network), CPU, dtype)
        found[kind] = alone(ready, dtype)
        if kind == "fp32":
            plain: torch.nn.Module = deepcopy(network).to(memory_format=torch.contiguous_format)  # type: ignore[call-overload]
            found["fp32, channels first"] = batched(plain, dtype, 1, torch.contiguous_format)
        for size in batches:
            found[f"{kind}, batch of {size}"] = batched(ready, dtype, size, torch.channels_last)
    return found


def alone(network: torch.nn.Module, dtype: torch.dtype) -> Run:
    """Return the default way: each image alone, channels last."""
    return lambda images: one_by_one(network, images.to(dtype))


def batched(network: torch.nn.Module, dtype: torch.dtype, size: int, order: torch.memory_format) -> Run:
    """Return a way with `size` images at a time, in a given memory order."""

    def run(images: Tensor) -> Tensor:
        parts = [part.to(dtype).contiguous(memory_format=order) for part in images.split(size)]
        return torch.cat([network(part).float() for part in parts])

    return run


def onnx_ways(network: torch.nn.Module, folder: Path) -> dict[str, Run]:
    """Return a network in ONNX Runtime, in fp32 and, if convolutional, in int8.

    int8 is calibrated on other pictures. Without the packages, neither.
    """
    if any(find_spec(name) is None for name in onnx_runtime.PACKAGES):
        return {}
    file, small = folder / "fp32.onnx", folder / "int8.onnx"
    onnx_runtime.translate(network, torch.zeros(1, 3, SIDE, SIDE), file)
    found = {"ONNX Runtime fp32": _each(file)}
    if not any(isinstance(module, torch.nn.Linear) for module in network.modules()):
        quantization = import_module("onnxruntime.quantization")
        quantization.quantize_static(file, small, _calibration(quantization), per_channel=True)
        found["ONNX Runtime int8"] = _each(small)
    return found


def _calibration(quantization: Any) -> Any:
    reader: Any = quantization.CalibrationDataReader

    class Reader(reader):  # type: ignore[misc]
        def __init__(self) -> None:
            self._left = iter(pictures(16, seed=1).split(1))

        def get_next(self) -> dict[str, Any] | None:
            image = next(self._left, None)
            return None if image is None else {"images": image.numpy()}

    return Reader()


def _each(file: Path) -> Run:
    one = onnx_runtime.running(file)
    return lambda images: torch.cat([one(image) for image in images.split(1)])


def pictures(count: int, seed: int) -> Tensor:
    """Return generated pictures (count, 3, 224, 224) of soft and fine structure, preprocessed."""
    random = np.random.default_rng(seed)
    encoder = load_encoder("efficientnet-lite0")
    found = []
    for number in range(count):
        coarse = 2 + 4 * (number % 8)
        layers = [
            np.asarray(
                Image.fromarray(random.integers(0, 256, (n, n, 3), dtype=np.uint8)).resize(
                    (SIDE, SIDE), Image.Resampling.BICUBIC
                ),
                dtype=np.float32,
            )
            for n in (coarse, 4 * coarse)
        ]
        mixed = (0.7 * layers[0] + 0.3 * layers[1]).astype(np.uint8)
        found.append(encoder.preprocess(Image.fromarray(mixed)))
    return torch.stack(found).contiguous()


def vit_b16() -> torch.nn.Module:
    """Return the image tower of CLIP ViT-B/16 with random weights of the published sizes."""
    from transformers import CLIPVisionConfig, CLIPVisionModelWithProjection

    torch.manual_seed(0)
    config = CLIPVisionConfig(
        hidden_size=768,
        intermediate_size=3072,
        num_attention_heads=12,
        num_hidden_layers=12,
        patch_size=16,
        projection_dim=512,
    )

    class Projected(torch.nn.Module):
        def __init__(self) -> None:
            super().__init__()
            self.tower = CLIPVisionModelWithProjection(config)

        def forward(self, images: Tensor) -> Tensor:
            embeds: Tensor = self.tower(pixel_values=images).image_embeds
            return embeds

    return Projected().eval()


def rn50(width: int = 64, blocks: tuple[int, ...] = (3, 4, 6, 3)) -> torch.nn.Module:
    """Return the image tower of CLIP RN50 with random weights under the published names."""
    from omnivat.encoders.clip_towers import Tower

    torch.manual_seed(0)
    state: dict[str, Tensor] = {}

    def conv(name: str, norm: str, out: int, into: int, kernel: int) -> None:
        spread = (2 / (into * kernel**2)) ** 0.5
        state[f"{name}.weight"] = torch.randn(out, into, kernel, kernel) * spread
        for part, value in (("weight", 1), ("bias", 0), ("running_mean", 0), ("running_var", 1)):
            state[f"{norm}.{part}"] = torch.full((out,), float(value))

    for i, (out, into) in enumerate(((width // 2, 3), (width // 2, width // 2), (width, width // 2))):
        conv(f"conv{i + 1}", f"bn{i + 1}", out, into, 3)
    into = width
    for stage, count in enumerate(blocks):
        middle = width * 2**stage
        for block in range(count):
            name = f"layer{stage + 1}.{block}"
            conv(f"{name}.conv1", f"{name}.bn1", middle, into, 1)
            conv(f"{name}.conv2", f"{name}.bn2", middle, middle, 3)
            conv(f"{name}.conv3", f"{name}.bn3", 4 * middle, middle, 1)
            state[f"{name}.bn3.weight"] *= 0.3  # otherwise the sums of the blocks diverge
            if block == 0:
                conv(f"{name}.downsample.0", f"{name}.downsample.1", 4 * middle, into, 1)
            into = 4 * middle
    state["attnpool.positional_embedding"] = torch.randn(50, into) / into**0.5
    for name in "qkvc":
        out = 1024 if name == "c" else into
        state[f"attnpool.{name}_proj.weight"] = torch.randn(out, into) / into**0.5
        state[f"attnpool.{name}_proj.bias"] = torch.zeros(out)
    return Tower(state).eval()
