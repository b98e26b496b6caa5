"""Compare: two views side by side, linked; and every score from source to target."""

import json
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from app.resources import Resources
from omnivat.data.domains import paper_name
from omnivat.head.heads import EXAMPLES
from omnivat.kit.errors import DataError

if TYPE_CHECKING:
    import numpy as np

    from omnivat.data.store import Embeddings

    Array = np.ndarray[Any, Any]

TITLE = "Compare"
METHODS = {"nearest_mean": "nearest class mean"}  # fast to fit; slower ones are in the matrix
METRICS = ("accuracy", "macro_f1")
DRAWS = 2000  # of a bootstrap
RECORDS = tuple(EXAMPLES / "records" / f"{name}.jsonl.gz" for name in ("protocol_full", "protocol"))


def heads(resources: Resources) -> list[dict[str, Any]]:
    """Return name, structure, source and first order of each head, from settings.json; nothing heavy is loaded."""
    found = []
    for name, folder in resources.folders.items():
        try:
            record = json.loads((folder / "settings.json").read_text(encoding="utf-8"))
            settings, provenance = record["head"], record["provenance"]
            facts = {
                **{fact: settings[fact] for fact in ("generation", "mffa", "levels", "width")},
                "start": settings["order"],
                "source": str(provenance.get("source", "")),
                "seed": provenance.get("seed"),
            }
        except (OSError, ValueError, KeyError, TypeError):
            facts = {"problem": f"'{folder.name}' is not a head; see Data & limits."}
        found.append({"name": name, "folder": folder.name, **facts})
    return found


def predictions(resources: Resources, question: Mapping[str, Any]) -> dict[str, Any]:
    """Return the predictions of a comparison method, fitted on the head's source, for every pair.

    question  {"method": a name of METHODS}
    return    label, prediction (N,) as indices into `classes`, confidence (N,) 0 to 255, and
              `accuracy`, as `scores_of` has it

    Raises DataError for another method, or a set without the head's source domain.
    """
    method = question.get("method")
    if not isinstance(method, str) or method not in METHODS:
        raise DataError(f"No method is called {method!r:.40}; there are {', '.join(METHODS)}.")
    return resources.results.once(method, lambda: _fitted(resources, method))


def _fitted(resources: Resources, method: str) -> dict[str, Any]:
    import torch

    from omnivat.data.arrays import copied
    from omnivat.kit.tables import load
    from omnivat.study.baselines import BASELINES
    from omnivat.study.protocol.fitting import source_arrays
    from omnivat.study.protocol.methods import methods_named
    from omnivat.study.protocol.run import Run, task_of

    embeddings, source = resources.embeddings(), resources.head().source
    run = Run(method=methods_named([method], {}, {})[0], source=source, seed=0)
    task = task_of(run, embeddings)
    fitted = load(BASELINES, method, kind="baseline")(source_arrays(task, None, 0))
    vis, tac = (torch.from_numpy(copied(a)) for a in (embeddings.vis, embeddings.tac))
    with torch.inference_mode():
        confidence, predicted = fitted.predict(vis, tac)["fused"].max(1)
    return {
        "label": METHODS[method],
        "classes": list(task.classes),
        "set_classes": list(embeddings.header.classes),
        "prediction": predicted.tolist(),
        "confidence": (255 * confidence).round().int().tolist(),
        "accuracy": scores_of(embeddings, task.classes, source, predicted.numpy()),
        "pairs": len(task.train),
        "source": source,
    }


def scores_of(
    embeddings: "Embeddings", classes: Sequence[str], source: str, predicted: "Array"
) -> dict[str, float | None]:
    """Return the accuracy of predictions (N,) in each domain, and "unseen", the mean over unseen domains.

    Pairs of other classes than `classes` are left out, and training pairs from "unseen". None if no pair remains.
    """
    from omnivat.measure.evaluate import label_map
    from omnivat.measure.unseen import counted, mean_over_domains

    label = label_map(list(classes), embeddings.header.classes)[embeddings.label]
    right, known = predicted == label, label >= 0
    domains = embeddings.header.domains
    within = {name: known & (embeddings.domain == index) for index, name in enumerate(domains)}
    return {
        "unseen": mean_over_domains(right, embeddings, source, known & counted(embeddings, source)),
        **{name: float(right[own].mean()) if own.any() else None for name, own in within.items()},
    }


def matrix(resources: Resources) -> dict[str, Any]:
    """Return scores by source and target, and the paper's printed figures.

    return  `rows`: method, label, source, seeds, cells {target: [accuracy, macro-F1]} as shares;
            `ranking`: the methods in order, with intervals;
            `origin`: "protocol" or "heads"; `paper`: method -> source -> [ACC, F1] in percent;
            `why`: why the paper's are not comparable, "" if they are
    """
    return resources.results.once("matrix", lambda: _matrix(resources))


def _matrix(resources: Resources) -> dict[str, Any]:
    from omnivat.study.protocol.records import fingerprint
    from omnivat.study.reports.paper import BACKBONE, not_comparable, paper

    embeddings = resources.embeddings()
    header = embeddings.header
    runs = protocol_runs(fingerprint(embeddings))
    rows = protocol_rows(runs)
    own = [row for one in resources.heads if (row := head_row(resources, one))]
    sources = list(dict.fromkeys(row["source"] for row in (*rows, *own)))
    return {
        "rows": rows + own,
        "ranking": ranking(runs),
        "origin": "protocol" if rows else "heads",
        "targets": list(header.domains),
        "backbone": BACKBONE,
        "paper": {
            method: {source: printed[paper_name(source)] for source in sources if paper_name(source) in printed}
            for method, printed in paper()["main"][BACKBONE].items()
        },
        "why": not_comparable({"simulated": header.simulated, "encoder": header.encoder}),
    }


def head_row(resources: Resources, name: str) -> dict[str, Any] | None:
    """Return the row for the set's domains from a head's metrics.json, None without any."""
    domains = resources.embeddings().header.domains
    try:
        head = resources.head_named(name)
        cells = {
            str(record["domain"]): [record["scores"]["fused"]["accuracy"], record["scores"]["fused"]["macro_f1"]]
            for record in head.metrics.get("domains", [])
            if "fused" in record.get("scores", {}) and record["domain"] in domains
        }
    except (DataError, AttributeError, KeyError, TypeError):  # metrics.json may come from a visitor
        return None
    if not cells:
        return None
    label = f"head '{resources.folders[name].name}'"
    return {"method": name, "label": label, "source": head.source, "seeds": 1, "cells": cells}


def protocol_runs(content: str) -> dict[tuple[str, str], list[Mapping[str, Any]]]:
    """Return (method, source) -> runs of the protocol's records of embeddings with the fingerprint `content`.

    Heads of different widths are different methods.
    """
    from omnivat.study.protocol.records import read
    from omnivat.study.reports.reading import settled

    grouped: dict[tuple[str, str], list[Mapping[str, Any]]] = {}
    for record in (settled(record) for file in RECORDS for record in read(file)):
        if "targets" not in record or record["fold"] is not None:  # this method cannot learn it
            continue
        if record["data"]["fingerprint"] == content:
            label = record.get("label") or record["method"]
            width = record.get("settings", {}).get("head", {}).get("width")
            label += f", D = {width}" if width else ""
            grouped.setdefault((label, record["source"]), []).append(record)
    return grouped


def protocol_rows(runs: Mapping[tuple[str, str], Sequence[Any]]) -> list[dict[str, Any]]:
    """Return a row for each method and source, mean over seeds."""
    return [
        {"method": some[0]["method"], "label": label, "source": source, "seeds": len(some), "cells": mean_cells(some)}
        for (label, source), some in runs.items()
    ]


def ranking(runs: Mapping[tuple[str, str], Sequence[Any]]) -> list[dict[str, Any]]:
    """Return each method with several sources, best first: [mean, low, high] of accuracy and macro-F1.

    A mean over unseen domains, then over sources; 95 % intervals by drawing sources, then seeds. `seeds` is the
    standard deviation over seeds of one source, pooled over sources; None for one seed.
    """
    from omnivat.study.reports.intervals import bootstrap_interval, spread
    from omnivat.study.reports.reading import record_mean

    found = []
    for label in dict.fromkeys(label for label, _ in runs):
        own = {source: some for (name, source), some in runs.items() if name == label}
        if len(own) < 2:
            continue
        scores = [
            {source: [record_mean(one, metric) for one in runs] for source, runs in own.items()} for metric in METRICS
        ]
        intervals = [bootstrap_interval(one, draws=DRAWS) for one in scores]
        stds = [spread(values).std for values in scores[0].values() if len(values) > 1]
        seeds = (sum(std**2 for std in stds) / len(stds)) ** 0.5 if stds else None
        found.append({"label": label, "scores": [[one.mean, one.low, one.high] for one in intervals], "seeds": seeds})
    return sorted(found, key=lambda one: -one["scores"][0][0])


def mean_cells(runs: Sequence[Mapping[str, Any]]) -> dict[str, list[float]]:
    """Return target -> [accuracy, macro-F1], each the mean over runs with that target."""
    cells: dict[str, list[float]] = {}
    for target in dict.fromkeys(name for run in runs for name in run["targets"]):
        scores = [run["targets"][target]["scores"]["fused"] for run in runs if target in run["targets"]]
        cells[target] = [sum(score[metric] for score in scores) / len(scores) for metric in METRICS]
    return cells
