"""Evaluate a head on every domain of an embeddings file.

python -m omnivat evaluate --head DIR --embeddings FILE [--order P] [--profile FILE] [--json]
python -m omnivat evaluate --unlabelled N [--draws K]  N pairs of each domain known, no labels
python -m omnivat evaluate --ladder  the page's ladder, as a file next to the embeddings
"""

import argparse
import math
from collections.abc import Sequence
from statistics import pstdev
from typing import Any

from omnivat.cli.arguments import as_json, count, declare, figure, flag, head_and_set, progress_bar
from omnivat.kit.errors import SettingsError


def add(parser: argparse.ArgumentParser) -> None:
    words = (
        "draw N training pairs of each target domain, profile them without their labels, and"
        " predict the rest"
    )
    draws = (
        "draws of --unlabelled to average over, with seeds SEED, SEED + 1, ... (default:"
        " %(default)s): figures of one draw of few pairs vary by a point or two"
    )
    ladder = (
        "write what each step of knowledge about a new sensor brings, next to the embeddings; the"
        " page then shows it at once"
    )
    declare(
        parser,
        "head",
        "embeddings",
        "order",
        "profile",
        "device",
        "json",
        seed="seed of --unlabelled; default: 0",
        unlabelled=count(words, 0, metavar="N"),
        draws=count(draws, default=10, metavar="K"),
        ladder=flag(ladder),
    )
    figure(parser, "accuracy in each domain with 95 %% intervals")


def run(options: argparse.Namespace) -> None:
    """Load both, score every domain, print a table."""
    from omnivat.data.profile import domain_of, load_profile
    from omnivat.measure.known import evaluate
    from omnivat.measure.rungs import NOTHING, pairs

    head, embeddings = head_and_set(options, profiled=False)
    if options.ladder:
        from omnivat.measure.ladder import write_ladder

        print(f"written: {write_ladder(head, embeddings, options.embeddings)}")
        return
    if options.profile and options.unlabelled is not None:
        raise SettingsError("Give --profile or --unlabelled, not both.")
    loaded = [load_profile(file) for file in options.profile]
    with progress_bar("evaluate") as show:
        records = evaluate(
            head,
            head.profiled(embeddings, loaded) if loaded else embeddings,
            NOTHING if options.unlabelled is None else pairs(options.unlabelled),
            draws=options.draws,
            seed=options.seed,
            order=options.order,
            on_step=show,
        )
    by_name = {record["domain"]: record for record in records}
    for profile in loaded:
        domain = domain_of(profile, embeddings.header.domains, head.source)
        by_name[domain]["known_pairs"] = max(profile.counts.values())
    if options.figure:
        from omnivat.figures import strangers, write

        write(options.figure, strangers(summary(records, head.source)))
    print(as_json(records) if options.json else table(records))


def summary(records: Sequence[dict[str, Any]], source: str) -> dict[str, Any]:
    """Return the records of `evaluate` as `omnivat.figures.strangers` takes them."""
    from omnivat.measure.unseen import share_of

    tested = [one for one in records if one["scores"]]
    domains: list[dict[str, Any]] = []
    counts: dict[str, list[tuple[int, int]]] = {}  # right and tested pairs of each unseen domain
    for record in tested:
        own = {f"answers/{name}": one["accuracy"] for name, one in record["scores"].items()}
        kept = {"name": record["domain"], **{n: record[n] for n in ("is_source", "pairs")}}
        for name, accuracy in own.items():
            right = round(accuracy * record["pairs"]), record["pairs"]
            kept[name] = share_of([right])
            if not record["is_source"]:
                counts.setdefault(name, []).append(right)
        domains.append(kept)
    unseen = {name: share_of(some) for name, some in counts.items()}
    chance = 1 / len(tested[0]["classes"]) if tested else None
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
    from omnivat.measure.known import target_mean, target_scores

    targets = target_scores(records)
    mean, f1 = target_mean(targets), target_mean(targets, "macro_f1")
    if math.isnan(mean):
        lines.append(
            "mean of targets: none, because no other domain has pairs of the head's classes"
        )
    else:
        lines.append(f"{'mean of targets':<18} {'':>6} {100 * mean:>6.1f} {100 * f1:>6.1f}")
    if most := max((record["known_pairs"] for record in records), default=0):
        lines.append(
            f"Known of the profiled targets: up to {most} pictures without labels (their pairs are "
            "not predicted). Not comparable with strict domain generalisation."
        )
        means = list(zip(*(r["draws"] for r in records if r.get("draws")), strict=True))
        if means:
            each = [100 * sum(values) / len(values) for values in means]
            lines.append(
                f"Mean of {len(each)} draws of these pictures; the mean of targets deviates by "
                f"{pstdev(each):.1f} points between draws."
            )
    if any(record["trained_on"] for record in records):
        lines.append(
            "The set has no split: the source's row is measured on the head's training pairs."
        )
    return "\n".join(lines)
