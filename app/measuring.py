"""Measure speed and error of the page's results on this machine, on request."""

import os
from collections.abc import Callable, Mapping
from time import perf_counter
from typing import TYPE_CHECKING, Any

from app.resources import Resources
from omnivat.kit.errors import DataError

if TYPE_CHECKING:
    from torch import Tensor

PAIRS = 1000  # of the set, at most
REPEATS = 7  # repetitions; median, minimum and maximum are shown
ORDER = 0.37  # not a special case of the transform


def measured(resources: Resources, question: Mapping[str, Any]) -> dict[str, Any]:
    """Time the transform and the head on part of the set, and compare with double precision.

    return  `rows`: name, milliseconds (median, minimum, maximum), error and its definition;
            numbers of pairs, width, threads and processors
    """
    if question:
        raise DataError("A measurement has no settings; send {}.")
    import copy

    import torch

    from omnivat.data.arrays import copied

    embeddings, head = resources.embeddings(), resources.head()
    head.require_embeddings(embeddings)
    vis, tac = (torch.from_numpy(copied(a[:PAIRS])) for a in (embeddings.vis, embeddings.tac))
    with torch.inference_mode():
        exact = copy.deepcopy(head.model).double()
        rows = [
            *transform_rows(head.model.embedded({"vis": vis})[0]),
            head_row(head.model, exact, vis, tac),
            stops_row(head.model, vis[:1], tac[:1]),
        ]
    return {
        "rows": rows,
        "pairs": len(vis),
        "width": head.settings.width,
        "repeats": REPEATS,
        "threads": torch.get_num_threads(),
        "processors": os.cpu_count(),
    }


def transform_rows(x: "Tensor") -> list[dict[str, Any]]:
    """Return the rows of the transform of x (B, D): in full, from coefficients, against FFT."""
    import torch

    from omnivat.fractional import coefficients, dfrft, synthesise

    wide = x.double()
    exact = dfrft(wide, ORDER)
    kept = coefficients(x)
    fourier = torch.fft.fft(wide, norm="ortho")
    near = dfrft(wide, 1 - 2**-48)  # order 1 itself is computed by the FFT
    single = "relative, of single against double precision"
    double = "relative, just below p = 1, against the fast Fourier transform"
    return [
        row("DFrFT of each VIS embedding, in full", lambda: dfrft(x, ORDER), error(dfrft(x, ORDER), exact), single),
        row(
            "DFrFT from kept coefficients, as p moves",
            lambda: synthesise(kept, ORDER),
            error(synthesise(kept, ORDER), exact),
            single,
        ),
        row("DFrFT in double precision", lambda: dfrft(wide, ORDER), error(near, fourier), double),
    ]


def head_row(model: Any, exact: Any, vis: "Tensor", tac: "Tensor") -> dict[str, Any]:
    """Return the row of the whole head at another p, with cached embeddings."""
    kept = model.coefficients(vis, tac)
    wanted = exact(vis.double(), tac.double(), order=ORDER).probabilities
    found = model.from_coefficients(kept, ORDER).probabilities
    difference, of = float((found - wanted).abs().max()), "largest difference of a probability from double precision"
    return row("whole head on all pairs, as p moves", lambda: model.from_coefficients(kept, ORDER), difference, of)


def stops_row(model: Any, vis: "Tensor", tac: "Tensor") -> dict[str, Any]:
    """Return the row of one pair at 101 stops in one batch, as in Try a pair."""
    import torch

    stops = torch.arange(101) / 100

    def at_once() -> "Tensor":
        kept = model.coefficients(vis, tac)[torch.zeros(101, dtype=torch.long)]
        probabilities: Tensor = model.from_coefficients(kept, stops).probabilities
        return probabilities

    single = torch.cat([model(vis, tac, order=float(p)).probabilities for p in stops[::10]])
    difference, of = (
        float((at_once()[::10] - single).abs().max()),
        "largest difference of a probability from single stops",
    )
    return row("one pair at 101 stops of p, in one batch", at_once, difference, of)


def row(what: str, work: Callable[[], Any], error: float, of: str) -> dict[str, Any]:
    """Return `what`, the milliseconds of `work` (median, minimum and maximum), and its error of the kind `of`."""
    work()  # the first call may build a basis
    times = []
    for _ in range(REPEATS):
        began = perf_counter()
        work()
        times.append(1000 * (perf_counter() - began))
    times.sort()
    ms = {"median": times[len(times) // 2], "least": times[0], "most": times[-1]}
    return {"what": what, "ms": {name: float(f"{value:.3g}") for name, value in ms.items()}, "error": error, "of": of}


def error(found: "Tensor", exact: "Tensor") -> float:
    """Return the relative error of a tensor against an exact one."""
    return float((found.to(exact.dtype) - exact).norm() / exact.norm())
