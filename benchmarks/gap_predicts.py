"""Does a smaller gap predict a better head? Rank correlations over everything that is recorded.

    python -m benchmarks.gap_predicts [--out docs/benchmarks]

Between heads: 21 heads of each shipped set, each trained at one p (`trained.bin`). Within a head: p moved
under fixed weights (`frames.bin`, `every.bin`); and over the unseen domains at one p. Between methods:
every run of the protocol, by source. Retrieval: the heads of the ladder's records. Nothing is trained here.
"""

import argparse
import json
from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.stats import rankdata, spearmanr

from omnivat import figures
from omnivat.head.heads import LADDERS
from omnivat.kit.files import write_text
from omnivat.kit.lines import lines
from omnivat.maps.frames.file import frames_header
from omnivat.measure.ladder import FORMAT, letters, marks
from omnivat.study.protocol.records import read
from omnivat.study.reports.reading import settled

EXAMPLES = Path("examples")
SETS = {"sensors": EXAMPLES, "chirps": EXAMPLES / "chirps"}
FILES = {
    "trained.bin": "between heads, one trained at each p",
    "every.bin": "within a head for every p",
    "frames.bin": "within a head, p moved",
}
MEASURES = {
    "modality_gap": "modality gap",
    "domain_gap": "domain gap",
    "margin": "class margin",
    "margin:cross_modal": "class margin, photo to touch",
}
OUTCOMES = ("accuracy", "own touch ranks first", "class of the nearest touch")
RETRIEVED = (
    "Light heads by the page's recipe (`python -m benchmarks.ladder`), nothing known of the target; each image with the other "
    "one absent. Ranks are of a photo's own touch among the touches of its domain, by cosine. If small gaps made good "
    "retrieval, the figures would be near −1."
)
STAGES, DRAWS = ("relu", "f_bar", "f_hat"), 2000
Array = NDArray[np.float64]
Found = tuple[float, float, float]


def agreement(x: Array, y: Array) -> Array:
    """Return Pearson's correlation along the last axis; 0 if one side is constant."""
    x, y = x - x.mean(-1, keepdims=True), y - y.mean(-1, keepdims=True)
    both = np.sqrt((x * x).sum(-1) * (y * y).sum(-1))
    found: Array = np.where(both > 1e-12, (x * y).sum(-1) / np.maximum(both, 1e-12), 0.0)
    return found


def interval(units: int, of: Callable[[NDArray[np.int64]], Array]) -> Found:
    """Return a statistic and its 95 % percentile interval over redrawn units.

    of  rows (B, units) -> (B,)
    """
    drawn = of(np.random.default_rng(0).integers(units, size=(DRAWS, units)))
    low, high = np.quantile(drawn, [0.025, 0.975])
    return float(of(np.arange(units)[None])[0]), float(low), float(high)


def along_stops(curves: Mapping[str, Any]) -> dict[str, dict[str, Found]]:
    """Return stage -> measure -> correlation with accuracy in unseen domains, over stops."""
    right = rankdata(curves["accuracy/unseen"])

    def one(name: str) -> Found:
        ranks = rankdata(curves[name])
        return interval(len(right), lambda rows: agreement(ranks[rows], right[rows]))

    return {stage: {name: one(f"{name}/{stage}") for name in MEASURES} for stage in STAGES}


def over_domains(header: Mapping[str, Any], source: str) -> Found:
    """Return the mean over heads of the correlation, over unseen domains, of gap and accuracy."""
    curves = header["curves"]
    names = [d for d in header["domains"] if d != source]
    gaps = rankdata([curves[f"modality_gap/f_hat/{d}"] for d in names], axis=0).T
    right = rankdata([curves[f"accuracy/{d}"] for d in names], axis=0).T
    return interval(len(names), lambda rows: agreement(gaps[:, rows], right[:, rows]).mean(0))


def between_methods() -> dict[str, Found]:
    """Return margin -> mean over sources of its correlation with accuracy, over methods."""
    cells: dict[str, dict[str, list[tuple[float, float]]]] = defaultdict(lambda: defaultdict(list))
    pooled: dict[tuple[str, str, str], list[tuple[float, float]]] = defaultdict(list)
    for record in map(settled, read(EXAMPLES / "records" / "protocol_full.jsonl.gz")):
        for target in record.get("targets", {}).values():
            for kind, margin in target["margins"].items():
                reading = "fused" if kind == "pair" else kind
                if margin is not None:
                    key = (kind, record["source"], record["method"])
                    pooled[key].append((margin, target["scores"][reading]["accuracy"]))
    for (kind, source, _), pairs in pooled.items():
        cells[kind][source].append(tuple(np.mean(pairs, axis=0)))
    found = {}
    for kind, by_source in cells.items():
        values = np.array([spearmanr(*np.array(p).T).statistic for p in by_source.values()])
        found[kind] = interval(len(values), partial(_mean, values))
    return found


def retrieval() -> dict[str, dict[str, dict[str, Found]]]:
    """Return comparison -> "gap, stage" -> outcome -> correlation, over the ladder's heads.

    Over domains: unseen domains of one head; the mean over heads, its interval over sources.
    Between heads: heads of all other sources in one domain; the mean and its interval over domains.
    """
    first, *runs = lines(LADDERS, FORMAT)
    truth, domain = letters(first["truth"]), np.array(first["domain"])
    cells = []  # (source, target, head, stage) and its values
    for number, run in enumerate(one for one in runs if "space" in one):
        right = marks(run["answers"]["none"], truth)
        taught = np.isin(truth, truth[domain == first["domains"].index(run["source"])])
        for target, stages in run["space"].items():
            if target != run["source"]:
                own = taught & (domain == first["domains"].index(target))
                for stage, (modality, gap, rank, found) in stages.items():
                    values = (modality, gap, float(np.nanmean(right[own])), 1 - rank, found)
                    cells.append((run["source"], target, number, stage, values))

    def over(group: int, unit: int) -> dict[str, dict[str, Found]]:
        table: dict[str, dict[str, Found]] = {}
        for stage in STAGES:
            own = [c for c in cells if c[3] == stage]
            units = list(dict.fromkeys(c[unit] for c in own))
            for column, gap in enumerate(("modality gap", "domain gap")):
                row = table.setdefault(f"{gap}, {stage}", {})
                for place, outcome in enumerate(OUTCOMES, start=2):
                    each = []
                    for name in units:
                        groups = dict.fromkeys(c[group] for c in own if c[unit] == name)
                        each.append(
                            np.mean(
                                [
                                    spearmanr(
                                        *np.array([c[4] for c in own if c[unit] == name and c[group] == g]).T[
                                            [column, place]
                                        ]
                                    ).statistic
                                    for g in groups
                                ]
                            )
                        )
                    row[outcome] = interval(len(each), partial(_mean, np.array(each)))
        return table

    return {"over unseen domains, within a head": over(2, 0), "between heads, in one domain": over(1, 1)}


def _mean(values: Array, rows: NDArray[np.int64]) -> Array:
    found: Array = values[rows].mean(-1)
    return found


def text(found: Found) -> str:
    """Return "+0.13 [-0.30, 0.52]"."""
    return f"{found[0]:+.2f} [{found[1]:.2f}, {found[2]:.2f}]"


def report(found: Mapping[str, Any]) -> str:
    """Return the tables as Markdown."""
    parts = ["# Does a smaller gap predict a better head?", __doc__.split("\n\n")[2]]
    parts.append(
        "Spearman's rank correlation with accuracy in unseen domains; brackets hold 95 % percentile "
        "intervals over redrawn stops, domains or sources (ranked once). If small gaps made good heads, the gaps' "
        "figures would be near −1. Stops of one head are not independent, so its intervals are too narrow."
    )
    for name, kinds in found["stops"].items():
        parts.append(f"## {name.capitalize()}")
        rows = [f"| what varies | stage | {' | '.join(MEASURES.values())} |", "| --- " * 6 + "|"]
        for kind, stages in kinds.items():
            for stage, cells in stages.items():
                rows.append(f"| {kind} | {stage} | {' | '.join(map(text, cells.values()))} |")
        parts.append("\n".join(rows))
    lines = [f"- {name}: {text(v)}" for name, v in found["domains"].items()]
    parts += ["## Over unseen domains, within a head: modality gap", "\n".join(lines)]
    lines = [f"- {kind}: {text(v)}" for kind, v in found["methods"].items()]
    parts += ["## Over methods of the protocol, within a source: cosine margin", "\n".join(lines)]
    parts += ["## Retrieval", RETRIEVED]
    for name, gaps in found["retrieval"].items():
        rows = [f"| {name} | {' | '.join(OUTCOMES)} |", "| --- " * 4 + "|"]
        for gap, outcomes in gaps.items():
            rows.append(f"| {gap} | {' | '.join(map(text, outcomes.values()))} |")
        parts.append("\n".join(rows))
    return "\n\n".join([*parts, "![Gap and margin against accuracy](gap_predicts.svg)"]) + "\n"


def drawn(headers: Mapping[str, Mapping[str, Any]]) -> Any:
    """Return gap and margin at F̂ against accuracy, a dot for each head."""
    rows, count = [], 0
    for name, header in headers.items():
        count = len(header["curves"]["accuracy/unseen"])
        right = 100 * np.array(header["curves"]["accuracy/unseen"])
        rows.append(
            [
                {
                    "x": np.array(header["curves"][f"{measure}/f_hat"]),
                    "y": right,
                    "across": MEASURES[measure],
                    **({} if column else {"up": f"{name}, ACC in %"}),
                }
                for column, measure in enumerate(list(MEASURES)[:3])
            ]
        )
    return figures.panels(
        rows,
        title="Gap and margin against accuracy",
        caption=f"A dot for each of {count} heads, one trained at each p. Across: at F̂, over all domains. Up: accuracy in the domains that the head did not see.",
    )


def measured(headers: Mapping[str, Mapping[str, Mapping[str, Any]]]) -> dict[str, Any]:
    """Return every correlation, from set -> file -> header."""
    return {
        "stops": {
            name: {FILES[file]: along_stops(h["curves"]) for file, h in files.items()}
            for name, files in headers.items()
        },
        "domains": {
            name: over_domains(files["trained.bin"], files["trained.bin"]["head"]["source"])
            for name, files in headers.items()
        },
        "methods": between_methods(),
        "retrieval": retrieval(),
    }


def main(given: Sequence[str] | None = None) -> None:
    """Measure, print, and write the tables, the record and the figure."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--out", type=Path, default=Path("docs/benchmarks"))
    options = parser.parse_args(given)
    headers = {name: {file: frames_header(folder / file) for file in FILES} for name, folder in SETS.items()}
    found = measured(headers)
    write_text(options.out / "gap_predicts.json", json.dumps(found, indent=1) + "\n")
    write_text(options.out / "gap_predicts.md", report(found))
    own = {n: files["trained.bin"] for n, files in headers.items()}
    figures.write(options.out / "gap_predicts.svg", drawn(own))
    print(report(found))


if __name__ == "__main__":
    main()
