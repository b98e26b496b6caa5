"""Look values up in records: by method, source and seed."""

from collections import Counter
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
    return [settled(record) for record in found.values()]


def settled(record: Record) -> Record:
    """Return a record whose reading "fused" is the mean fusion, and "chosen" the chosen one.

    In records of format 1, "fused" is the chosen fusion. Methods that fuse features have no
    "chosen".
    """
    targets, kind = record.get("targets", {}), record.get("chosen", {}).get("fusion")
    if not any(target.get("fusions") for target in targets.values()):
        return record
    old = record.get("format") == "omnivat-run-1"
    found = {name: _settled(target, kind, old) for name, target in targets.items()}
    test = record.get("source_test")
    tests = {"source_test": _settled(test, kind, old)} if test else {}
    return {**record, "targets": found, **tests}


def _settled(target: Record, kind: str | None, old: bool) -> Record:
    scores, answers = dict(target["scores"]), dict(target.get("answers", {}))
    for name, fusion in (("chosen", kind), ("fused", "mean" if old else None)):
        if fusion in target.get("fusions", {}):
            scores[name] = target["fusions"][fusion]
            if f"fusion:{fusion}" in answers:
                answers[name] = answers[f"fusion:{fusion}"]
                scores[name] = {**scores[name], "macro_f1_union": _union(target, answers[name])}
    return {**target, "scores": scores} | ({"answers": answers} if answers else {})


def _union(target: Record, predicted: str) -> float:
    """Return Macro-F1 over all classes that are present or predicted."""
    right = Counter(a for a, b in zip(target["truth"], predicted, strict=True) if a == b)
    counts = Counter(target["truth"]) + Counter(predicted)
    return sum(2 * right[name] / count for name, count in counts.items()) / len(counts)


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
