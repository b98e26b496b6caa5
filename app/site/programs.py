"""Rules of the library that a page without a server needs, each as one ONNX file.

A program takes tensors and calls the functions of the library, which torch traces: a rule stands
once. `app/web/site/models.js` runs a program by its name, with arguments and results in order.
"""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import torch
from torch import Tensor, nn
from torch.export import Dim

from app.pair.tab import from_even
from omnivat.encoders.onnx_runtime import translate
from omnivat.head.calibration import nearest_cosines, quantile_of
from omnivat.kit.files import replacing

Results = tuple[Tensor, ...]


def look(row: Tensor, rows: Tensor, quantiles: Tensor) -> Results:
    """Return the cosine of an image (W,) to the nearest known one (N, W), and its quantile."""
    cosines = nearest_cosines(row[None], rows)
    return cosines[0, 0], quantile_of(cosines.mean(1), quantiles)[0]


def programs() -> dict[str, tuple[Callable[..., Results], tuple[Tensor, ...], tuple[Any, ...]]]:
    """Return name -> rule, examples of its arguments, and the axes of each that vary."""
    many, width, levels = (Dim(name) for name in ("many", "width", "levels"))
    row, rows, even = torch.rand(24), torch.rand(30, 24), torch.rand((), dtype=torch.float64)
    wide = {0: many, 1: width}
    return {
        "look": (look, (row, rows, torch.rand(11)), ({0: width}, wide, {0: levels})),
        "attention": (from_even, (rows, even), (wide, {})),
    }


class _Traced(nn.Module):
    def __init__(self, rule: Callable[..., Results]) -> None:
        super().__init__()
        self.rule = rule

    def forward(self, *given: Tensor) -> Results:
        return self.rule(*given)


def write_programs(folder: Path) -> None:
    """Write the programs as NAME.onnx.

    Raises MissingPackageError if a package of ONNX is not installed.
    """
    for name, (rule, example, lengths) in programs().items():
        with replacing(folder / f"{name}.onnx") as whole:
            translate(
                _Traced(rule),
                example,
                whole,
                input_names=[f"given{k}" for k in range(len(example))],
                dynamic_shapes=(lengths,),
            )
