"""Teach a head from labelled pairs of a new sensor; whole objects are left out to test it.

python -m omnivat teach --embeddings LABELLED --out H2 [--head H] [--domain NAME] [--profile FILE]
[--json]
"""

import argparse
from dataclasses import asdict
from typing import Any

from omnivat.cli.arguments import as_json, declare, head_and_set, path, progress_bar
from omnivat.head.heads import own_head
from omnivat.kit.errors import DataError
from omnivat.kit.stages import IMAGES


def add(parser: argparse.ArgumentParser) -> None:
    declare(
        parser,
        "head",
        "profile",
        "json",
        embeddings=path("labelled pairs, from `omnivat embed`", required=True),
        domain={"help": "only the pairs of this domain"},
        out="folder for the taught head",
    )
    parser.set_defaults(head=own_head())


def run(options: argparse.Namespace) -> None:
    """Teach, test with each object left out, save, print."""
    import torch

    from omnivat.data.materials import NO_CLASS
    from omnivat.head.checkpoint import require_head_folder, save_head
    from omnivat.head.curve import curve
    from omnivat.head.teach import Lesson, judged, taught

    require_head_folder(options.out)
    head, embeddings = head_and_set(options)
    if options.domain:
        embeddings = embeddings.in_domain(options.domain)
    there = embeddings.header.modalities
    images = {n: torch.from_numpy(getattr(embeddings, n).copy()).float() for n in there}
    names, objects = embeddings.header.classes, embeddings.rows["object"]
    lessons = [
        Lesson(
            label=names[label],
            object=objects[row],
            **{n: images[n][row : row + 1] if n in images else None for n in IMAGES},
        )
        for row, label in enumerate(embeddings.label)
        if names[label] != NO_CLASS
    ]
    if not lessons:
        raise DataError(
            f"The {len(embeddings)} pairs have no classes, and teaching needs labels: embed them"
            " from folders <domain>/<class>, or from a CSV with a column material."
        )
    report = labels = None
    why = ""
    try:
        with progress_bar("teach") as show:
            report, labels = judged(head, lessons), curve(head, lessons, show)
    except DataError as error:
        why = str(error)
    found = taught(head, lessons)
    save_head(options.out, found)
    columns, tested = ("object", "label", "before", "after"), report.judged if report else ()
    record: dict[str, Any] = {
        "pairs": len(lessons),
        "before": report.before if report else None,
        "after": report.after if report else None,
        "share": round(found.provenance["head_share"], 4),
        "held_out": [{name: getattr(lesson, name) for name in columns} for lesson in tested],
        "curve": asdict(labels) if labels else None,
        "classes": list(found.settings.classes),
        "out": str(options.out),
    }
    if options.json:
        return print(as_json(record))
    pairs, out = record["pairs"], f"head written to {options.out}"
    if labels is None:
        return print(f"{pairs} pairs; not tested. {why}\n{out}")
    print(f"right before {record['before']}, after {record['after']} of {pairs}, each left out")
    print(f"  weight of the head's own prediction: {record['share']:.2f}")
    shares = ", ".join(f"{point.objects}: {100 * point.right:.0f} %" for point in labels.points)
    print(f"right by labelled objects of a class: {shares}\n  {labels.words}\n{out}")
