"""Run a network in ONNX Runtime: fp32, faster on a CPU, different last digits."""

import logging
import math
import warnings
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import torch
from torch import Tensor, nn

from omnivat.kit.tables import need

PACKAGES = ("onnx", "onnxscript", "onnxruntime")
LARGE, LARGEST = 10_000, 200_000  # weights of a layer that has 14 bits, or 13


def in_onnx_runtime(network: nn.Module, example: Tensor) -> Callable[[Tensor], Tensor]:
    """Return a function that runs `network` on one image (1, 3, H, W), on one thread.

    The conversion at loading takes a few seconds and leaves nothing on disk. Several threads may
    call the function at once.

    Raises MissingPackageError if a package of ONNX is not installed.
    """
    with TemporaryDirectory() as folder:
        file = Path(folder) / "network.onnx"
        translate(network, example, file)
        return running(file)


def translate(
    network: nn.Module, example: Tensor | tuple[Tensor, ...], file: Path, **options: Any
) -> None:
    """Write `network` to one `file`; its inputs have the shapes of `example`.

    options  of torch.onnx.export; without them one input, images (1, 3, H, W)

    Raises MissingPackageError if a package of ONNX is not installed.
    """
    for name in PACKAGES:
        need(name, purpose="ONNX", install=" ".join(PACKAGES))
    given = (example,) if isinstance(example, Tensor) else example
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # warnings of torch's exporter about itself
        quiet = logging.getLogger("torch.onnx")
        before, quiet.level = quiet.level, logging.ERROR
        try:
            settings: dict[str, Any] = {"input_names": ["images"]} | options
            torch.onnx.export(
                network, given, file, dynamo=True, verbose=False, external_data=False, **settings
            )
        finally:
            quiet.level = before


def pack_weights(file: Path) -> None:
    """Keep the large weights of a network in 14 bits, the largest in 13: whole numbers, one scale
    for each output.

    The upper 8 bits and the others stand apart, so that gzip packs them well. Small weights, to
    which a network is more sensitive, stay as they are; it still computes in float32.
    """
    onnx = import_module("onnx")
    model = onnx.load(file)
    graph, nodes, floats = model.graph, [], onnx.TensorProto.FLOAT
    make, tensor = onnx.helper.make_node, onnx.numpy_helper.from_array
    large = [i for i in graph.initializer if i.data_type == floats and math.prod(i.dims) >= LARGE]
    for weight in large:
        values, name = onnx.numpy_helper.to_array(weight), weight.name
        top = np.abs(values).max(axis=tuple(range(1, values.ndim)), keepdims=True)
        rest = 5 if values.size >= LARGEST else 6  # bits beyond the upper 8
        scale = np.maximum(top, 1e-30).astype(np.float32) / (2 ** (7 + rest) - 1)
        upper, lower = np.divmod(np.rint(values / scale), 2**rest)
        graph.initializer.remove(weight)
        for part, whole, unit in (("upper", upper, 2**rest * scale), ("lower", lower, scale)):
            own = f"{name}/{part}"
            graph.initializer.append(tensor(whole.astype(np.int8), f"{own}/whole"))
            graph.initializer.append(tensor(unit, f"{own}/unit"))
            nodes.append(make("Cast", [f"{own}/whole"], [f"{own}/float"], to=floats))
            nodes.append(make("Mul", [f"{own}/float", f"{own}/unit"], [own]))
        nodes.append(make("Add", [f"{name}/upper", f"{name}/lower"], [name]))
    for node in reversed(nodes):
        graph.node.insert(0, node)
    del graph.value_info[:]
    onnx.save(model, file)


RESIZE = """
<ir_version: 9, opset_import: ["": 19]>
resize (uint8[1, H, W, 3] picture, int64[4] shape) => (uint8[1, h, w, 3] resized) {
  resized = Resize
    <mode = "cubic", cubic_coeff_a = -0.5, antialias = 1, exclude_outside = 1>
    (picture, , , shape)
}
"""


def write_resize(file: Path) -> None:
    """Write Pillow's bicubic `resize` as ONNX: a byte of the result differs from Pillow's by 1 at
    most.

    Inputs are a picture (1, H, W, 3) and the wanted shape (4,) int64; `resized` is (1, h, w, 3);
    pictures are uint8. Raises MissingPackageError if a package of ONNX is not installed.
    """
    onnx = need("onnx", purpose="ONNX", install=" ".join(PACKAGES))
    onnx.save(onnx.parser.parse_model(RESIZE), file)


def running(file: Path) -> Callable[[Tensor], Tensor]:
    """Return a function that runs the network in `file` on one image, on one thread."""
    runtime = import_module("onnxruntime")
    settings = runtime.SessionOptions()
    settings.intra_op_num_threads = settings.inter_op_num_threads = 1
    session = runtime.InferenceSession(file, settings, providers=["CPUExecutionProvider"])

    def run(image: Tensor) -> Tensor:
        return torch.from_numpy(session.run(None, {"images": image.contiguous().numpy()})[0])

    return run
