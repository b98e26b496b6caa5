"""Look values up in records: by method, source and seed."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import fields
from typing import Any

from omnivat.measure.evaluate import target_mean

Record = Mapping[str, Any]
METRICS = {
    "accuracy": "ACC",
    "macro_f1": "Macro-F1",
    "macro_f1_union": "Macro-F1 (union)",
    "ece": "ECE",
}


def latest(records: Iterable[Record]) -> list[Record]:
    """Return the newest record of every (method, source, seed), in order of first appearance."""
    found: dict[tuple[str, str, int], Record] = {}
    for record in records:
        found[record["method"], record["source"], record["seed"]] = record
    return list(found.values())


def methods(records: Sequence[Record]) -> dict[str, str]:
    """Return method -> label, in order of first appearance."""
    return {record["method"]: record["label"] for record in records}


def completed(records: Iterable[Record], method: str) -> list[Record]:
    """Return the records of a method that were not skipped."""
    return [r for r in records if r["method"] == method and "targets" in r]


def record_mean(record: Record, metric: str, which: str = "fused") -> float:
    """Return `target_mean` over a record's targets that have this reading."""
    scores = [target["scores"] for target in record["targets"].values()]
    return target_mean((found[which] for found in scores if which in found), metric)


def by_run(
    records: Iterable[Record], method: str, metric: str, which: str = "fused"
) -> dict[tuple[str, int], float]:
    """Return (source, seed) -> mean score over targets."""
    return {
        (one["source"], one["seed"]): record_mean(one, metric, which)
        for one in completed(records, method)
    }


def by_seed(values: Mapping[tuple[str, int], float], sources: Sequence[str]) -> list[float]:
    """Return the mean over sources for each seed that all sources have."""
    seeds = sorted({seed for _, seed in values})
    return [
        sum(values[source, seed] for source in sources) / len(sources)
        for seed in seeds
        if all((source, seed) in values for source in sources)
    ]


def changed_settings(record: Record) -> str:
    """Return the settings of a head's run that differ from the defaults, in the form of `--set`.

    Settings that the data determine are left out: classes and the widths of the encoders.
    """
    from omnivat.head.settings import HeadSettings
    from omnivat.training.settings import TrainSettings

    given, found = record.get("settings") or {}, []
    kinds: dict[str, Any] = {"head": HeadSettings, "train": TrainSettings}
    for part, kind in kinds.items():
        defaults = {f.name: f.default for f in fields(kind)}
        changed = {
            name: value
            for name, value in given.get(part, {}).items()
            if value != defaults.get(name)
        }
        found += [
            f"{n}={v}"
            for n, v in changed.items()
            if n not in {"classes", "input_width", "lang_width"}
        ]
    return " ".join(found)
