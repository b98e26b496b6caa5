"""Look values up in records: by method, source and seed."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import fields
from typing import Any

from omnivat.study.reports.intervals import spread

Record = Mapping[str, Any]
SCORES = ("accuracy", "macro_f1")  # of every table
METRICS = {"accuracy": "ACC", "macro_f1": "Macro-F1", "macro_f1_union": "Macro-F1 (union)"}
OF_DATA = ("classes", "input_width", "lang_width")  # settings that the data determine


def latest(records: Iterable[Record]) -> list[Record]:
    """Return the newest record of every (method, source, seed), in order of first appearance."""
    return list({(r["method"], r["source"], r["seed"]): r for r in records}.values())


def methods(records: Sequence[Record]) -> dict[str, str]:
    """Return method -> label, in order of first appearance."""
    return {record["method"]: record["label"] for record in records}


def completed(records: Iterable[Record], method: str) -> list[Record]:
    """Return the records of a method that were not skipped."""
    return [r for r in records if r["method"] == method and "targets" in r]


def sources_of(records: Iterable[Record]) -> list[str]:
    """Return the sources, in order of first appearance."""
    return list(dict.fromkeys(record["source"] for record in records))


def targets_of(records: Iterable[Record]) -> list[str]:
    """Return the targets, in order of first appearance."""
    return list(dict.fromkeys(name for record in records for name in record.get("targets", {})))


def by_run(
    records: Iterable[Record], metric: str, which: str = "fused"
) -> dict[tuple[str, int], float]:
    """Return (source, seed) -> mean over targets of a score of one method's completed runs."""
    found = {}
    for record in records:
        scores = [target["scores"] for target in record["targets"].values()]
        values = [score[which][metric] for score in scores if which in score]
        found[record["source"], record["seed"]] = spread(values).mean
    return found


def by_seed(values: Mapping[tuple[str, int], float], sources: Sequence[str]) -> list[float]:
    """Return the mean over sources for each seed that all sources have."""
    seeds = sorted({seed for _, seed in values})
    return [
        sum(values[source, seed] for source in sources) / len(sources)
        for seed in seeds
        if all((source, seed) in values for source in sources)
    ]


def origin(records: Sequence[Record]) -> str:
    """Return where the records are from: data, encoder, seeds and torch."""
    data, versions = records[0]["data"], records[0]["versions"]
    seeds = sorted({record["seed"] for record in records})
    what = "**Simulated domains**" if data["simulated"] else "Data"
    encoder = f"Encoder {data['encoder']} ({data['weights_hash'][:12]})"
    numbers = f"Seeds {', '.join(map(str, seeds))}. torch {versions.get('torch', '?')}."
    return f"{what}: {data['origin'] or 'origin not stated'}. {encoder}. {numbers}"


def changed_settings(record: Record) -> str:
    """Return the settings of a head's run that differ from the defaults, in the form of `--set`.

    Settings that the data determine are left out: classes and the widths of the encoders.
    """
    from omnivat.head.settings import HeadSettings
    from omnivat.training.settings import TrainSettings

    settings: Mapping[str, Any] = record.get("settings") or {}
    kinds: dict[str, Any] = {"head": HeadSettings, "train": TrainSettings}
    defaults = {part: {f.name: f.default for f in fields(kind)} for part, kind in kinds.items()}
    return " ".join(
        f"{name}={value}"
        for part in kinds
        for name, value in settings.get(part, {}).items()
        if name not in OF_DATA and value != defaults[part].get(name)
    )
