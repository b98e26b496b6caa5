"""One head for every order, against separate heads trained at each stop.

    python -m benchmarks.order_every [--sources TAG-sim,...] [--widths 64] [--seeds 1]
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
from numpy.typing import NDArray

from benchmarks._order_runs import SENSORS, carried_out, head_at, labels_of, scored
from omnivat.averaged import averaged_probabilities
from omnivat.data.store import Embeddings, load_embeddings
from omnivat.from_pairs import plan_training
from omnivat.heads import default_embeddings
from omnivat.model.head import OmniVaT
from omnivat.train import TrainSettings, train
from omnivat.unseen.masks import counted, mean_over_domains

# helpful settings (docs/order.md): noise, large steps, orders slightly beyond [0, 1]
EVERY = TrainSettings(batch=64, lr=0.1, noise=2.0, order_low=-0.1, order_high=1.1)
NOISY = replace(SENSORS, noise=2.0, epochs=120)  # those of the page's head
AVERAGED = tuple(float(p) for p in np.linspace(0, 1, 11))
STOPS = "0,0.25,0.5,0.75,1"
Row = dict[str, Any]
NAMED = ("kind", "source", "width", "seed", "steps", "draw", "stops")  # key of a row


def alone(
    file: Path, source: str, width: int, seed: int, steps: int, draw: str, stops: Sequence[float]
) -> Row:
    """Train a head at each stop; return their accuracies (%). Steps and draw do not apply."""
    return _at_stops(file, source, width, seed, stops, SENSORS)


def noisy(
    file: Path, source: str, width: int, seed: int, steps: int, draw: str, stops: Sequence[float]
) -> Row:
    """The same, with the settings of the page's head: noise on the embeddings, 120 epochs."""
    return _at_stops(file, source, width, seed, stops, NOISY)


def _at_stops(
    file: Path, source: str, width: int, seed: int, stops: Sequence[float], training: TrainSettings
) -> Row:
    embeddings = load_embeddings(file)
    began = time.process_time()
    heads = [head_at(embeddings, source, p, seed, training, {"width": width}) for p in stops]
    cpu = time.process_time() - began
    found = [scored(head, embeddings, source) for head in heads]
    return {
        "unseen": [score.unseen for score in found],
        "source_test": [score.source_test for score in found],
        "cpu_s": round(cpu, 1),
    }


def every(
    file: Path, source: str, width: int, seed: int, steps: int, draw: str, stops: Sequence[float]
) -> Row:
    """Train one head for every order, with teachers; return its accuracies (%)."""
    return _one_head(file, source, width, seed, steps, draw, stops, teachers=4)


def plain(
    file: Path, source: str, width: int, seed: int, steps: int, draw: str, stops: Sequence[float]
) -> Row:
    """The same without teachers and LANG."""
    return _one_head(file, source, width, seed, steps, draw, stops, teachers=0)


def _one_head(
    file: Path,
    source: str,
    width: int,
    seed: int,
    steps: int,
    draw: str,
    stops: Sequence[float],
    *,
    teachers: int,
) -> Row:
    """Return the accuracies (%) of one head at the stops, and averaged."""
    embeddings = load_embeddings(file)
    count = len(embeddings.in_domain(source, split="train"))
    epochs = round(steps / ceil(count / EVERY.batch))
    training = replace(
        EVERY, epochs=epochs, order_draw=draw, order_teachers=teachers, lang=teachers > 0
    )
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


KINDS = {"alone": alone, "noisy": noisy, "plain": plain, "every": every}


def averaged(model: OmniVaT, embeddings: Embeddings, source: str) -> float:
    """Return the accuracy (%) of predictions averaged over orders."""
    shares = averaged_probabilities(model, embeddings, AVERAGED)["fused"]
    right = shares.argmax(1).numpy() == labels_of(model, embeddings)
    keep = counted(embeddings, source)
    return 100 * (mean_over_domains(right, embeddings, source, keep) or float("nan"))


def made(
    file: Path, kind: str, source: str, width: int, seed: int, steps: int, draw: str, stops: str
) -> Row:
    """Return a complete row: its key and its results."""
    places = tuple(map(float, stops.split(",")))
    known = dict(zip(NAMED, (kind, source, width, seed, steps, draw, stops), strict=True))
    return known | KINDS[kind](file, source, width, seed, steps, draw, places)


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


def _job(
    kind: str, source: str, width: int, seed: int, options: argparse.Namespace
) -> tuple[Any, ...]:
    own = (options.steps, options.draw) if kind in ("every", "plain") else (0, "none")
    return (kind, source, width, seed, *own, options.stops)


def rows_of(file: Path) -> list[Row]:
    """Return the rows of a JSON lines file; none if it is missing."""
    if not file.is_file():
        return []
    return [json.loads(line) for line in file.read_text(encoding="utf-8").splitlines()]


if __name__ == "__main__":
    main()
