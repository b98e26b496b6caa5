"""Gain from teaching a head a few pairs of an unseen domain, on other pairs of that domain.

    python -m benchmarks.teach [--head DIR] [--embeddings FILE] [--draws 10] [--out docs/benchmarks/teach.md]

For each unseen domain and draw, K pairs of each class teach the head; it is then tested on the
domain's pairs of other objects. The interval is over domains and draws (normal, 95 %).
"""

import argparse
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import torch
from torch import Tensor

from benchmarks.measure import machine
from omnivat.data.store import Embeddings, load_embeddings
from omnivat.head.checkpoint import Head, load_head
from omnivat.head.heads import default_embeddings, default_head
from omnivat.head.teach import Lesson, taught
from omnivat.kit.seeding import derive_seed
from omnivat.measure.evaluate import label_map, predicted_probabilities

COUNTS = (1, 2, 3, 5)  # pairs of each class


def gains(head: Head, pairs: Embeddings, count: int, draws: int) -> Iterator[tuple[float, float]]:
    """Yield the accuracy before and after for each draw in one domain."""
    labels = label_map(head.settings.classes, pairs.header.classes)[pairs.label]
    objects = np.array(pairs.rows["object"])
    for draw in range(draws):
        random = np.random.default_rng(derive_seed(0, "teach", count, draw))
        own = [
            row
            for k in range(len(head.settings.classes))
            for row in random.permutation(np.flatnonzero(labels == k))[:count]
        ]
        rest = np.flatnonzero((labels >= 0) & ~np.isin(objects, objects[own]))
        if not len(rest) or not own:
            continue
        lessons = [_lesson(head, pairs, int(row), int(labels[row])) for row in own]
        truth = torch.from_numpy(labels[rest])
        after = taught(head, lessons)
        yield _right(head, pairs, rest, truth), _right(after, pairs, rest, truth)


def _lesson(head: Head, pairs: Embeddings, row: int, label: int) -> Lesson:
    return Lesson(
        object=pairs.rows["object"][row],
        label=head.settings.classes[label],
        vis=torch.from_numpy(pairs.vis[row : row + 1].copy()),
        tac=torch.from_numpy(pairs.tac[row : row + 1].copy()),
    )


def _right(head: Head, pairs: Embeddings, rows: "np.ndarray[tuple[int], np.dtype[np.int64]]", truth: Tensor) -> float:
    found = predicted_probabilities(head.model, pairs.select(rows))["fused"].argmax(1)
    return float((found == truth).double().mean())


def table(head: Head, embeddings: Embeddings, draws: int) -> str:
    """Return the table as Markdown."""
    lines = ["| pairs of each class | before | after | gain, points |", "| --- | --- | --- | --- |"]
    for count in COUNTS:
        found = np.array(
            [
                pair
                for name in embeddings.header.domains
                if name != head.source
                for pair in gains(head, embeddings.in_domain(name), count, draws)
            ]
        )
        before, after = 100 * found.mean(0)
        gain = 100 * (found[:, 1] - found[:, 0])
        half = 1.96 * gain.std(ddof=1) / len(gain) ** 0.5
        lines.append(f"| {count} | {before:.1f} | {after:.1f} | {gain.mean():+.1f} ± {half:.1f} |")
    return "\n".join(lines)


def main() -> None:
    """Measure, print, and write where asked to."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--head", type=Path, default=default_head(), help="head folder")
    parser.add_argument("--embeddings", type=Path, default=default_embeddings(), help="a set")
    parser.add_argument("--draws", type=int, default=10, help="draws of pairs in each domain")
    parser.add_argument("--out", type=Path, help="Markdown file to write")
    options = parser.parse_args()
    head, embeddings = load_head(options.head), load_embeddings(options.embeddings)
    found, here = table(head, embeddings, options.draws), machine()
    text = (
        "# Teaching a head a few pairs\n\n"
        "`python -m benchmarks.teach`: accuracy (percent, both images) on pairs of other objects of "
        "each unseen domain, before and after a few of its pairs taught the head, by the method that "
        f"`omnivat.head.teach` chooses from them. Mean over {len(embeddings.header.domains) - 1} domains and "
        f"{options.draws} draws; 95 % interval of the gain over both. Head of {head.source}, "
        f"D = {head.settings.width}.\n\n{found}\n\n"
        f"{here['machine']}, Python {here['python']}, torch {here['torch']}.\n"
    )
    print(text)
    if options.out:
        options.out.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
