"""A network in ONNX Runtime: fp32 still, sooner on a CPU, other last digits than torch's."""

import logging
import warnings
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory

import torch
from torch import Tensor, nn

from omnivat.packages import need

INSTALL = "onnx onnxscript onnxruntime"


def in_onnx_runtime(network: nn.Module, example: Tensor) -> Callable[[Tensor], Tensor]:
    """Return what runs `network` on one image (1, 3, H, W), on one thread of its own.

    The network is translated when it is loaded, which takes some seconds, and nothing of that stays
    on disk. Several threads may call it at once.

    Raises MissingPackageError where a package of ONNX is not installed.
    """
    for name in ("onnx", "onnxscript"):
        need(name, purpose="precision fp32-onnx", install=INSTALL)
    runtime = need("onnxruntime", purpose="precision fp32-onnx", install=INSTALL)
    settings = runtime.SessionOptions()
    settings.intra_op_num_threads = settings.inter_op_num_threads = 1
    with TemporaryDirectory() as folder:
        file = Path(folder) / "network.onnx"
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
        session = runtime.InferenceSession(file, settings, providers=["CPUExecutionProvider"])

    def run(image: Tensor) -> Tensor:
        return torch.from_numpy(session.run(None, {"images": image.contiguous().numpy()})[0])

    return run
