"""Time an image against the error of its embedding, for each way to run an encoder.

`python -m benchmarks.encoders --out docs/benchmarks` writes encoders.json, encoders.svg and
encoders.md. Each way runs one image on one thread, as the embedding engine does; the ways take
turns, so that a busy moment of the machine meets all of them. Processor time is the figure to
compare on a shared machine. The error is 1 - cosine to fp32 over generated pictures.

EfficientNet-Lite0 has its published weights. CLIP's towers have random weights of the published
sizes: their times are those of the real ones, their errors only a hint. ONNX Runtime joins in where
`onnx`, `onnxscript` and `onnxruntime` are installed.
"""

import argparse
import json
import logging
import statistics
import tempfile
import time
import warnings
from collections.abc import Callable, Iterator
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import torch
from PIL import Image
from torch import Tensor

from benchmarks.encoders_plot import plot, table
from benchmarks.measure import machine
from omnivat.encoders import load_encoder
from omnivat.encoders.running import placed

Run = Callable[[Tensor], Tensor]
SIDE = 224


def main() -> None:
    """Measure every way and write the figures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, required=True, help="folder for the three files")
    parser.add_argument("--rounds", type=int, default=9)
    parser.add_argument("--pictures", type=int, default=24)
    options = parser.parse_args()
    torch.set_num_threads(1)
    logging.disable(logging.WARNING)
    warnings.simplefilter("ignore")
    rows = []
    with tempfile.TemporaryDirectory() as folder, torch.inference_mode():
        for network, ways in networks(Path(folder)):
            rows += measured(network, ways, pictures(options.pictures, seed=0), options.rounds)
    found = {"machine": machine(), "rounds": options.rounds, "rows": rows}
    options.out.mkdir(parents=True, exist_ok=True)
    (options.out / "encoders.json").write_text(json.dumps(found, indent=2) + "\n")
    (options.out / "encoders.svg").write_text(plot(rows))
    (options.out / "encoders.md").write_text(table(found))


def networks(folder: Path) -> Iterator[tuple[str, dict[str, Run]]]:
    """Give each network with the ways to run it; the first way is the reference."""
    lite = {kind: load_encoder("efficientnet-lite0", precision=kind).embed for kind in kinds()}
    yield "EfficientNet-Lite0", lite | batched() | onnx_ways(folder)
    for name, towers in (("CLIP RN50 (random)", rn50), ("CLIP ViT-B/16 (random)", vit_b16)):
        yield name, towers()


def kinds() -> list[str]:
    """Return the precisions that this CPU has."""
    return ["fp32", "bf16"] if torch.ops.mkldnn._is_mkldnn_bf16_supported() else ["fp32"]


def batched() -> dict[str, Run]:
    """Return the batched product that the encoders do without, to see what that costs."""
    network: Run = load_encoder("efficientnet-lite0")._network  # type: ignore[attr-defined]
    order = torch.channels_last

    def sixteen(image: Tensor) -> Tensor:
        return network(image.expand(16, -1, -1, -1).contiguous(memory_format=order))[:1]

    return {"fp32, batch of 16": sixteen}


def in_precisions(tower: torch.nn.Module) -> dict[str, Run]:
    """Return a tower in each precision. The tower itself stays as it is."""
    from copy import deepcopy

    ways: dict[str, Run] = {}
    for kind in kinds():
        dtype = {"fp32": torch.float32, "bf16": torch.bfloat16}[kind]
        network = placed(deepcopy(tower), torch.device("cpu"), dtype)

        def way(image: Tensor, network: Run = network, dtype: torch.dtype = dtype) -> Tensor:
            return network(image.to(dtype, memory_format=torch.channels_last)).float()

        ways[kind] = way
    return ways


def rn50() -> dict[str, Run]:
    """Return CLIP RN50 with random weights of the published sizes."""
    from omnivat.encoders.clip_resnet import Tower

    return in_precisions(Tower(random_rn50()))


def random_rn50(width: int = 64, blocks: tuple[int, ...] = (3, 4, 6, 3)) -> dict[str, Tensor]:
    """Return random weights under the names of the published RN50."""
    torch.manual_seed(0)
    state: dict[str, Tensor] = {}

    def conv(name: str, norm: str, out: int, into: int, kernel: int) -> None:
        spread = (2 / (into * kernel**2)) ** 0.5
        state[f"{name}.weight"] = torch.randn(out, into, kernel, kernel) * spread
        for part, value in (("weight", 1), ("bias", 0), ("running_mean", 0), ("running_var", 1)):
            state[f"{norm}.{part}"] = torch.full((out,), float(value))

    for i, (out, into) in enumerate(
        ((width // 2, 3), (width // 2, width // 2), (width, width // 2))
    ):
        conv(f"conv{i + 1}", f"bn{i + 1}", out, into, 3)
    into = width
    for stage, count in enumerate(blocks):
        middle = width * 2**stage
        for block in range(count):
            name = f"layer{stage + 1}.{block}"
            conv(f"{name}.conv1", f"{name}.bn1", middle, into, 1)
            conv(f"{name}.conv2", f"{name}.bn2", middle, middle, 3)
            conv(f"{name}.conv3", f"{name}.bn3", 4 * middle, middle, 1)
            state[f"{name}.bn3.weight"] *= 0.3  # or the sums of the blocks grow without end
            if block == 0:
                conv(f"{name}.downsample.0", f"{name}.downsample.1", 4 * middle, into, 1)
            into = 4 * middle
    state["attnpool.positional_embedding"] = torch.randn(50, into) / into**0.5
    for name in "qkvc":
        out = 1024 if name == "c" else into
        state[f"attnpool.{name}_proj.weight"] = torch.randn(out, into) / into**0.5
        state[f"attnpool.{name}_proj.bias"] = torch.zeros(out)
    return state


def vit_b16() -> dict[str, Run]:
    """Return CLIP ViT-B/16 with random weights of the published sizes; none without its package."""
    if find_spec("transformers") is None:
        return {}
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

        def forward(self, image: Tensor) -> Tensor:
            embeds: Tensor = self.tower(pixel_values=image).image_embeds
            return embeds

    return in_precisions(Projected())


def onnx_ways(folder: Path) -> dict[str, Run]:
    """Return EfficientNet-Lite0 in ONNX Runtime, in fp32 and int8; none without its packages."""
    if any(find_spec(name) is None for name in ("onnx", "onnxscript", "onnxruntime")):
        return {}
    onnxruntime = import_module("onnxruntime")
    quantization = import_module("onnxruntime.quantization")
    reader: Any = quantization.CalibrationDataReader

    encoder: Any = load_encoder("efficientnet-lite0")
    file, small = folder / "fp32.onnx", folder / "int8.onnx"
    example = torch.zeros(1, 3, SIDE, SIDE)
    torch.onnx.export(encoder._network, (example,), file, dynamo=True, verbose=False)

    class Reader(reader):  # type: ignore[misc]
        def __init__(self) -> None:
            self._left = iter(pictures(16, seed=1))

        def get_next(self) -> dict[str, Any] | None:
            image = next(self._left, None)
            return None if image is None else {"x": image.numpy()}

    quantization.quantize_static(file, small, Reader(), per_channel=True)
    settings = onnxruntime.SessionOptions()
    settings.intra_op_num_threads = settings.inter_op_num_threads = 1

    def way(path: Path) -> Run:
        session = onnxruntime.InferenceSession(path, settings)
        return lambda image: torch.from_numpy(session.run(None, {"x": image.numpy()})[0])

    return {"ONNX Runtime fp32": way(file), "ONNX Runtime int8": way(small)}


def pictures(count: int, seed: int) -> list[Tensor]:
    """Return generated pictures (1, 3, 224, 224) of soft and fine structure, preprocessed."""
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
        found.append(encoder.preprocess(Image.fromarray(mixed))[None].contiguous())
    return found


def measured(
    network: str, ways: dict[str, Run], images: list[Tensor], rounds: int
) -> list[dict[str, Any]]:
    """Return a row for each way: milliseconds an image and the error against the first way."""
    embedded = {name: torch.cat([way(image) for image in images]) for name, way in ways.items()}
    times: dict[str, list[tuple[float, float]]] = {name: [] for name in ways}
    for _ in range(rounds):
        for name, way in ways.items():
            count = 16 if "batch" in name else 1
            times[name].append(timed(way, images[:4], 4 * count))
    reference = embedded[next(iter(ways))] if ways else torch.empty(0)
    return [
        {"network": network, "way": name, **spread(times[name]), **error(embedded[name], reference)}
        for name in ways
    ]


def timed(way: Run, images: list[Tensor], count: int) -> tuple[float, float]:
    """Return processor and wall milliseconds an image."""
    cpu, wall = time.process_time(), time.perf_counter()
    for image in images:
        way(image)
    return (
        1e3 * (time.process_time() - cpu) / count,
        1e3 * (time.perf_counter() - wall) / count,
    )


def spread(times: list[tuple[float, float]]) -> dict[str, float]:
    """Return median, lowest and highest of both clocks."""
    found = {}
    for name, values in zip(("cpu", "wall"), zip(*times, strict=True), strict=True):
        found[f"{name}_ms"] = round(statistics.median(values), 2)
        found[f"{name}_low"], found[f"{name}_high"] = round(min(values), 2), round(max(values), 2)
    return found


def error(embedded: Tensor, reference: Tensor) -> dict[str, float]:
    """Return 1 - cosine to the reference: the median picture and the worst."""
    away = 1 - torch.cosine_similarity(embedded.double(), reference.double())
    return {"error": away.median().clamp(min=0).item(), "error_worst": max(away.max().item(), 0.0)}


if __name__ == "__main__":
    main()
