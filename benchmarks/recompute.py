"""Compute the figures of the README and of the documents again, from the records alone.

    python -m benchmarks.recompute

It imports nothing of omnivat, so a mistake in the reports cannot repeat itself here: every share
comes from stored predictions, every interval from draws of its own. It prints how many figures it
compared and the largest deviation, and ends with 1 if a printed figure is not the recomputed one.
"""

import gzip
import json
import re
import sys
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from statistics import fmean
from typing import Any

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
RECORDS = ROOT / "examples" / "records"
TIMES = ROOT / "docs" / "benchmarks"
ROUNDING = 0.0501  # points
LUCK = 0.6  # points that other draws of a bootstrap may move a limit
DRAWS = 3000
NUMBER = r"[+-]?\d+\.\d"
METHODS = {  # row of the README -> method of the records
    "Linear maps of photo, touch and both": "linear_maps",
    "Logistic regression (the map of both alone)": "logistic",
    "OmniVaT, the page's recipe": "omnivat",
    "OmniVaT's tree alone (DTG)": "dtg",
    "ERM-MLP": "erm_mlp",
    "Nearest class mean": "nearest_mean",
    "VT CMC, head alone": "vt_cmc_head",
    "LDC, logit de-confusion alone": "ldc_icd",
    "The paper's Baseline and PromptStyler row": "baseline",
    "SITR's head, touch alone": "sitr_supcon",
}
RUNGS = ("none", "n5", "n20", "k5")
Cells = dict[str, dict[str, list[float]]]  # source -> target -> accuracy (%) of each seed


class Count:
    """Compared figures, the largest deviation, and the figures that are wrong."""

    def __init__(self) -> None:
        self.number, self.largest, self.wrong = 0, 0.0, list[str]()

    def compare(self, what: str, printed: float, measured: float, room: float = ROUNDING) -> None:
        """Note one figure; a printed one may be off by its rounding."""
        self.number += 1
        self.largest = max(self.largest, abs(printed - measured))
        if not abs(printed - measured) <= room:
            self.wrong.append(f"{what}: printed {printed}, recomputed {measured:.3f}")

    def text(self, what: str, printed: str, measured: Sequence[float]) -> None:
        """Compare a mean, or "+3.9 [2.2, 6.1]" with a mean and its limits."""
        numbers = [float(n) for n in re.findall(NUMBER, printed)]
        for n, (value, wanted) in enumerate(zip(numbers, measured, strict=True)):
            self.compare(what, value, wanted, LUCK if n else ROUNDING)


def lines(file: Path) -> Iterator[Any]:
    """Yield the objects of a compressed file of JSON lines."""
    yield from map(json.loads, gzip.decompress(file.read_bytes()).decode().splitlines())


def document(name: str) -> str:
    """Return a document's text, with plain minus signs, without bold, on one line a paragraph."""
    text = (ROOT / name).read_text(encoding="utf-8").replace("−", "-").replace("**", "")
    return re.sub(r"(?<=[^\n|])\n(?=[^\n|#`-])", " ", text)


def table(text: str, head: str) -> dict[str, list[str]]:
    """Return the rows of the table whose first line begins with `head`: first cell -> others."""
    rows = text[text.index(head) :].split("\n\n")[0].splitlines()[2:]
    cells = [[cell.strip() for cell in row.strip("| ").split(" | ")] for row in rows]
    return {row[0]: row[1:] for row in cells}


# the table


def cells_of(wanted: str) -> dict[str, Cells]:
    """Return method -> source -> target -> accuracy of each seed on a rung."""
    first, *runs = lines(RECORDS / "ladder.jsonl.gz")
    found: Any = defaultdict(lambda: defaultdict(lambda: defaultdict(list)))
    for run in sorted(runs, key=lambda run: run["seed"]):
        home = first["domains"].index(run["source"])
        known = {c for c, d in zip(first["truth"], first["domain"], strict=True) if d == home}
        right = defaultdict(list)
        for said, truth, place in zip(
            run["answers"].get(wanted, ""), first["truth"], first["domain"], strict=False
        ):
            if said != "." and truth in known and (place == home) == (wanted == "home"):
                right[place].append(said == truth)
        for place, hits in right.items():
            found[run["method"]][run["source"]][place].append(100 * fmean(hits))
    return dict(found)


def mean_of(cells: Cells) -> float:
    """Return the mean over sources of the mean over targets and seeds."""
    return fmean(fmean(fmean(seeds) for seeds in targets.values()) for targets in cells.values())


def drawn(cells: Cells) -> tuple[float, float, float]:
    """Return mean and 95 % limits: sources, then targets, then seeds are drawn."""
    random = np.random.default_rng(77)
    of_source = []
    for targets in cells.values():
        values = np.array(list(targets.values()))
        rows = random.integers(len(values), size=(DRAWS, len(values), 1))
        columns = random.integers(values.shape[1], size=(DRAWS, 1, values.shape[1]))
        of_source.append(values[rows, columns].mean((1, 2)))
    table = np.array(of_source)
    some = random.integers(len(table), size=(DRAWS, len(table)))
    means = table[some, random.integers(DRAWS, size=some.shape)].mean(1)
    low, high = np.quantile(means, (0.025, 0.975))
    return mean_of(cells), float(low), float(high)


def minus(ours: Cells, theirs: Cells) -> Cells:
    """Return paired differences, over the seeds that both have."""
    return {
        source: {
            place: [a - b for a, b in zip(seeds, theirs[source][place], strict=False)]
            for place, seeds in targets.items()
        }
        for source, targets in ours.items()
    }


def check_table(count: Count) -> None:
    """Compare the README's tables and its finding on pictures without labels."""
    text = document("README.md")
    by_rung = {rung: cells_of(rung) for rung in RUNGS}
    rows = table(text, "| method | seeds")
    for name in rows:
        seeds, *shares, several, _, _ = rows[name]
        method = METHODS[name]
        for rung, cell in zip(RUNGS, shares, strict=True):
            count.text(f"README, {name}, {rung}", cell, drawn(by_rung[rung][method]))
        own = next(iter(by_rung["none"][method].values()))
        count.compare(f"README, {name}, seeds", float(seeds), len(next(iter(own.values()))), 0)
        if several != "–":
            joint = by_rung["none"][f"{method}_mean"]
            count.compare(f"README, {name}, averaged", float(several.split()[0]), mean_of(joint))
    for name, cells in table(text, "| OmniVaT minus").items():
        for rung, cell in zip(RUNGS, cells, strict=False):
            less = minus(by_rung[rung]["omnivat"], by_rung[rung][METHODS[name]])
            count.text(f"README, OmniVaT minus {name}, {rung}", cell, drawn(less))
    said = re.search(
        rf"({NUMBER}) % as it comes, ({NUMBER}) with 5 pictures, ({NUMBER}) with 20", text
    )
    assert said, "the README has no finding on pictures of a new sensor"
    for printed, rung in zip(said.groups(), RUNGS, strict=False):
        maps = by_rung[rung]["linear_maps"]
        count.compare(f"README, linear maps, {rung}", float(printed), mean_of(maps))


def check_twins(count: Count) -> None:
    """Compare the README's first finding with what the page shows of the twins."""
    record = json.loads((ROOT / "examples" / "twins.json").read_text(encoding="utf-8"))
    said = re.search(
        r"(\d+) % on the sensor that it learned, (\d+) on seven others; with the dots filled (\d+)"
        r" and (\d+)",
        document("README.md"),
    )
    assert said, "the README has no finding on dots"
    for dots in (0, 1):
        home, away = (record[key]["touch"][0][dots][0] for key in ("accuracy", "away"))
        for printed, share in zip(said.groups()[2 * dots :], (home[0][0], away[0]), strict=False):
            count.compare(f"README, twins, dots {dots}", float(printed), 100 * share, 0.5)


# the transform


def check_transform(count: Count) -> None:
    """Compare the README's speeds and errors of the transform with their records."""
    rows = json.loads((TIMES / "fractional.json").read_text())["rows"]
    worst = json.loads((TIMES / "stability.json").read_text())
    text = document("README.md").partition("The transform itself")[2]
    for ratio, size in zip(
        re.findall(r"(\d[\d.]*)×", text), re.findall(r"at ([\d,]+) × (\d+)", text), strict=True
    ):
        shape = [int(side.replace(",", "")) for side in size]
        own = [
            r
            for r in rows
            if r["task"] == "new p" and r["threads"] == 1 and [r["rows"], r["size"]] == shape
        ]
        ms = {r["method"]: r["time"]["median"] for r in own}
        found = ms["torch-frft dfrft"] / ms["omnivat float32"]
        count.compare(f"README, {shape}", float(ratio), found, 0.5 if found > 10 else ROUNDING)
    printed = float(text.partition("errors up to ")[2].split()[0])
    found = max(
        r["error"] for r in worst if r["dtype"] == "float64" and r["check"].startswith("p ")
    )
    count.compare("README, error of the transform", 1e15 * printed, 1e15 * found)


def main() -> None:
    """Compare everything and print the counts."""
    checks: Mapping[str, Callable[[Count], None]] = {
        "the table of results": check_table,
        "the twins": check_twins,
        "the transform": check_transform,
    }
    failed = False
    for title, check in checks.items():
        count = Count()
        check(count)
        print(f"{title}: {count.number} figures, largest deviation {count.largest:.3f}")
        print(*count.wrong, sep="\n", end="\n" if count.wrong else "")
        failed |= bool(count.wrong)
    sys.exit(failed)


if __name__ == "__main__":
    main()
