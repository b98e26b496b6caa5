"""Run a network in ONNX Runtime: fp32, faster on a CPU, different last digits."""

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
    """Return a function that runs `network` on one image (1, 3, H, W), on one thread.

    The conversion at loading takes a few seconds and leaves nothing on disk. Several threads may
    call the function at once.

    Raises MissingPackageError if a package of ONNX is not installed.
    """
    with TemporaryDirectory() as folder:
        file = Path(folder) / "network.onnx"
        translate(network, example, file)
        return running(file)


def translate(network: nn.Module, example: Tensor, file: Path) -> None:
    """Write `network` to `file`; its input has the shape of `example`, one image (1, 3, H, W).

    Raises MissingPackageError if a package of ONNX is not installed.
    """
    for name in PACKAGES:
        need(name, purpose="precision fp32-onnx", install=" ".join(PACKAGES))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # warnings of torch's exporter about itself
        quiet = logging.getLogger("torch.onnx")
        before, quiet.level = quiet.level, logging.ERROR
        try:
            torch.onnx.export(
                network, (example,), file, input_names=["images"], dynamo=True, verbose=False
            )
        finally:
            quiet.level = before


def running(file: Path) -> Callable[[Tensor], Tensor]:
    """Return a function that runs the network in `file` on one image, on one thread."""
    runtime = import_module("onnxruntime")
    settings = runtime.SessionOptions()
    settings.intra_op_num_threads = settings.inter_op_num_threads = 1
    session = runtime.InferenceSession(file, settings, providers=["CPUExecutionProvider"])

    def run(image: Tensor) -> Tensor:
        return torch.from_numpy(session.run(None, {"images": image.contiguous().numpy()})[0])

    return run
