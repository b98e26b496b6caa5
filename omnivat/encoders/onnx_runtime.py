"""A network in ONNX Runtime: fp32 still, sooner on a CPU, other last digits than torch's."""

import logging
import warnings
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from tempfile import TemporaryDirectory

import torch
from torch import Tensor, nn

from omnivat.packages import need

PACKAGES = ("onnx", "onnxscript", "onnxruntime")


def in_onnx_runtime(network: nn.Module, example: Tensor) -> Callable[[Tensor], Tensor]:
    """Return what runs `network` on one image (1, 3, H, W), on one thread of its own.

    The network is translated when it is loaded, which takes some seconds, and nothing of that stays
    on disk. Several threads may call it at once.

    Raises MissingPackageError where a package of ONNX is not installed.
    """
    with TemporaryDirectory() as folder:
        file = Path(folder) / "network.onnx"
        translate(network, example, file)
        return running(file)


def translate(network: nn.Module, example: Tensor, file: Path) -> None:
    """Write `network` to `file`; its input takes the shape of `example`, one image (1, 3, H, W).

    Raises MissingPackageError where a package of ONNX is not installed.
    """
    for name in PACKAGES:
        need(name, purpose="precision fp32-onnx", install=" ".join(PACKAGES))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of torch's exporter, about its own parts
        quiet = logging.getLogger("torch.onnx")
        before, quiet.level = quiet.level, logging.ERROR
        try:
            torch.onnx.export(
                network, (example,), file, input_names=["images"], dynamo=True, verbose=False
            )
        finally:
            quiet.level = before


def running(file: Path) -> Callable[[Tensor], Tensor]:
    """Return what runs the network in `file` on one image (1, 3, H, W), on one thread."""
    runtime = import_module("onnxruntime")
    settings = runtime.SessionOptions()
    settings.intra_op_num_threads = settings.inter_op_num_threads = 1
    session = runtime.InferenceSession(file, settings, providers=["CPUExecutionProvider"])

    def run(image: Tensor) -> Tensor:
        return torch.from_numpy(session.run(None, {"images": image.contiguous().numpy()})[0])

    return run
