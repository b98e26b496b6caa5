"""Save and load a fitted baseline, without code in the file.

The prediction is traced into a graph of tensor operations (`torch.export`), weights inside. So every
method saves alike, whatever it fitted; loading needs neither the method nor its source.
"""

import json
import math
import warnings
import zipfile
from collections.abc import Callable
from dataclasses import asdict
from io import BytesIO
from pathlib import Path

import torch
from torch import Tensor, nn

from omnivat.baselines.contract import Fitted
from omnivat.baselines.live import ImageInput
from omnivat.errors import DataError
from omnivat.files import replacing

FORMAT = "omnivat-baseline-1"


class _Prediction(nn.Module):
    """A prediction as a module, for tracing."""

    def __init__(self, predict: Callable[[Tensor, Tensor], dict[str, Tensor]]) -> None:
        super().__init__()
        self._predict = predict

    def forward(self, vis: Tensor, tac: Tensor) -> dict[str, Tensor]:
        return self._predict(vis, tac)


def save_fitted(path: str | Path, fitted: Fitted, width: int) -> None:
    """Write a fitted method, completely or not at all; `width` is D of its embeddings.

    Of a method that takes images the file holds the towers, too.
    A method that cannot be traced for a batch of any size is traced for one pair.
    Raises DataError for one that cannot be traced at all.
    """
    prediction, one_by_one = _Prediction(fitted.predict), False
    given = fitted.images
    shape = (width,) if given is None else (3, given.side, given.side)
    try:
        graph = _traced(prediction, shape, pairs=3)
    except Exception:  # the tracer has a different error for each kind of code
        one_by_one = True
        try:
            graph = _traced(prediction, shape, pairs=1)
        except Exception as error:
            raise DataError(
                f"This method's prediction cannot be saved: {str(error)[:120]}"
            ) from error
    record = {
        "format": FORMAT,
        "width": width,
        "one_by_one": one_by_one,
        "chosen": fitted.chosen,
        "parameters": fitted.parameters,
        "images": None if given is None else asdict(given),
    }
    content = BytesIO()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # of tensors that share memory
        torch.export.save(graph, content, extra_files={"baseline.json": json.dumps(record)})
    with replacing(path) as temporary:
        temporary.write_bytes(content.getvalue())


def _traced(
    prediction: nn.Module, shape: tuple[int, ...], *, pairs: int
) -> torch.export.ExportedProgram:
    """Return the graph of a prediction: for one pair, or for a batch of any size."""
    rows = torch.linspace(-1, 1, pairs * math.prod(shape)).reshape(pairs, *shape)
    axis = {0: torch.export.Dim("pairs", min=1)}
    shapes = None if pairs == 1 else {"vis": axis, "tac": axis}
    with torch.no_grad():
        return torch.export.export(prediction, (rows, rows.flip(0)), dynamic_shapes=shapes)


def load_fitted(path: str | Path) -> Fitted:
    """Read a fitted method. Its features are the embeddings themselves.

    Raises DataError when the file is missing, damaged or of another kind.
    """
    file = Path(path)
    if not file.is_file() or not zipfile.is_zipfile(file):
        raise DataError(f"'{file}' is not a saved baseline; save one with `save_fitted`.")
    extra = {"baseline.json": ""}
    try:
        content = BytesIO(file.read_bytes())
        module = torch.export.load(content, extra_files=extra).module()
        record = json.loads(extra["baseline.json"])
    except Exception as error:
        raise DataError(f"'{file}' cannot be read as a saved baseline; save it again.") from error
    if record.get("format") != FORMAT:
        raise DataError(f"'{file}' is not a saved baseline ('{FORMAT}').")

    @torch.no_grad()
    def predict(vis: Tensor, tac: Tensor) -> dict[str, Tensor]:
        if not record["one_by_one"]:
            found: dict[str, Tensor] = module(vis, tac)
            return found
        each = [module(vis[i : i + 1], tac[i : i + 1]) for i in range(len(vis))]
        return {name: torch.cat([one[name] for one in each]) for name in each[0]}

    given = record.get("images")
    return Fitted(
        predict=predict,
        chosen=record["chosen"],
        parameters=record["parameters"],
        images=None
        if given is None
        else ImageInput(side=given["side"], mean=tuple(given["mean"]), std=tuple(given["std"])),
    )
