"""Evaluate a head on every domain of an embeddings file.

python -m omnivat evaluate --head DIR --embeddings FILE [--order P] [--profile FILE] [--json] [--figure FILE]
python -m omnivat evaluate --unlabelled N [--seed N]    profiles of N unlabelled pairs of each domain
"""

import argparse
import json
import math
import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from omnivat.cli.arguments import (
    add_device,
    add_embeddings,
    add_figure,
    add_head,
    add_json,
    add_order,
    add_profile,
    add_seed,
    check_figure,
    progress_bar,
    whole,
    with_profiles,
)
from omnivat.errors import SettingsError

if TYPE_CHECKING:
    from omnivat.checkpoint import Head
    from omnivat.data.store import Embeddings


def add(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    add_head(parser)
    add_embeddings(parser)
    add_order(parser)
    add_profile(parser)
    parser.add_argument(
        "--unlabelled",
        type=whole(0),
        metavar="N",
        help="draw N training pairs of each target domain, profile them without their labels, and "
        "predict the rest",
    )
    add_seed(parser, of="--unlabelled")
    add_device(parser)
    add_json(parser)
    add_figure(parser, of="accuracy in each domain with 95 %% intervals")


def run(options: argparse.Namespace) -> None:
    """Load both, score every domain, print a table."""
    check_figure(options)
    from omnivat.checkpoint import load_head
    from omnivat.data.store import load_embeddings
    from omnivat.evaluate import evaluate

    head, embeddings = load_head(options.head), load_embeddings(options.embeddings)
    head.require_embeddings(embeddings)
    embeddings, counts = _known(options, head, embeddings)
    with progress_bar("evaluate") as show:
        found = evaluate(head, embeddings, order=options.order, on_step=show)
    records = [{**record, "unlabelled": counts.get(record["domain"], 0)} for record in found]
    if options.figure:
        from omnivat.figures import strangers, write

        write(options.figure, strangers(summary(records, head.source)))
    if options.json:
        json.dump(records, sys.stdout, indent=2, ensure_ascii=False)
        print()
    else:
        print(table(records))


def _known(
    options: argparse.Namespace, head: "Head", embeddings: "Embeddings"
) -> tuple["Embeddings", dict[str, int]]:
    """Return the profiled embeddings without the pairs of profiles, and pictures by domain."""
    import numpy as np

    from omnivat.data.profile import domain_of, drawn_profiles, profiled
    from omnivat.data.profile_file import load_profile

    if options.unlabelled is None:
        loaded = [load_profile(file) for file in options.profile]
        named = {domain_of(p, embeddings.header.domains, head.source): p for p in loaded}
        counts = {name: max(profile.counts.values()) for name, profile in named.items()}
        return with_profiles(head, embeddings, options.profile), counts
    if options.profile:
        raise SettingsError("Give --profile or --unlabelled, not both.")
    profiles, rows = drawn_profiles(embeddings, head.source, options.unlabelled, seed=options.seed)
    moved = profiled(embeddings, profiles, head.source_profile)
    rest = np.setdiff1d(np.arange(len(moved)), rows)
    return moved.select(rest), {n: p.counts["vis"] for n, p in profiles.items()}


def summary(records: Sequence[dict[str, Any]], source: str) -> dict[str, Any]:
    """Return the records of `evaluate` as `omnivat.figures.strangers` takes them."""
    from omnivat.unseen.masks import of_domains, wilson

    domains, strange = [], []
    for record in (one for one in records if one["scores"]):
        right = {n: round(s["accuracy"] * record["pairs"]) for n, s in record["scores"].items()}
        ends = {name: wilson(count, record["pairs"]) for name, count in right.items()}
        domains.append(
            {
                "name": record["domain"],
                "is_source": record["is_source"],
                "pairs": record["pairs"],
                **{
                    f"answers/{n}": {"share": right[n] / record["pairs"], "low": a, "high": b}
                    for n, (a, b) in ends.items()
                },
            }
        )
        strange += [] if record["is_source"] else [(right, record["pairs"])]
    unseen = {}
    for name in strange[0][0] if strange else ():
        counts = [(right[name], pairs) for right, pairs in strange]
        low, high = of_domains(counts)
        mean = sum(right / pairs for right, pairs in counts) / len(counts)
        unseen[f"answers/{name}"] = {"share": mean, "low": low, "high": high}
    chance = next((1 / len(one["classes"]) for one in records if one["scores"]), None)
    return {"source": source, "chance": chance, "domains": domains, "unseen": unseen}


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
    if any(record.get("unlabelled") for record in records):
        most = max(record["unlabelled"] for record in records)
        lines.append(
            f"Known of the profiled targets: up to {most} pictures without labels (their pairs are "
            "not predicted). Not comparable with strict domain generalisation."
        )
    if any(record["trained_on"] for record in records):
        lines.append(
            "The set has no split: the source's row is measured on the head's training pairs."
        )
    return "\n".join(lines)
