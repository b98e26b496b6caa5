"""Teach a head from labelled pairs of a new sensor; whole objects are left out to test it.

python -m omnivat teach --embeddings LABELLED --out H2 [--head H] [--domain NAME] [--profile FILE] [--json]
"""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from omnivat.cli.arguments import as_json, head_and_set, progress_bar, shared
from omnivat.errors import DataError

if TYPE_CHECKING:
    from omnivat.data.store import Embeddings
    from omnivat.teach import Lesson


def add(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--embeddings", type=Path, required=True, help="labelled pairs, from `omnivat embed`")
    parser.add_argument("--domain", help="only the pairs of this domain")
    shared(parser, "head", "profile", "json", out="folder for the taught head")


def run(options: argparse.Namespace) -> None:
    """Teach, test with each object left out, save, print."""
    from omnivat.checkpoint import require_head_folder, save_head
    from omnivat.teach import judged, taught

    require_head_folder(options.out)
    head, embeddings = head_and_set(options)
    if options.domain:
        embeddings = embeddings.in_domain(options.domain)
    lessons = lessons_of(embeddings)
    try:
        with progress_bar("teach") as show:
            report, why = judged(head, lessons, show), ""
    except DataError as error:
        report, why = None, str(error)
        if not lessons:
            raise
    found = taught(head, lessons, report.method if report else "")
    save_head(options.out, found)
    names, tested = ("object", "label", "before", "after"), report.judged if report else ()
    record: dict[str, Any] = {
        "pairs": len(lessons),
        "before": report.before if report else None,
        "after": report.after if report else None,
        "method": found.provenance["taught_by"],
        "right": dict(report.right) if report else {},
        "held_out": [{name: getattr(one, name) for name in names} for one in tested],
        "classes": list(found.settings.classes),
        "out": str(options.out),
    }
    print(as_json(record) if options.json else _readable(record, why))


def lessons_of(embeddings: "Embeddings") -> "list[Lesson]":
    """Return the pairs of a set as lessons."""
    import torch

    from omnivat.teach import MOST, Lesson

    if len(embeddings) > MOST:
        raise DataError(
            f"The set has {len(embeddings):,} pairs and at most {MOST:,} teach; train a head with "
            "`python -m omnivat train` instead."
        )
    vis, tac = (torch.from_numpy(rows.copy()) for rows in (embeddings.vis, embeddings.tac))
    names = embeddings.header.classes
    objects = embeddings.rows["object"]
    return [
        Lesson(label=names[label], vis=vis[row : row + 1].float(), tac=tac[row : row + 1].float(), object=objects[row])
        for row, label in enumerate(embeddings.label)
    ]


def _readable(record: dict[str, Any], why: str) -> str:
    if why:
        return f"{record['method']}; {record['pairs']} pairs; not tested. {why}\nhead written to {record['out']}"
    methods = ", ".join(f"{name} {right}" for name, right in record["right"].items())
    return (
        f"{record['method']}; right before {record['before']}, after {record['after']} of "
        f"{record['pairs']}, each object left out\n  right by method: {methods}\n"
        f"head written to {record['out']}"
    )
