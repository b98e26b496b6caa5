"""Evaluate a head on every domain of an embeddings file.

python -m omnivat evaluate --head DIR --embeddings FILE [--order P] [--json]
"""

import argparse
import json
import math
import sys
from collections.abc import Sequence
from typing import Any

from omnivat.cli.arguments import add_embeddings, add_head, add_json, add_order
from omnivat.cli.computing import add_device


def add(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    add_head(parser)
    add_embeddings(parser)
    add_order(parser)
    add_device(parser)
    add_json(parser)


def run(options: argparse.Namespace) -> None:
    """Load both, score every domain, print a table."""
    from omnivat.checkpoint import load_head
    from omnivat.data.store import load_embeddings
    from omnivat.evaluate import evaluate

    records = evaluate(
        load_head(options.head), load_embeddings(options.embeddings), order=options.order
    )
    if options.json:
        json.dump(records, sys.stdout, indent=2, ensure_ascii=False)
        print()
    else:
        print(table(records))


def table(records: Sequence[dict[str, Any]]) -> str:
    """Return ACC and macro-F1 of each domain as aligned text; the source is marked.

    "photo only" and "touch only" are ACC with the other image absent.
    """
    lines = [
        f"{'domain':<18} {'pairs':>6} {'ACC':>6} {'F1':>6} {'photo only':>11} {'touch only':>11}"
    ]
    for record in records:
        name = record["domain"] + (" (source)" if record["is_source"] else "")
        scores = record["scores"]
        if not scores:
            lines.append(f"{name:<18} {0:>6}  no pairs of the head's classes")
            continue
        fused = scores["fused"]
        alone = [
            f"{100 * scores[n]['accuracy']:>11.1f}" if n in scores else f"{'-':>11}"
            for n in ("vis", "tac")
        ]
        lines.append(
            f"{name:<18} {record['pairs']:>6} {100 * fused['accuracy']:>6.1f} "
            f"{100 * fused['macro_f1']:>6.1f} {' '.join(alone)}"
        )
    from omnivat.evaluate import target_mean, target_scores

    targets = target_scores(records)
    mean, f1 = target_mean(targets), target_mean(targets, "macro_f1")
    if math.isnan(mean):
        lines.append(
            "mean of targets: none, because no other domain has pairs of the head's classes"
        )
    else:
        lines.append(f"{'mean of targets':<18} {'':>6} {100 * mean:>6.1f} {100 * f1:>6.1f}")
    if any(record["trained_on"] for record in records):
        lines.append(
            "The set has no split: the source's row is measured on the head's training pairs."
        )
    return "\n".join(lines)
