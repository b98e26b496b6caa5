"""One head for every order beside heads trained at each stop alone.

    python -m benchmarks.order_every [--sources TAG-sim,...] [--widths 64] [--steps 12000]
                                     [--stops 0,0.25,0.5,0.75,1] [--jobs N] [--out FILE]

The head for every order draws p anew for each pair (`order_draw=row`) and takes `--steps` steps of
64 pairs; heads at a stop take 60 epochs of 16. Averages are over 11 orders from 0 to 1. Rows are
appended to a JSON lines file, one for each source and width; a row that is there is not made again.
"""

import argparse
import json
import time
from dataclasses import replace
from math import ceil
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks._order_runs import SENSORS, carried_out, head_at, labels_of, scored
from omnivat.averaged import averaged_probabilities
from omnivat.data.store import Embeddings, load_embeddings
from omnivat.from_pairs import plan_training
from omnivat.heads import default_embeddings
from omnivat.model.head import OmniVaT
from omnivat.train import train
from omnivat.unseen.masks import counted, mean_over_domains

BATCH = 64
AVERAGED = tuple(float(p) for p in np.linspace(0, 1, 11))


def compared(
    file: Path, source: str, width: int, steps: int, draw: str, stops: tuple[float, ...]
) -> dict[str, Any]:
    """Train both kinds of head on one source; return their accuracies in unseen domains (%)."""
    embeddings = load_embeddings(file)
    count = len(embeddings.in_domain(source, split="train"))
    training = replace(
        SENSORS, batch=BATCH, epochs=ceil(steps / ceil(count / BATCH)), order_draw=draw
    )
    plan = plan_training(embeddings, source, head={"width": width}, training=training)
    began = time.process_time()
    every = train(plan.pairs, plan.settings, plan.training, bank=plan.bank).model
    cpu = time.process_time() - began
    alone = [
        scored(head_at(embeddings, source, p, 0, SENSORS, {"width": width}), embeddings, source)
        for p in stops
    ]
    return {
        "source": source,
        "width": width,
        "steps": steps,
        "draw": draw,
        "stops": list(stops),
        "every": [scored(every, embeddings, source, p).unseen for p in stops],
        "alone": [one.unseen for one in alone],
        "averaged": averaged(every, embeddings, source),
        "cpu_s": round(cpu, 1),
    }


def averaged(model: OmniVaT, embeddings: Embeddings, source: str) -> float:
    """Return the accuracy (%) of predictions averaged over orders."""
    shares = averaged_probabilities(model, embeddings, AVERAGED)["fused"]
    right = shares.argmax(1).numpy() == labels_of(model, embeddings)
    keep = counted(embeddings, source)
    return 100 * (mean_over_domains(right, embeddings, source, keep) or float("nan"))


def main() -> None:
    """Make the rows that are not there yet."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--embeddings", type=Path, default=default_embeddings())
    parser.add_argument("--sources", help="with commas; all domains if left out")
    parser.add_argument("--widths", default="64")
    parser.add_argument("--steps", type=int, default=12_000)
    parser.add_argument("--draw", choices=["batch", "row"], default="row")
    parser.add_argument("--stops", default="0,0.25,0.5,0.75,1")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--out", type=Path, default=Path("docs/benchmarks/order_every.jsonl"))
    options = parser.parse_args()
    domains = load_embeddings(options.embeddings).header.domains
    sources = options.sources.split(",") if options.sources else domains
    stops = tuple(map(float, options.stops.split(",")))
    there = {(r["source"], r["width"], r["steps"], r["draw"]) for r in rows_of(options.out)}
    jobs = [
        (options.embeddings, source, int(width), options.steps, options.draw, stops)
        for width in options.widths.split(",")
        for source in sources
        if (source, int(width), options.steps, options.draw) not in there
    ]
    for row in carried_out(compared, jobs, options.jobs):
        with options.out.open("a", encoding="utf-8") as handle:
            handle.write(json.dumps(row) + "\n")
        print(json.dumps(row), flush=True)


def rows_of(file: Path) -> list[dict[str, Any]]:
    """Return the rows of a JSON lines file; none where it is not there."""
    if not file.is_file():
        return []
    return [json.loads(line) for line in file.read_text(encoding="utf-8").splitlines()]


if __name__ == "__main__":
    main()
