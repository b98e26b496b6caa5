"""Evaluate a head on every domain of an embeddings file.

python -m omnivat evaluate --head DIR --embeddings FILE [--order P] [--json]
"""

import argparse
import json
import math
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from omnivat.heads import default_embeddings, default_head


def add(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("--head", type=Path, default=default_head())
    parser.add_argument("--embeddings", type=Path, default=default_embeddings())
    parser.add_argument(
        "--order", type=float, help="fractional order p; the learned one if left out"
    )
    parser.add_argument("--json", action="store_true", help="print JSON for programs")


def run(options: argparse.Namespace) -> None:
    """Load both, score every domain, print a table."""
    from omnivat.checkpoint import load_head
    from omnivat.data.store import load_embeddings
    from omnivat.evaluate import evaluate
    from omnivat.predict import checked_order

    checked_order(options.order)
    records = evaluate(
        load_head(options.head), load_embeddings(options.embeddings), order=options.order
    )
    if options.json:
        json.dump(records, sys.stdout, indent=2, ensure_ascii=False)
        print()
    else:
        print(table(records))


def table(records: Sequence[dict[str, Any]]) -> str:
    """Return ACC and macro-F1 of each domain as aligned text; the source is marked."""
    lines = [f"{'domain':<18} {'pairs':>6} {'ACC':>6} {'F1':>6} {'VIS ACC':>8} {'TAC ACC':>8}"]
    for record in records:
        name = record["domain"] + (" (source)" if record["is_source"] else "")
        scores = record["scores"]
        if not scores:
            lines.append(f"{name:<18} {0:>6}  no pairs of classes that the head knows")
            continue
        fused = scores["fused"]
        alone = [
            f"{100 * scores[n]['accuracy']:>8.1f}" if n in scores else f"{'-':>8}"
            for n in ("vis", "tac")
        ]
        lines.append(
            f"{name:<18} {record['pairs']:>6} {100 * fused['accuracy']:>6.1f} "
            f"{100 * fused['macro_f1']:>6.1f} {' '.join(alone)}"
        )
    from omnivat.evaluate import target_mean

    mean, f1 = target_mean(records), target_mean(records, "macro_f1")
    if math.isnan(mean):
        lines.append("mean of targets: none, for no other domain has pairs of the head's classes")
    else:
        lines.append(f"{'mean of targets':<18} {'':>6} {100 * mean:>6.1f} {100 * f1:>6.1f}")
    if any(record["trained_on"] for record in records):
        lines.append(
            "The set states no split: the source's row is of pairs that the head was trained on."
        )
    return "\n".join(lines)
