"""Tables and figure of the ladder, from its records alone: docs/benchmarks/ladder.md and ladder.svg.

    python -m benchmarks.ladder_table [--records FILE] [--out docs/benchmarks]

A cell is the mean over sources of the mean over unseen domains, in percent. A gain is paired with the same method
and source as it comes; its 95 % interval is a bootstrap over sources, then seeds.
"""

import argparse
from collections import defaultdict
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import torch

from omnivat.data.packing import unodds
from omnivat.figures.scores import ladder
from omnivat.figures.still import svg_of
from omnivat.head.heads import LADDERS
from omnivat.kit.files import write_text
from omnivat.kit.lines import lines
from omnivat.measure.gaps.calibration import ece, nll
from omnivat.measure.ladder import FORMAT, KNOWN, METHOD, letters, marks
from omnivat.study.reports.intervals import Interval, bootstrap_interval

NAMES = {
    METHOD: "OmniVaT, D = 64",
    "logistic": "Logistic regression",
    "nearest_mean": "Nearest class mean",
    "erm_recipe": "ERM-MLP, the page's recipe",
    "erm_mlp": "ERM-MLP",
    "linear_probe": "Linear probe, late fusion",
    "vt_cmc_head": "VT CMC-head",
    "ldc_icd": "LDC-ICD",
    "logistic_recipe": "Logistic regression, the page's recipe",
    "dtg_recipe": "DTG alone, the page's recipe",
    "dtg_soft": "DTG alone, 3 heads",
    "omnivat_soft": "OmniVaT, 3 heads",
    "distilled": "OmniVaT, 3 heads in one",
    "erm_soft": "ERM-MLP, 3 heads",
    "logistic_soft": "Logistic regression, 3 fits",
}
BUDGETS = {  # OmniVaT first; every other row has the same data, noise, imitated sensors and heads
    "one head": ("omnivat", "dtg_recipe", "erm_recipe", "logistic_recipe"),
    "three heads": ("omnivat_soft", "distilled", "dtg_soft", "erm_soft", "logistic_soft"),
}
SEEN = ("none", "n5", "n20")
Shares = dict[str, dict[str, dict[str, list[float]]]]  # method -> rung -> source -> seeds


def shares(records: Path) -> Shares:
    """Return accuracy (%) of every method, rung, source and seed: the mean over unseen domains."""
    first, *runs = lines(records, FORMAT)
    runs.sort(key=lambda run: run["seed"])
    truth, domain = letters(first["truth"]), np.array(first["domain"])
    found: Shares = defaultdict(lambda: defaultdict(lambda: defaultdict(list)))
    for run in runs:
        home = first["domains"].index(run["source"])
        known = np.isin(truth, truth[domain == home])  # classes that the source has
        apart: dict[str, list[float]] = defaultdict(list)
        for rung, answers in run["answers"].items():
            right = np.where(known, marks(answers, truth), np.nan)
            each = [right[domain == d] for d in np.unique(domain) if (d == home) == (rung == "home")]
            seen = [float(np.nanmean(rows)) for rows in each if not np.isnan(rows).all()]
            if seen:
                apart[rung.partition(":")[0]].append(100 * float(np.mean(seen)))
        for rung, values in apart.items():  # one class only: the mean over classes
            found[run["method"]][rung][run["source"]].append(float(np.mean(values)))
    return found


def gain(found: Mapping[str, Mapping[str, list[float]]], rung: str) -> Any:
    """Return the gain of a rung over nothing known, in points, with its interval; same seeds."""
    own = found[rung]
    return less(own, {s: values[: len(own[s])] for s, values in found["none"].items()})


def confidence(records: Path) -> Mapping[str, tuple[float, float]]:
    """Return ECE (%) and NLL (nats) by method, as it comes: mean over unseen domains, seeds, sources."""
    first, *runs = lines(records, FORMAT)
    truth, domain = letters(first["truth"]), np.array(first["domain"])
    found: dict[str, dict[str, list[Any]]] = defaultdict(lambda: defaultdict(list))
    for run in (one for one in runs if "odds" in one):
        home = first["domains"].index(run["source"])
        known = np.isin(truth, truth[domain == home])
        shares = torch.from_numpy(unodds(run["odds"], len(first["classes"])))
        places = [known & (domain == d) for d in np.unique(domain) if d != home]
        cells = [
            (100 * ece(shares[rows], torch.from_numpy(truth[rows])), nll(shares[rows], torch.from_numpy(truth[rows])))
            for rows in places
            if rows.any()
        ]
        found[run["method"]][run["source"]].append(np.mean(cells, axis=0))
    return {
        name: tuple(np.mean([np.mean(runs, axis=0) for runs in own.values()], axis=0)) for name, own in found.items()
    }


def best_heads(found: Shares, odds: Mapping[str, tuple[float, float]]) -> list[str]:
    """Return the lines on OmniVaT against others with the same budget; empty without such rows."""
    text = [
        "## The best head with the same budget",
        "",
        "Every row has the page's recipe: standardised input, noise, imitated sensors. Logistic regression, which is",
        "solved, has four such copies of each pair. Accuracy (%), then OmniVaT (the first row) minus the row, in points, with",
        "a 95 % interval (bootstrap over sources, then seeds; test objects as they are). ECE in percent and NLL in nats from the",
        "recorded odds, as they come, before any temperature.",
        "",
        f"| budget | method | {' | '.join(KNOWN[r] for r in SEEN)} | ECE | NLL |",
        "| --- | --- |" + " ---: |" * (len(SEEN) + 2),
    ]
    start = len(text)
    for budget, names in BUDGETS.items():
        if names[0] not in found:
            continue
        for name in (n for n in names if n in found):
            cells = [_beside(found, names[0], name, rung) for rung in SEEN]
            numbers = "{:.1f} | {:.2f}".format(*odds[name])
            text.append(f"| {budget} | {NAMES[name]} | {' | '.join(cells)} | {numbers} |")
    return [*text, ""] if len(text) > start else []


def _beside(found: Shares, ours: str, name: str, rung: str) -> str:
    mean = f"{np.mean([np.mean(values) for values in found[name][rung].values()]):.1f}"
    if name == ours or set(found[name][rung]) != set(found[ours][rung]):
        return mean
    one = less(found[ours][rung], found[name][rung])
    return f"{mean}<br>{one.mean:+.1f} ({one.low:+.1f} to {one.high:+.1f})"


def less(ours: Mapping[str, list[float]], theirs: Mapping[str, list[float]]) -> Interval:
    """Return ours minus theirs, paired by source, and by seed where both have as many."""
    return bootstrap_interval(
        {
            s: (
                [a - b for a, b in zip(ours[s], theirs[s], strict=True)]
                if len(ours[s]) == len(theirs[s])
                else [float(np.mean(ours[s]) - np.mean(theirs[s]))]
            )
            for s in ours
        }
    )


def table(found: Shares, odds: Mapping[str, tuple[float, float]]) -> str:
    """Return the report as Markdown."""
    methods = [name for name in NAMES if name in found]
    text = [
        "# The ladder",
        "",
        "`python -m benchmarks.ladder` wrote the records, `python -m benchmarks.ladder_table` this page, and",
        "`python -m benchmarks.ladder_check` computes its figures again in another way. Simulated sensors only.",
        "",
        "Accuracy (%), both images, test objects, mean over sources of the mean over unseen domains; below it the",
        "gain over *as they come* with a 95 % interval (bootstrap over sources, then seeds). Every method is trained",
        "on embeddings standardised by its source's profile. **Only the first row is domain generalisation**; all",
        "others know something of the target. " + _done(found, methods),
        "",
        "| what is known of the target | " + " | ".join(NAMES[name] for name in methods) + " |",
        "| --- |" + " ---: |" * len(methods),
    ]
    for rung, words in KNOWN.items():
        if any(rung in found[name] for name in methods):
            cells = [_cell(found[name], rung) for name in methods]
            text.append(f"| {words} | " + " | ".join(cells) + " |")
    text += ["", *best_heads(found, odds), "## By source", ""]
    for name in methods:
        rungs = [r for r in ("home", "none", "n1", "n5", "n20", "one", "all") if r in found[name]]
        text += [
            f"**{NAMES[name]}**",
            "",
            "| source | " + " | ".join(KNOWN[r] for r in rungs) + " |",
            "| --- |" + " ---: |" * len(rungs),
        ]
        for source in found[name]["none"]:
            cells = [f"{np.mean(found[name][r][source]):.1f}" for r in rungs]
            text.append(f"| {source} | " + " | ".join(cells) + " |")
        text.append("")
    return "\n".join(text)


def _done(found: Shares, methods: list[str]) -> str:
    parts = []
    for name in methods:
        own = found[name]["none"]
        runs = sum(map(len, own.values()))
        parts.append(f"{NAMES[name]}: {len(own)} sources, {runs} runs")
    return "Runs: " + "; ".join(parts) + "."


def _cell(found: Mapping[str, Mapping[str, list[float]]], rung: str) -> str:
    if rung not in found:
        return "–"
    mean = float(np.mean([np.mean(values) for values in found[rung].values()]))
    if rung in ("home", "none") or set(found[rung]) != set(found["none"]):
        return f"{mean:.1f}"
    one = gain(found, rung)
    return f"{mean:.1f}<br>{one.mean:+.1f} ({one.low:+.1f} to {one.high:+.1f})"


def picture(found: Shares) -> str:
    """Return the figure as SVG: accuracy of every rung, with intervals over sources."""
    records = []
    for rung, words in KNOWN.items():
        for name in NAMES:
            if name not in found or rung not in found[name]:
                continue
            own = {s: [v / 100 for v in values] for s, values in found[name][rung].items()}
            one = bootstrap_interval(own)
            records.append(
                {"known": words, "accuracy": one.mean, "low": one.low, "high": one.high, "method": NAMES[name]}
            )
    return svg_of(ladder(records))


def main() -> None:
    """Write both files."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--records", type=Path, default=LADDERS, help="of benchmarks.ladder")
    parser.add_argument("--out", type=Path, default=Path("docs/benchmarks"), help="folder")
    options = parser.parse_args()
    found = shares(options.records)
    text = table(found, confidence(options.records))
    write_text(options.out / "ladder.md", text + "\n")
    write_text(options.out / "ladder.svg", picture(found))
    print(text)


if __name__ == "__main__":
    main()
