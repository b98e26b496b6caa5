"""One head for every order, against separate heads trained at each stop.

    python -m benchmarks.studies.order_every [--sources TAG-sim,...] [--widths 64] [--seeds 1]
                                     [--steps 3000] [--draw row] [--only alone,noisy,plain,every]
                                     [--stops 0,0.25,...] [--jobs N] [--out FILE] [--table]

The head for every order draws a random p (`order_draw`) and trains for `--steps` steps with the
settings EVERY. "every" learns the mean logits of four teachers, "plain" the labels, without LANG.
Heads at a stop train for 60 epochs with the usual settings ("alone"), or as the head of the page
does ("noisy"). Averages are over 11 orders from 0 to 1. A row of the JSON lines file is one seed of
one source and width; finished rows are kept. --table prints them.
"""

import argparse
import json
import time
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from math import ceil
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray

from benchmarks.studies._order_runs import SENSORS, carried_out, head_at, labels_of, scored
from omnivat.data.store import Embeddings, load_embeddings
from omnivat.head.head import OmniVaT
from omnivat.head.heads import default_embeddings
from omnivat.measure.evaluate import predicted_probabilities
from omnivat.measure.unseen import counted, mean_over_domains
from omnivat.training import TrainSettings, train
from omnivat.training.from_pairs import plan_training

# helpful settings (docs/order.md): noise, large steps, orders slightly beyond [0, 1]
EVERY = TrainSettings(batch=64, lr=0.1, noise=2.0, order_low=-0.1, order_high=1.1)
# heads at a stop: the usual settings, and those of the page's head
AT_STOPS = {"alone": SENSORS, "noisy": replace(SENSORS, noise=2.0, epochs=120)}
TEACHERS = {"plain": 0, "every": 4}  # of one head for every order
KINDS = (*AT_STOPS, *TEACHERS)
AVERAGED = tuple(float(p) for p in np.linspace(0, 1, 11))
STOPS = "0,0.25,0.5,0.75,1"
Row = dict[str, Any]
NAMED = ("kind", "source", "width", "seed", "steps", "draw", "stops")  # key of a row


def at_stops(
    embeddings: Embeddings, source: str, width: int, seed: int, stops: Sequence[float], training: TrainSettings
) -> Row:
    """Train a head at each stop; return their accuracies (%)."""
    began = time.process_time()
    heads = [head_at(embeddings, source, p, seed, training, {"width": width}) for p in stops]
    cpu = time.process_time() - began
    found = [scored(head, embeddings, source) for head in heads]
    return {
        "unseen": [score.unseen for score in found],
        "source_test": [score.source_test for score in found],
        "cpu_s": round(cpu, 1),
    }


def one_head(
    embeddings: Embeddings, source: str, width: int, seed: int, stops: Sequence[float], training: TrainSettings
) -> Row:
    """Train one head for every order; return its accuracies (%) at the stops, and averaged."""
    plan = plan_training(embeddings, source, head={"width": width}, training=training)
    began = time.process_time()
    model = train(plan.pairs, plan.settings, plan.training, bank=plan.bank, seed=seed).model
    cpu = time.process_time() - began
    found = [scored(model, embeddings, source, p) for p in stops]
    return {
        "unseen": [score.unseen for score in found],
        "source_test": [score.source_test for score in found],
        "averaged": averaged(model, embeddings, source),
        "single": float(np.mean([scored(model, embeddings, source, p).unseen for p in AVERAGED])),
        "cpu_s": round(cpu, 1),
    }


def every_settings(pairs: int, steps: int, draw: str, teachers: int) -> TrainSettings:
    """Return the settings of a head for every order; LANG serves the teachers alone."""
    epochs = round(steps / ceil(pairs / EVERY.batch))
    return replace(EVERY, epochs=epochs, order_draw=draw, order_teachers=teachers, lang=teachers > 0)


def averaged(model: OmniVaT, embeddings: Embeddings, source: str) -> float:
    """Return the accuracy (%) of predictions averaged over orders."""
    each = [predicted_probabilities(model, embeddings, order=p)["fused"] for p in AVERAGED]
    shares = torch.stack(each).mean(0)
    right = shares.argmax(1).numpy() == labels_of(model, embeddings)
    keep = counted(embeddings, source)
    return 100 * (mean_over_domains(right, embeddings, source, keep) or float("nan"))


def made(file: Path, kind: str, source: str, width: int, seed: int, steps: int, draw: str, stops: str) -> Row:
    """Return a complete row: its key and its results."""
    places = tuple(map(float, stops.split(",")))
    known = dict(zip(NAMED, (kind, source, width, seed, steps, draw, stops), strict=True))
    embeddings = load_embeddings(file)
    if kind in AT_STOPS:
        return known | at_stops(embeddings, source, width, seed, places, AT_STOPS[kind])
    pairs = len(embeddings.in_domain(source, split="train"))
    training = every_settings(pairs, steps, draw, TEACHERS[kind])
    return known | one_head(embeddings, source, width, seed, places, training)


def compared(rows: Sequence[Row], width: int) -> list[Row]:
    """Return for each source of a width the means over seeds (S,) of every kind, by name."""
    found = []
    for source in dict.fromkeys(row["source"] for row in rows if row["width"] == width):
        own = [row for row in rows if (row["source"], row["width"]) == (source, width)]
        means = {
            kind: np.mean([row["unseen"] for row in own if row["kind"] == kind], axis=0)
            for kind in KINDS
            if any(row["kind"] == kind for row in own)
        }
        if {"alone", "every"} <= set(means):
            gains = [row["averaged"] - row["single"] for row in own if row["kind"] == "every"]
            found.append({"source": source, **means, "averaging": float(np.mean(gains))})
    return found


def table(rows: Sequence[Row]) -> str:
    """Return all kinds of head side by side, in Markdown."""
    lines = []
    for width in sorted({row["width"] for row in rows}):
        lines += [
            f"\nD = {width}\n",
            "| source | at each stop | ... with noise | one head, labels | one head, teachers "
            "| less at each stop: mean, worst | less with noise: mean, worst | averaging |",
            "| --- | --- | --- | --- | --- | --- | --- | --- |",
        ]
        for one in compared(rows, width):
            means = " | ".join(_means(one.get(kind)) for kind in KINDS)
            less = " | ".join(_less(one["every"], one.get(kind)) for kind in ("alone", "noisy"))
            lines.append(f"| {one['source']} | {means} | {less} | {one['averaging']:+.1f} |")
    return "\n".join(lines)


def _means(values: NDArray[np.float64] | None) -> str:
    """Return the mean over stops with the lowest and the highest."""
    if values is None:
        return "–"
    return f"{values.mean():.1f} ({values.min():.1f}-{values.max():.1f})"


def _less(values: NDArray[np.float64], others: NDArray[np.float64] | None) -> str:
    """Return the mean difference over stops and the lowest one."""
    if others is None:
        return "–"
    return f"{(values - others).mean():+.1f}, {(values - others).min():+.1f}"


def main() -> None:
    """Make the missing rows, or print the existing ones."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--embeddings", type=Path, default=default_embeddings())
    parser.add_argument("--sources", help="with commas; all domains if left out")
    parser.add_argument("--widths", default="64")
    parser.add_argument("--seeds", type=int, default=1)
    parser.add_argument("--steps", type=int, default=3000)
    parser.add_argument("--draw", choices=["batch", "row"], default="row")
    parser.add_argument("--only", help=f"kinds with commas; {', '.join(KINDS)} if left out")
    parser.add_argument("--stops", default=STOPS)
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--out", type=Path, default=Path("docs/benchmarks/order_every.jsonl"))
    parser.add_argument("--table", action="store_true")
    options = parser.parse_args()
    there = rows_of(options.out)
    if options.table:
        return print(table(there))
    domains = load_embeddings(options.embeddings).header.domains
    known = {tuple(row[name] for name in NAMED) for row in there}
    jobs = [
        job
        for width in map(int, options.widths.split(","))
        for seed in range(options.seeds)
        for source in (options.sources.split(",") if options.sources else domains)
        for kind in (options.only.split(",") if options.only else KINDS)
        if (job := _job(kind, source, width, seed, options)) not in known
    ]
    for row in carried_out(partial(made, options.embeddings), jobs, options.jobs):
        with options.out.open("a", encoding="utf-8") as handle:
            handle.write(json.dumps(row) + "\n")
        print(json.dumps(row), flush=True)
    return None


def _job(kind: str, source: str, width: int, seed: int, options: argparse.Namespace) -> tuple[Any, ...]:
    own = (options.steps, options.draw) if kind in TEACHERS else (0, "none")
    return (kind, source, width, seed, *own, options.stops)


def rows_of(file: Path) -> list[Row]:
    """Return the rows of a JSON lines file; none if it is missing."""
    if not file.is_file():
        return []
    return [json.loads(line) for line in file.read_text(encoding="utf-8").splitlines()]


if __name__ == "__main__":
    main()
