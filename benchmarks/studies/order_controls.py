"""Chirps with controls in place of F_p: does any unitary do, or only the fractional transform?

    python -m benchmarks.studies.order_controls [--seeds 3] [--out FILE] [--table]

Each row is one head on one set of chirps (p* drawn anew for every seed): F_p at p*, the identity,
random unitaries, and exp(pA) of a random A at six orders, p* among them. A finished row is kept.
"""

import argparse
import json
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import torch

from benchmarks.studies._order_matrix import heads_with, matrix_of
from benchmarks.studies._order_runs import chirp_head, other_seed, scored
from omnivat.simulate.chirps import ChirpSettings, chirp_embeddings

OUT = Path("docs/benchmarks/order_controls.jsonl")
STOPS = (0.0, 0.25, 0.5, 0.75, 1.0)
Job = tuple[str, int, float, int]  # kind, seed of the set, order, draw of the control


def jobs(seeds: int) -> list[Job]:
    """Return the heads to train, set by set."""
    found: list[Job] = []
    for seed in range(seeds):
        star = other_seed(ChirpSettings(), seed).order
        found += [("order", seed, star, 0), ("identity", seed, 0.0, 0)]
        found += [("unitary", seed, 0.0, draw) for draw in range(3)]
        found += [("group", seed, p, draw) for draw, p in product(range(2), (*STOPS, star))]
    return found


def row_of(job: Job) -> dict[str, Any]:
    """Train and score one head."""
    kind, seed, order, draw = job
    settings = other_seed(ChirpSettings(), seed)
    made = chirp_embeddings(settings)
    with heads_with(matrix_of(kind, settings.width, order, draw)):
        found = scored(chirp_head(settings, made, order), made, settings.domain_names[0])
    return {
        "kind": kind,
        "seed": seed,
        "order": order,
        "draw": draw,
        "p_star": settings.order,
        "unseen": found.unseen,
        "source_test": found.source_test,
    }


def table(rows: list[dict[str, Any]]) -> str:
    """Return mean, lowest and highest accuracy by kind, in Markdown."""
    lines = ["| in place of F_p | heads | unseen, mean | lowest to highest | source, test pairs |"]
    lines.append("| --- | --- | --- | --- | --- |")
    for kind in dict.fromkeys(row["kind"] for row in rows):
        own = [row for row in rows if row["kind"] == kind]
        unseen = [row["unseen"] for row in own]
        lines.append(
            f"| {kind} | {len(own)} | {np.mean(unseen):.1f} | {min(unseen):.1f} to "
            f"{max(unseen):.1f} | {np.mean([row['source_test'] for row in own]):.1f} |"
        )
    return "\n".join(lines)


def main() -> None:
    """Make the missing rows, or print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--out", type=Path, default=OUT)
    parser.add_argument("--table", action="store_true")
    options = parser.parse_args()
    torch.set_num_threads(1)
    text = options.out.read_text(encoding="utf-8") if options.out.is_file() else ""
    rows = [json.loads(line) for line in text.splitlines()]
    if options.table:
        return print(table(rows))
    done = {(row["kind"], row["seed"], row["order"], row["draw"]) for row in rows}
    for job in jobs(options.seeds):
        if job not in done:
            with options.out.open("a", encoding="utf-8") as handle:
                handle.write(json.dumps(row_of(job)) + "\n")
    return None


if __name__ == "__main__":
    main()
