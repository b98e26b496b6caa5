"""Compare several embeddings of the same pairs: one record for a table, a figure, a file."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from omnivat.kit.errors import DataError
from omnivat.kit.progress import OnStep, Step, ignore
from omnivat.kit.threads import one_blas_thread, one_thread
from omnivat.measure.rungs import DRAWS
from omnivat.study.comparison.cost import cost_of
from omnivat.study.comparison.draws import LEAST, Draws, draws_of
from omnivat.study.comparison.matching import matched
from omnivat.study.comparison.probes import (
    COLUMNS,
    OF_NUMBERS,
    errors,
    numbers_in,
    rights,
    sources_of,
)
from omnivat.study.reports.bootstrap import Resampled, simultaneous
from omnivat.study.shift.measure import gaps
from omnivat.study.shift.reading import Features

GAP = "centroid"
Array = NDArray[Any]
Record = dict[str, Any]


def compare(
    sets: Mapping[str, Features],
    *,
    target: str = "",
    view: str = "",
    draws: int = DRAWS,
    seed: int = 0,
    cost: bool = True,
    on_step: OnStep = ignore,
) -> Record:
    """Return what linear maps of each set read right, at home and on sensors that they never met.

    sets    name -> features of the same pairs; the first is the one that others are compared with
    target  a column of numbers, such as a force: a ridge probe predicts it in place of classes
    view    "vis" or "tac": that image alone; "": all that every set has
    draws   of known pairs, over which results are averaged
    cost    also time each encoder of the project, for a picture

    If the pairs have a split, maps learn its training part and are tested on its test part. A cell
    has "value", "low" and "high"; "less", the difference to the first set with its paired interval;
    and "best": its lead over every other set is above 0, by intervals that hold together (max-t).
    Intervals draw objects, and domains if there are three or more, the same for all sets.

    Raises DataError for sets of other pairs, without a domain to learn, or without the numbers.

    >>> import numpy as np
    >>> from tempfile import TemporaryDirectory
    >>> from pathlib import Path
    >>> from omnivat import read_features
    >>> random = np.random.default_rng(0)
    >>> label = np.tile(np.arange(2), 40)
    >>> noise = random.normal(size=(80, 8))
    >>> names = {"material": label, "domain": ["A"] * 40 + ["B"] * 40}
    >>> with TemporaryDirectory() as folder:
    ...     sets = {}
    ...     for name, clear in (("noise", 0), ("clear", 4)):
    ...         file = Path(folder) / f"{name}.npz"
    ...         np.savez(file, tac=noise + clear * label[:, None], **names)
    ...         sets[name] = read_features(file)
    ...     found = compare(sets, draws=1, cost=False)
    >>> noise, clear = (one["cells"]["away"] for one in found["sets"])
    >>> clear["value"], clear["best"], noise["best"]
    (1.0, True, False)
    """
    if len(sets) < 2:
        raise DataError(f"{len(sets)} set came; give two or more of the same pairs.")
    sets = matched(sets, view)
    first = next(iter(sets.values()))
    values = numbers_in(first, target) if target else None
    if values is None and not first.labelled:
        raise DataError(
            "The pairs have no classes, so nothing can be read right; name a column of numbers with"
            " --target."
        )
    sources = _able(first, values)
    drawn, measured, gap_rows, costs = draws_of(first.embeddings, sources), {}, {}, {}
    total = len(sets) * (len(sources) + 1)
    with one_thread(), one_blas_thread():
        for k, (name, features) in enumerate(sets.items()):

            def show(source: str, k: int = k, name: str = name) -> None:
                done = k * (len(sources) + 1) + sources.index(source) + 1
                on_step(Step(done=done, total=total, text=f"{name}, {source}"))

            measured[name] = _measured(features, sources, values, drawn, draws, seed, show)
            gap_rows[name] = _gaps(features)
            costs[name] = cost_of(features.embeddings.header) if cost else None
            on_step(Step(done=(k + 1) * (len(sources) + 1), total=total, text=f"{name}, gaps"))
    data = first.embeddings
    enough = _enough(first)
    ids = list(dict.fromkeys(i for m in measured.values() for i in m))
    cells = {i: _cells({n: m[i] for n, m in measured.items()}, i, enough) for i in ids}
    return {
        "pairs": len(data),
        "domains": first.domains,
        "sources": sources,
        "view": first.views[-1],
        "target": target,
        "simulated": data.header.simulated,
        "drawn": ("domains and objects" if len(first.domains) >= LEAST else "objects")
        if enough
        else "",
        "draws": draws,
        "columns": [{"id": i, "title": _title(i)} for i in ids],
        "sets": [
            {
                "name": name,
                "encoder": features.embeddings.header.encoder,
                "preprocessing": features.embeddings.header.preprocessing,
                "width": features.embeddings.width,
                "lamps_from": max(features.embeddings.header.lit_by.values(), default=0),
                "cells": {i: cells[i][name] for i in ids},
                "gaps": gap_rows[name],
                "cost_ms": costs[name],
            }
            for name, features in sets.items()
        ],
    }


def predicted_numbers(features: Features, target: str, *, seed: int = 0) -> list[Record]:
    """Return R² and mean absolute error of a ridge probe of a column of numbers, by column of
    `compare`: records {"id", "title", "value", "low", "high"}.

    Raises DataError for a set without these numbers, or without a domain of ten that differ.
    """
    values = numbers_in(features, target)
    sources = _able(features, values)
    drawn = draws_of(features.embeddings, sources)
    with one_thread(), one_blas_thread():
        made = _measured(features, sources, values, drawn, DRAWS, seed, lambda _: None)
    enough = _enough(features)
    return [
        {"id": i, "title": _title(i), **_ends(resampled, enough)} for i, resampled in made.items()
    ]


def sentence(target: str, records: list[Record]) -> str:
    """Return `predicted_numbers` in words."""

    def words(entry: Record) -> str:
        ends = "" if entry["low"] is None else f" [{entry['low']:.2f}, {entry['high']:.2f}]"
        return f"{entry['title']} {entry['value']:.2f}{ends}"

    return f"{target}, predicted by ridge regression: {'; '.join(map(words, records))}."


def _able(features: Features, values: Array | None) -> list[str]:
    """Return the domains to learn. Raises DataError without one."""
    if sources := sources_of(features, values):
        return sources
    what = "two classes" if values is None else "differing numbers"
    raise DataError(f"No domain has ten pairs of {what}, so there is nothing to learn from.")


def _enough(features: Features) -> bool:
    """True if every domain has two objects, which intervals can draw."""
    objects = features.embeddings.objects
    return all(len(np.unique(objects[features.members(d)])) > 1 for d in features.domains)


def _measured(
    features: Features,
    sources: list[str],
    values: Array | None,
    drawn: Draws,
    draws: int,
    seed: int,
    show: Callable[[str], None],
) -> dict[str, Resampled]:
    """Return each finite column by its id: shares right, or R² and absolute error of a number."""
    how: dict[str, Any] = {"draws": draws, "seed": seed, "on_source": show}
    if values is None:
        made = rights(features, sources, **how)
        homes = {c.id: c.home for c in COLUMNS}
        found = {i: drawn.mean(table, home=homes[i]) for i, table in made.items()}
    else:
        found = {}
        for column, (squares, sizes) in (
            (c, table)
            for c, table in zip(
                OF_NUMBERS, errors(features, sources, values, **how).values(), strict=True
            )
        ):
            found[f"{column.id}:r2"] = drawn.explained(squares, values, home=column.home)
            found[f"{column.id}:mae"] = drawn.mean(sizes, home=column.home)
    return {i: r for i, r in found.items() if np.isfinite(r.value)}


def _title(column: str) -> str:
    plain, _, kind = column.partition(":")
    title = next(c.title for c in COLUMNS if c.id == plain)
    return title + {"r2": ", R²", "mae": ", mean absolute error", "": ""}[kind]


def _cells(of: Mapping[str, Resampled], column: str, enough: bool) -> dict[str, Record]:
    """Return a column: each value with its interval, the difference to the first, and the best."""
    sign = -1 if column.endswith(":mae") else 1
    first = next(iter(of.values()))
    lead = max(of, key=lambda name: sign * of[name].value)
    others = {(name, ""): resampled for name, resampled in of.items() if name != lead}
    leads = simultaneous(of[lead], others) if enough else {}
    sure = enough and all((less.low if sign > 0 else -less.high) > 0 for less in leads.values())
    return {
        name: {
            **_ends(resampled, enough),
            "less": _ends(resampled.less(first), enough) if resampled is not first else None,
            "best": bool(sure and name == lead),
        }
        for name, resampled in of.items()
    }


def _ends(resampled: Resampled, enough: bool) -> Record:
    if not enough:
        return {"value": resampled.value, "low": None, "high": None}
    low, high = np.quantile(resampled.draws, [0.025, 0.975])
    return {"value": resampled.value, "low": float(low), "high": float(high)}


def _gaps(features: Features) -> Record:
    """Return both gaps by the distance of centroids, each with its floor."""
    records = gaps(features, ignore, (GAP,))
    found = {
        r["modality"]: r for r in records if "gap" in r["part"] and r["note"].startswith("mean,")
    }
    floors = {r["modality"]: r["value"] for r in records if r["part"] == "no gap"}
    both = list(floors.values())
    return {
        ("between modalities" if not m else f"between domains, {m}"): {
            **{key: r[key] for key in ("value", "low", "high")},
            "floor": floors.get(m, float(np.mean(both)) if both else None),
        }
        for m, r in found.items()
    }
