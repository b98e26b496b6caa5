"""Evaluate a head on every domain of an embeddings file.

python -m omnivat evaluate --head DIR --embeddings FILE [--order P] [--profile FILE] [--json]
python -m omnivat evaluate --unlabelled N [--draws K]  N pairs of each domain known, no labels
python -m omnivat evaluate --labels K  K labelled pairs of each class known: the head is taught
python -m omnivat evaluate --ladder  the page's ladder, as a file next to the embeddings
"""

import argparse
from collections.abc import Sequence
from statistics import pstdev
from typing import Any

from omnivat.cli.arguments import (
    as_json,
    count,
    declare,
    figure,
    flag,
    head_and_set,
    passed,
    progress_bar,
)
from omnivat.kit.errors import SettingsError
from omnivat.measure.rungs import DRAWS, NOTHING, labels, pairs

UNLABELLED = "pictures without labels"


def add(parser: argparse.ArgumentParser) -> None:
    words = (
        "draw N training pairs of each target domain, profile them without their labels, and"
        " predict the rest"
    )
    taught = (
        "draw K labelled training pairs of each class of each target domain, teach the head with"
        " them, and predict the rest"
    )
    draws = (
        "draws of known pairs to average over, with seeds SEED, SEED + 1, ...: figures of one draw"
        f" of few pairs vary by a point or two; default: {DRAWS}"
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
        seed="seed of the draws; default: 0",
        unlabelled=count(words, 0, metavar="N"),
        labels=count(taught, 1, metavar="K"),
        draws=count(draws, default=DRAWS, metavar="N"),
        ladder=flag(ladder),
    )
    figure(parser, "accuracy in each domain with 95 %% intervals")


def run(options: argparse.Namespace) -> None:
    """Load both, score every domain, print a table."""
    from omnivat.data.profile import domain_of
    from omnivat.data.profile_file import load_profile
    from omnivat.measure.known import measured

    head, embeddings = head_and_set(options, profiled=False)
    if options.ladder:
        from omnivat.measure.ladder import write_ladder

        print(f"written: {write_ladder(head, embeddings, options.embeddings)}")
        return
    loaded = [load_profile(file) for file in options.profile]
    if bool(loaded) + (options.unlabelled is not None) + (options.labels is not None) > 1:
        raise SettingsError("Give one of --profile, --unlabelled and --labels.")
    known = pairs(options.unlabelled) if options.unlabelled else NOTHING
    known = labels(options.labels) if options.labels else known
    with progress_bar("evaluate") as show:
        record = measured(
            head,
            head.profiled(embeddings, loaded) if loaded else embeddings,
            known,
            **passed(options, "seed", "order", "draws"),
            on_step=show,
        )
    by_name = {entry["domain"]: entry for entry in record["domains"]}
    for profile in loaded:
        domain = domain_of(profile, embeddings.header.domains, head.source)
        by_name[domain]["known_pairs"] = max(profile.counts.values())
    if options.figure:
        from omnivat.figures import strangers, write
        from omnivat.measure.unseen import bars

        write(options.figure, strangers(bars(record)))
    if options.json:
        print(as_json(record))
        return
    f1 = record["scores"].get("fused", {}).get("macro_f1")
    labelled = "labelled pairs" if options.labels else UNLABELLED
    print(table(record["domains"], record["accuracy"], f1, draws=record["draws"], known=labelled))


def table(
    records: Sequence[dict[str, Any]],
    mean: float | None,
    f1: float | None,
    *,
    draws: Sequence[float] = (),
    known: str = UNLABELLED,
) -> str:
    """Return ACC and macro-F1 of each domain as aligned text; the source is marked.

    mean, f1  of targets; None without one
    draws     the mean of each draw of known pairs
    known     of targets, in words

    "photo only" and "touch only" are ACC with the other image absent. Where classes are uneven,
    "balanced" is the mean over classes of the share right, and "largest" the ACC of always naming
    the largest class.
    """
    from omnivat.measure.gaps.confusion import balance

    balances = {r["domain"]: balance(r["confusion"]) for r in records if r["scores"]}
    uneven = any(one.uneven for one in balances.values())
    head = f"{'domain':<18} {'pairs':>6} {'ACC':>6} {'F1':>6} {'photo only':>11} {'touch only':>11}"
    lines = [head + (f" {'balanced':>9} {'largest':>8}" if uneven else "")]
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
        own = balances[record["domain"]]
        shares = f" {100 * own.balanced:>9.1f} {100 * own.always:>8.1f}" if uneven else ""
        lines.append(
            f"{name:<18} {record['pairs']:>6} {100 * fused['accuracy']:>6.1f} "
            f"{100 * fused['macro_f1']:>6.1f} {' '.join(alone)}{shares}"
        )
    if mean is None or f1 is None:
        lines.append(
            "mean of targets: none, because no other domain has pairs of the head's classes"
        )
    else:
        lines.append(f"{'mean of targets':<18} {'':>6} {100 * mean:>6.1f} {100 * f1:>6.1f}")
    if most := max((record["known_pairs"] for record in records), default=0):
        lines.append(
            f"Known of the profiled targets: up to {most} {known} (which are not "
            "predicted). Not comparable with strict domain generalisation."
        )
        if len(draws) > 1:
            lines.append(
                f"Mean of {len(draws)} draws of these pictures; the mean of targets deviates by "
                f"{100 * pstdev(draws):.1f} points between draws."
            )
    if lit := max((record["lamps_from"] for record in records), default=0):
        lines.append(
            f"The relief of touch is drawn by lamps known from up to {lit} touches a domain"
            " without labels. Not comparable with strict domain generalisation."
        )
    if any(record["trained_on"] for record in records):
        lines.append(
            "The set has no split: the source's row is measured on the head's training pairs."
        )
    return "\n".join(lines)
