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
from torch.nn.functional import normalize

from app.pictures import STEPS, hidden, over_cells
from app.views.pair import from_even
from omnivat.data.profile import Channels, moved, pooled
from omnivat.encoders.onnx_runtime import translate
from omnivat.head.calibration import closest, nearest_cosines, quantile_of
from omnivat.head.output import READINGS, Lessons
from omnivat.head.portable import lessons
from omnivat.kit.files import replacing
from omnivat.maps.projection.neighbours import PLACED_BY, neighbour_shares

Results = tuple[Tensor, ...]


def look(row: Tensor, rows: Tensor, quantiles: Tensor) -> Results:
    """Return the cosine of an image (W,) to the nearest known one (N, W), and its quantile."""
    cosines = nearest_cosines(row[None], rows)
    return cosines[0, 0], quantile_of(cosines.mean(1), quantiles)[0]


def among(rows: Tensor) -> Results:
    """Return the quantiles (N,) of images (N, W) among the others."""
    units = normalize(rows, dim=-1)
    same = torch.eye(units.shape[0], dtype=torch.bool)
    return (closest(units, units, same).mean(1).sort().values,)


def join(mean: Tensor, variance: Tensor, count: Tensor, *other: Tensor) -> Results:
    """Return the statistics of two sets of pictures together, each mean, variance and count."""
    wide = (tensor.double() for tensor in (mean, variance, count, *other))
    mean, variance, count = pooled(*wide)
    return mean.float(), variance.float(), count


def move(row: Tensor, *statistics: Any) -> Results:
    """Return a row (W,) of a new sensor as the source has it.

    statistics  mean, variance and count of the sensor, the same of the source, and its step
    """
    *both, step = statistics
    target, source = (
        Channels(mean=mean, variance=variance, count=count)
        for mean, variance, count in (both[:3], both[3:])
    )
    rows: Any = row[None]
    found: Any = moved(rows, target, source, step)
    return (found[0],)


def taught(*given: Tensor) -> Results:
    """Return a taught head's READINGS (B, K).

    given  READINGS (B, known) before, VIS and TAC standardised (B, W), and what `lessons` gives:
           the map (K, 2 W), its bias (K,) and the share ()
    """
    *before, vis, tac, weights, bias, share = given
    rows = weights.unflatten(1, (2, -1)).transpose(0, 1)[None]
    known = (before[0].shape[1],)
    of = Lessons.of({"vis": vis, "tac": tac}, rows, bias[None], share[None], known)
    return tuple(of.added(name, rows) for name, rows in zip(READINGS, before, strict=True))


def place(query: Tensor, points: Tensor) -> Results:
    """Return the neighbours (k,) of a row (D,) among points (N, D), float64 and float32, and their
    shares in its place.
    """
    index, share = neighbour_shares(query[None], points.double())
    return index[0], share[0]


def drops(falls: Tensor) -> Results:
    """Return `over_cells` (CELLS, CELLS) of the parts (STEPS²,)."""
    return (over_cells(falls),)


def parts(picture: Tensor, colour: Tensor) -> Results:
    """Return the picture (1, H, W, 3) with each part `hidden` in turn, by a colour (1, 1, 1, 3)."""
    return (hidden(picture, colour),)


Varying = dict[int, Any]  # axis -> its length


def programs() -> dict[str, tuple[Callable[..., Results], tuple[Tensor, ...], tuple[Varying, ...]]]:
    """Return name -> rule, examples of its arguments, and their lengths that vary."""
    pairs, many, width, classes, known, levels = (
        Dim(name) for name in ("pairs", "many", "width", "classes", "known", "levels")
    )
    points = Dim("points", min=PLACED_BY + 1)

    def numbers(*shape: int) -> Tensor:  # no two are one tensor, which torch would take for one
        return torch.rand(shape, dtype=torch.float32 if shape else torch.float64)

    def statistics() -> tuple[Tensor, ...]:
        return numbers(24), numbers(24), numbers()

    free: tuple[Varying, ...] = ({0: width}, {0: width}, {})
    before: Varying = {0: pairs, 1: known}
    wide: Varying = {0: pairs, 1: width}
    wides = numbers(6, 8), numbers(6, 8)
    three, answers = ([numbers(6, 4) for _ in some] for some in (range(3), READINGS))
    return {
        "look": (
            look,
            (numbers(24), numbers(30, 24), numbers(11)),
            ({0: width}, {0: many, 1: width}, {0: levels}),
        ),
        "among": (among, (numbers(30, 24),), ({0: many, 1: width},)),
        "join": (join, (*statistics(), *statistics()), (*free, *free)),
        "move": (
            move,
            (numbers(24), *statistics(), *statistics(), numbers()),
            ({0: width}, *free, *free, {}),
        ),
        "lessons": (
            lessons,
            (*three, *wides, torch.ones(6, 2), torch.eye(6, 5)),
            (*[before] * 3, wide, wide, {0: pairs}, {0: pairs, 1: classes}),
        ),
        "taught": (
            taught,
            (*answers, *wides, numbers(5, 16), numbers(5), numbers(1)[0]),
            (*[before] * 5, wide, wide, {0: classes, 1: 2 * width}, {0: classes}, {}),
        ),
        "place": (
            place,
            (numbers(24).double(), numbers(30, 24)),
            ({0: width}, {0: points, 1: width}),
        ),
        "attention": (from_even, (numbers(3, 24), numbers()), ({0: many, 1: width}, {})),
        "drops": (drops, (numbers(STEPS**2),), ({},)),
        "parts": (
            parts,
            tuple(torch.ones(shape, dtype=torch.uint8) for shape in ((1, 30, 40, 3), (1, 1, 1, 3))),
            ({1: Dim("height"), 2: Dim("across")}, {}),
        ),
    }


class _Traced(nn.Module):
    def __init__(self, rule: Callable[..., Results]) -> None:
        super().__init__()
        self.rule = rule

    def forward(self, *given: Tensor) -> Results:
        return self.rule(*given)


def write_programs(folder: Path, *names: str) -> None:
    """Write programs, all if none is named, as NAME.onnx.

    Raises MissingPackageError if a package of ONNX is not installed.
    """
    for name, (rule, example, lengths) in programs().items():
        if names and name not in names:
            continue
        with replacing(folder / f"{name}.onnx") as whole:
            translate(
                _Traced(rule),
                example,
                whole,
                input_names=[f"given{k}" for k in range(len(example))],
                dynamic_shapes=(lengths,),
            )
