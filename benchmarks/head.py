"""The head on this machine: one pair, 2,000 pairs, an epoch of training, against a lower bound.

    python -m benchmarks.head [--runs 7] [--steps 30] [--threads N] [--out docs/benchmarks/head]

Embeddings are random with width 512 (times do not depend on their values), the head is untrained,
and flips come from two cached copies. The floor counts the operations of docs/method.md, "Folding",
at the best rate of a large float32 matrix product, by the wall clock and with the same threads,
measured right before and after. An epoch of 5,520 samples is 345 steps; `--steps` of them are timed
one by one, and the median is scaled.
"""

import argparse
import json
import statistics
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import torch

from benchmarks.measure import machine, timed
from benchmarks.sweep import made_embeddings
from omnivat.data.materials import MATERIALS
from omnivat.encoders.lang.bank import LangBank
from omnivat.head import reference
from omnivat.head.head import OmniVaT, build_head
from omnivat.head.settings import HeadSettings
from omnivat.kit.threads import LIGHT, one_thread
from omnivat.training import TrainSettings
from omnivat.training.batches import batches
from omnivat.training.steps import learn, make_optimiser

INPUT, PAIRS, EPOCH = 512, 2000, 5520
TARGETS = {  # seconds
    ("one pair", 512): 0.0015,
    ("2,000 pairs", 512): 0.4,
    ("epoch", 512): 12.0,
    ("epoch", 64): 2.0,
}


def wall_rate(width: int = 512, rows: int = 4096, runs: int = 15) -> float:
    """Return the best rate of (rows, width) @ (width, width), operations a second of wall time.

    It uses the threads of the timed calls: a rate per CPU second belongs to one core, and floors
    for two cores would be twice too high.
    """
    a, b, out = torch.randn(rows, width), torch.randn(width, width), torch.empty(rows, width)
    torch.mm(a, b, out=out)
    best = timed(lambda: torch.mm(a, b, out=out), runs).wall_low
    return 2 * rows * width**2 / best


class Seconds(NamedTuple):
    """Seconds of repeated calls."""

    wall: list[float]
    cpu: list[float]


def prediction_operations(model: OmniVaT) -> int:
    """Count the operations of one folded pair, from raw embeddings to classes.

    For each modality: projection, into the eigenbasis and out of it (a quarter split halves both:
    D² each and D² more for two parts), scores of two base vectors, values with the first layer,
    the second layer; the tree once.
    """
    settings = model.settings
    square = settings.width**2
    projection = 2 * settings.width * settings.input_width if settings.projects else 0
    modality = projection + 2 * square + 4 * square + 4 * settings.ffn_ratio * square
    return 2 * modality + 2 * square


def training_operations(model: OmniVaT) -> int:
    """Count the operations of one sample: forward, and twice that backward for trained weights.

    For LANG, VIS and TAC: projection, transform (no weights), keys and queries of two base
    vectors, values, both layers; LANG as a query; every matrix of the tree.
    """
    settings = model.settings
    square = settings.width**2
    projection = 2 * settings.width * settings.input_width if settings.projects else 0
    learned = 3 * (projection + (8 + 2 + 4 * settings.ffn_ratio) * square)
    learned += 2 * square + 2 * settings.edges * square
    return 3 * learned + 2 * 3 * 2 * square


def measured(call: Callable[[], Any], runs: int, scale: float = 1.0) -> Seconds:
    """Return the wall and CPU seconds of `runs` calls, times `scale`, after two uncounted ones."""
    wall, cpu = [], []
    for _ in range(runs + 2):
        before, cpu_before = time.perf_counter(), time.process_time()
        call()
        wall.append(scale * (time.perf_counter() - before))
        cpu.append(scale * (time.process_time() - cpu_before))
    return Seconds(wall[2:], cpu[2:])


def row(what: str, width: int, seconds: Seconds, operations: int, rate: float) -> dict[str, Any]:
    """Return one line of the report."""
    return {
        "what": what,
        "width": width,
        "runs": len(seconds.wall),
        "wall": statistics.median(seconds.wall),
        "wall_low": min(seconds.wall),
        "wall_high": max(seconds.wall),
        "cpu": statistics.median(seconds.cpu),
        "cpu_low": min(seconds.cpu),
        "cpu_high": max(seconds.cpu),
        "target": TARGETS.get((what, width)),
        "floor": operations / rate,
        "rate": rate,
    }


@torch.inference_mode()
def predictions(width: int, runs: int) -> list[dict[str, Any]]:
    """Time prediction from raw embeddings, and check it against the reference."""
    settings = HeadSettings(classes=MATERIALS, input_width=INPUT, lang_width=INPUT, width=width)
    model = build_head(settings).eval()
    random = torch.Generator().manual_seed(0)
    vis, tac = (torch.randn(PAIRS, INPUT, generator=random) for _ in range(2))
    folded = model(vis[:50], tac[:50]).probabilities
    plain = reference.predict(model, {"vis": vis[:50], "tac": tac[:50]}).probabilities
    torch.testing.assert_close(plain, folded, atol=1e-6, rtol=0)
    before, each = wall_rate(), prediction_operations(model)
    one = measured(lambda: model(vis[:1], tac[:1]).probabilities, 30 * runs)
    many = measured(lambda: model(vis, tac).probabilities, runs)
    rate = max(before, wall_rate())
    return [row("one pair", width, one, each, rate), row("2,000 pairs", width, many, PAIRS * each, rate)]


def epoch(width: int, steps: int) -> dict[str, Any]:
    """Time steps of training, data included, and scale their median to an epoch."""
    settings = HeadSettings(classes=MATERIALS, input_width=INPUT, lang_width=INPUT, width=width)
    chosen = TrainSettings()
    source = made_embeddings(chosen.batch * (steps + 3))
    source = replace(source, vis_flip=source.vis + 0.1, tac_flip=source.tac + 0.1)
    random = np.random.default_rng(0)
    texts = random.normal(size=(len(MATERIALS), 80, INPUT)).astype(np.float32)
    bank = LangBank(embeddings=texts, classes=MATERIALS, origin="random")
    model = build_head(settings).train()
    optimiser = make_optimiser(model, chosen)
    everything = np.arange(len(source))
    stream = iter(batches(source, source.label, everything, bank, chosen, 0))
    scale, before = EPOCH / chosen.batch, wall_rate()
    with one_thread(width <= LIGHT):
        seconds = measured(lambda: learn(model, optimiser, next(stream), chosen), steps, scale)
    rate = max(before, wall_rate())
    return row("epoch", width, seconds, EPOCH * training_operations(model), rate)


def show(report: dict[str, Any]) -> str:
    """Return the report as a page."""
    facts = report["machine"]
    lines = [
        "# The head: time against the floor",
        "",
        "`python -m benchmarks.head`",
        "",
        f"{facts['machine']}, shared, load {facts['load']}, {facts['threads']} thread(s), torch "
        f"{facts['torch']}, float32. Median (lowest to highest) of wall and of CPU time: where "
        "the load is above the number of cores, wall time says more about the neighbours. Floor: the operations "
        "that folding leaves over, at the best rate by the wall clock of a 4096×512×512 product with "
        "the same threads, measured before and after. One pair, and training at D = 64, keep to "
        "one thread: sharing out so little work costs more than it saves.",
        "",
        "| what | D | runs | wall | CPU | target, wall, 2 cores | product rate | floor | floor / lowest wall |",
        "| --- | --- | --- | --- | --- | --- | --- | --- | --- |",
    ]
    for r in report["rows"]:
        target = "" if r["target"] is None else _time(r["target"])
        lines.append(
            f"| {r['what']} | {r['width']} | {r['runs']} | {_spread(r, 'wall')} "
            f"| {_spread(r, 'cpu')} | {target} | {r['rate'] / 1e9:.0f} GFLOP/s "
            f"| {_time(r['floor'])} | {r['floor'] / r['wall_low']:.0%} |"
        )
    lines += [
        "",
        "An epoch is 5,520 samples in batches of 16 from cached embeddings, encoders not included.",
        "",
        "**What limits it.** One pair: reading 11 MB of folded weights at D = 512, and about a "
        "hundred calls into torch. 2,000 pairs: matrix products, then the element-wise passes "
        "between them. Full training: products with 16 to 96 rows, which read more weights than "
        "they use, and the passes over 4.5 M parameters and gradients of clipping and SGD; rows "
        "of LANG, VIS and TAC meet in one product for each weight's gradient. Light training: "
        "the number of calls, not their work.",
    ]
    return "\n".join(lines) + "\n"


def _spread(line: dict[str, Any], kind: str) -> str:
    low, high = _time(line[f"{kind}_low"]), _time(line[f"{kind}_high"])
    return f"{_time(line[kind])} ({low} to {high})"


def _time(seconds: float) -> str:
    return f"{seconds:.1f} s" if seconds >= 1 else f"{seconds * 1e3:.3g} ms"


def main() -> None:
    """Measure, print, and write JSON and page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=7)
    parser.add_argument("--steps", type=int, default=30)
    parser.add_argument("--threads", type=int, help="for matrix products; torch's choice if left")
    parser.add_argument("--out", type=Path, default=Path("docs/benchmarks/head"))
    arguments = parser.parse_args()
    if arguments.threads:
        torch.set_num_threads(arguments.threads)
    rows = [line for width in (512, 64) for line in predictions(width, arguments.runs)]
    rows += [epoch(width, arguments.steps) for width in (512, 64)]
    report = {"machine": machine(), "rows": rows}
    arguments.out.parent.mkdir(parents=True, exist_ok=True)
    arguments.out.with_suffix(".json").write_text(json.dumps(report, indent=1) + "\n", encoding="utf-8")
    page = show(report)
    arguments.out.with_suffix(".md").write_text(page, encoding="utf-8")
    print(page)


if __name__ == "__main__":
    main()
