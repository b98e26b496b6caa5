"""How far along its profile should a sensor be moved, for a head that was trained with imitated sensors?

    python -m benchmarks.profile_step [--methods omnivat,erm_recipe] [--seeds 0,1,2] [--out docs/benchmarks]

Gains over "as it comes" of 1, 5 and 20 pairs without labels, at several shares of the step. The share for a source and
a target domain is chosen on all cells that have neither, so no label of either decides. The heads are those of
`python -m benchmarks.ladder` (`build/ladder_heads`); missing ones are trained.
"""

import argparse
import json
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from benchmarks._ladder_methods import RECIPES, Trained, onto, profile, rows_of
from omnivat.cli.arguments import listed, numbers
from omnivat.data.profile import STEP_SHIFTED
from omnivat.data.store import Embeddings, load_embeddings
from omnivat.head.heads import default_embeddings
from omnivat.kit.files import write_text
from omnivat.kit.threads import pin_thread

STEPS, COUNTS, DRAWS = (0.5, 0.625, 0.75, 0.875, 1.0), (1, 5, 20), 3
Cells = dict[str, dict[str, list[list[float]]]]  # source -> target -> steps × counts, in points


def gains(embeddings: Embeddings, method: Trained, source: int) -> dict[str, list[list[float]]]:
    """Return target -> gain (points) of every step and count, mean over draws."""
    names, split = embeddings.header.domains, np.array(embeddings.rows["split"])
    own = np.flatnonzero((embeddings.domain == source) & (split == "train"))
    base, taught = profile(rows_of(embeddings, own)), np.unique(embeddings.label[own])
    found = {}
    for target in (d for d in range(len(names)) if d != source):
        of = embeddings.domain == target
        test = np.flatnonzero(of & (split == "test") & np.isin(embeddings.label, taught))
        pool, truth = np.flatnonzero(of & (split == "train")), embeddings.label[test]
        asked = rows_of(embeddings, test)
        before = float((method.predict(asked) == truth).mean())
        table = np.zeros((len(STEPS), len(COUNTS)))
        for draw in range(DRAWS):
            drawn = np.random.default_rng([draw, target]).permutation(pool)
            for column, count in enumerate(COUNTS):
                near = profile(rows_of(embeddings, drawn[:count]))
                for row, step in enumerate(STEPS):
                    right = method.predict(onto(asked, near, base, step)) == truth
                    table[row, column] += 100 * (float(right.mean()) - before) / DRAWS
        found[names[target]] = table.round(2).tolist()
    return found


def chosen(cells: Mapping[str, Cells]) -> list[float]:
    """Return the best step of every source and target by the mean gain of cells that share neither."""
    pairs = {(s, t) for found in cells.values() for s, targets in found.items() for t in targets}
    best = []
    for source, target in sorted(pairs):
        others = [
            table
            for found in cells.values()
            for s, targets in found.items()
            for t, table in targets.items()
            if {source, target}.isdisjoint({s, t})
        ]
        best.append(STEPS[int(np.mean(others, axis=(0, 2)).argmax())])
    return best


def report(cells: Mapping[str, Cells]) -> str:
    """Return the tables as Markdown."""
    parts = ["# How far along its profile", (__doc__ or "").split("\n\n")[2]]
    for name, text in (("omnivat", "OmniVaT"), ("erm_recipe", "ERM-MLP, the same recipe")):
        own = [found for key, found in cells.items() if key.split()[0] == name]
        if not own:
            continue
        tables = {s: np.mean([table for found in own for table in found.get(s, {}).values()], axis=0) for s in own[0]}
        rows = [f"| {s} | " + " | ".join(_cell(row) for row in table) + " |" for s, table in tables.items()]
        mean = np.mean(list(tables.values()), axis=0)
        head = f"| {text}, trained on | " + " | ".join(f"{step:g}" for step in STEPS) + " |"
        rows.append("| **mean** | " + " | ".join(_cell(row) for row in mean) + " |")
        parts.append("\n".join([head, "| --- |" + " ---: |" * len(STEPS), *rows]))
        steps, times = np.unique(chosen({k: v for k, v in cells.items() if k.split()[0] == name}), return_counts=True)
        said = ", ".join(f"{s:g} ({n} times)" for s, n in zip(steps, times, strict=True))
        seeds = len(own)
        parts.append(f"Seeds: {seeds}. Points for 1 / 5 / 20 pairs. Chosen without the source and the target: {said}.")
    parts.append(f"Heads trained with imitated sensors take {STEP_SHIFTED:g} of the step.")
    return "\n\n".join(parts) + "\n"


def _cell(row: "np.ndarray[tuple[int], np.dtype[np.float64]]") -> str:
    return " / ".join(f"{value:+.1f}" for value in row)


def main() -> None:
    """Measure, print and write both files."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--embeddings", type=Path, default=default_embeddings(), help="a set")
    parser.add_argument("--methods", default="omnivat,erm_recipe", help="of the page's recipe")
    parser.add_argument("--seeds", default="0,1,2", help="of training")
    parser.add_argument("--out", type=Path, default=Path("docs/benchmarks"), help="folder")
    options = parser.parse_args()
    pin_thread()
    embeddings = load_embeddings(options.embeddings)
    cells: dict[str, Cells] = {}
    for name in listed(options.methods):
        for seed in numbers(options.seeds):
            cells[f"{name} {seed}"] = {
                source: gains(embeddings, RECIPES[name](embeddings, source, seed), index)
                for index, source in enumerate(embeddings.header.domains)
            }
            print(name, seed, flush=True)
    text = json.dumps({"steps": STEPS, "counts": COUNTS, "cells": cells})
    write_text(options.out / "profile_step.json", text + "\n")
    write_text(options.out / "profile_step.md", report(cells))
    print(report(cells))


if __name__ == "__main__":
    main()
