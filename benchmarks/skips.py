"""Time saved and error added by each rule that avoids work.

    python -m benchmarks.skips [--rounds 9] [--out docs/benchmarks/skips.md]

Every row times the work with and without the rule in interleaved rounds on the project's own head
and set, and compares the two answers. Starting a page is timed in fresh interpreters.
"""

import argparse
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from pathlib import Path
from statistics import median
from typing import Any

import torch
from torch import Tensor

from benchmarks._machine import Spread, interleaved
from benchmarks.measure import machine
from omnivat.data.store import load_embeddings
from omnivat.encoders import load_encoder
from omnivat.fractional import Coefficients, coefficients, dfrft, synthesise
from omnivat.head.checkpoint import load_head
from omnivat.head.head import OmniVaT
from omnivat.head.heads import default_embeddings, default_head
from omnivat.kit.stages import IMAGES
from omnivat.maps.projection import torch_umap
from omnivat.maps.projection.quality import drift, quality
from omnivat.measure.gaps.centroid import modality_gap

ORDERS = tuple(step / 10 for step in range(11))


@dataclass(frozen=True, slots=True)
class Rule:
    """The same result with and without a rule; `error` is the difference of the two."""

    name: str
    without: Callable[[], Any]
    skipping: Callable[[], Any]
    error: Callable[[], str]


def relative(a: Tensor, b: Tensor) -> str:
    """Return the largest difference of two tensors against the largest entry, as text."""
    return f"{float((a - b).abs().max() / b.abs().max()):.1e}"


def _special(embedded: Tensor, kept: Coefficients, order: float) -> str:
    return relative(dfrft(embedded, order), synthesise(kept, order + 1e-9))


def numeric(model: OmniVaT, vis: Tensor, tac: Tensor) -> Iterator[Rule]:
    """Yield the rules that skip products."""
    embedded = model.embedded({"vis": vis, "tac": tac})
    kept = coefficients(embedded)
    yield Rule(
        "p moves, embeddings do not: cached coefficients",
        lambda: dfrft(embedded, 0.37),
        lambda: synthesise(kept, 0.37),
        lambda: relative(synthesise(kept, 0.37), dfrft(embedded, 0.37)),
    )
    pairs = model.coefficients(vis, tac)

    def whole() -> Any:
        return model(vis, tac, order=0.37)

    yield Rule(
        "the same through the whole head",
        whole,
        lambda: model.from_coefficients(pairs, 0.37),
        lambda: relative(model.from_coefficients(pairs, 0.37).probabilities, whole().probabilities),
    )
    for order, what in ((0.0, "identity"), (1.0, "an FFT"), (2.0, "a reversal")):
        yield Rule(
            f"order {order:.0f} takes {what}",
            partial(synthesise, kept, order + 1e-9),
            partial(dfrft, embedded, order),
            partial(_special, embedded, kept, order),
        )
    features = model.from_coefficients(pairs, 0.37).f_bar
    root = features["vis"] + features["tac"]
    matrix, offset = model.dtg.fold()
    yield Rule(
        "DTG folds into one matrix; nodes only on request",
        lambda: model.dtg.grow(root).nodes.mean(1),
        lambda: torch.nn.functional.linear(root, matrix, offset),
        lambda: relative(torch.nn.functional.linear(root, matrix, offset), model.dtg.grow(root).nodes.mean(1)),
    )

    def gap_at(order: float) -> Tensor:
        planes = synthesise(kept, order, planar=True)  # (2, M, B, D)
        a, b = planes.movedim(0, 2).flatten(2)
        return modality_gap(a, b)

    def once() -> Tensor:
        return modality_gap(*embedded).expand(len(ORDERS))

    def every() -> Tensor:
        return torch.stack([gap_at(p) for p in ORDERS])

    yield Rule(
        "the raw transform is unitary: one gap for all p (11 orders)", every, once, lambda: relative(once(), every())
    )


def maps(model: OmniVaT, vis: Tensor, tac: Tensor) -> Rule:
    """Return the rule of the warm chain: six orders, each map started from the previous one."""
    pairs = model.coefficients(vis[::3], tac[::3])
    orders = [model.order + 0.005 * step for step in range(6)]
    rows = [
        torch.cat([out.f_hat[name] for name in IMAGES]) for out in (model.from_coefficients(pairs, p) for p in orders)
    ]

    def apart() -> list[Tensor]:
        return [torch_umap.project(points) for points in rows]

    def chained() -> list[Tensor]:
        return list(torch_umap.chain(rows))

    def error() -> str:
        one, other = apart(), chained()
        trust = [
            sum(quality(p, m, rows=len(p)).trustworthiness for p, m in zip(rows, made, strict=True)) / len(rows)
            for made in (one, other)
        ]
        moved = [sum(drift(a, b) for a, b in pairwise(made)) / (len(rows) - 1) for made in (one, other)]
        return f"trustworthiness {trust[0]:.3f} → {trust[1]:.3f}, drift {moved[0]:.2f} → {moved[1]:.2f}"

    return Rule("a map starts from its neighbour's (6 orders)", apart, chained, error)


def encoding() -> Rule:
    """Return the rule that an image is encoded once."""
    encoder = load_encoder("efficientnet-lite0")
    pixels = torch.rand(1, 3, 224, 224, generator=torch.Generator().manual_seed(0))
    pixels = (pixels * 255 - 127) / 128
    kept = encoder.embed(pixels)
    return Rule(
        "an image is encoded once, then looked up (in memory)",
        lambda: encoder.embed(pixels),
        kept.clone,
        lambda: relative(kept, encoder.embed(pixels)),
    )


def started(statement: str, rounds: int) -> Spread:
    """Return the milliseconds of CPU that fresh interpreters need for a statement."""
    code = f"import time; {statement}; print(time.process_time())"
    taken = []
    for _ in range(rounds + 1):
        done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
        taken.append(1e3 * float(done.stdout.split()[-1]))
    taken = taken[1:]  # the first fills the disk's cache
    return Spread(median(taken), min(taken), max(taken), len(taken))


def line(name: str, slow: Spread, fast: Spread, error: str) -> str:
    """Return a row of the table."""

    def text(spread: Spread) -> str:
        return f"{spread.median:.3g} ({spread.low:.3g} to {spread.high:.3g})"

    saved = slow.median / fast.median
    times = f"{saved:,.0f}×" if saved >= 10 else f"{saved:.1f}×"
    return f"| {name} | {text(slow)} | {text(fast)} | {times} | {error} |"


def main() -> None:
    """Time every rule and write the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=9)
    parser.add_argument("--out", type=Path, default=Path("docs/benchmarks/skips.md"))
    options = parser.parse_args()
    about = machine()
    model = load_head(default_head()).model.eval()
    embeddings = load_embeddings(default_embeddings())
    vis, tac = (torch.tensor(getattr(embeddings, name)).float() for name in IMAGES)
    lines = []
    with torch.no_grad():
        for rule in (*numeric(model, vis, tac), encoding()):
            found = interleaved({"a": rule.without, "b": rule.skipping}, options.rounds)
            lines.append(line(rule.name, found["a"], found["b"], rule.error()))
        rule = maps(model, vis, tac)
        found = interleaved({"a": rule.without, "b": rule.skipping}, 3)
        lines.append(line(rule.name, found["a"], found["b"], rule.error()))
    page = "from app.server import build; build()"
    heavy = "import torch, umap, plotly.graph_objects; from app.server import build; build()"
    slow, fast = started(heavy, 3), started(page, 3)
    lines.append(line("the first page loads no torch, umap or plotly (CPU time)", slow, fast, "none"))
    head = "| rule | without, ms | with, ms | saves | error |\n| --- | --- | --- | --- | --- |"
    text = (
        "# What is not computed\n\n"
        f"`python -m benchmarks.skips` on a {about['machine']}, shared, load {about['load']} before, "
        f"{about['threads']} threads, torch {about['torch']}; {len(embeddings):,} pairs, "
        f"D = {model.settings.width}. Median (lowest to highest) of {options.rounds} interleaved "
        "rounds (3 for maps and for starts). Error: largest difference between the two answers "
        "against the largest entry.\n\n" + "\n".join([head, *lines]) + "\n"
    )
    options.out.write_text(text, encoding="utf-8")
    print(text)


if __name__ == "__main__":
    before = time.perf_counter()
    main()
    print(f"{time.perf_counter() - before:.0f} s")
