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
from functools import cache
from pathlib import Path
from statistics import fmean
from typing import Any

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
RECORDS = ROOT / "examples" / "records"
TIMES = ROOT / "docs" / "benchmarks"
ROUNDING = 0.0501  # points
LUCK = 0.6  # points that other draws of a bootstrap may move a limit
DRAWS = 4_000
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
LIT = {  # column of the table by relief -> its rung, and that of colours that know as much
    "home": ("home", "home"),
    "as it comes": ("none", "none"),
    "lamps of 5": ("l5", "none"),
    "lamps and profile of 5": ("n5", "n5"),
    "lamps of 20": ("l20", "none"),
    "lamps and profile of 20": ("n20", "n20"),
    "5 labels a class": ("k5", "k5"),
    "touch, as it comes": ("tac", "tac"),
    "touch, lamps of 20": ("l20, touch", "tac"),
}
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


@cache
def runs_of(record: str) -> list[Any]:
    """Return the lines of a record: what all runs share, then the runs by seed."""
    first, *runs = lines(RECORDS / f"{record}.jsonl.gz")
    return [first, *sorted(runs, key=lambda run: run["seed"])]


def letters(text: str) -> Any:
    """Return the letters of a text as numbers."""
    return np.frombuffer(text.encode(), np.uint8)


@cache
def cells_of(wanted: str, *, alike: bool = False, record: str = "ladder") -> dict[str, Cells]:
    """Return method -> source -> target -> accuracy of each seed on a rung; `alike`: of the pairs
    that look like another class.
    """
    first, *runs = runs_of(record)
    truth, looks = (letters(first[key]) for key in ("truth", "look_alike"))
    place = np.array(first["domain"])
    there = [place == k for k in range(len(first["domains"]))]
    learned = [np.isin(truth, truth[own]) for own in there]  # the classes of a source
    found: Any = defaultdict(lambda: defaultdict(lambda: defaultdict(list)))
    for run in runs:
        if wanted not in run["answers"]:
            continue
        said, home = letters(run["answers"][wanted]), first["domains"].index(run["source"])
        counted = (said != ord(".")) & learned[home]
        if alike:
            counted &= looks == ord("1")
        counted &= there[home] == (wanted == "home")
        for target, own in enumerate(there):
            right = (said == truth)[counted & own]
            if len(right):
                found[run["method"]][run["source"]][target].append(100 * float(right.mean()))
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
    whole = table(document("docs/benchmarks/table.md"), "| method | seeds")
    for name, row in (*table(text, "| method | seeds").items(), *whole.items()):
        if name not in METHODS:  # not measured
            continue
        seeds, *shares, several, _, _ = row
        method = METHODS[name]
        for rung, cell in zip(RUNGS, shares, strict=True):
            count.text(f"README, {name}, {rung}", cell, drawn(by_rung[rung][method]))
        own = next(iter(by_rung["none"][method].values()))
        count.compare(f"README, {name}, seeds", float(seeds), len(next(iter(own.values()))), 0)
        if several != "–":
            joint = by_rung["none"][f"{method}_mean"]
            count.text(f"README, {name}, averaged", several, drawn(joint))
    for name, cells in table(document("docs/benchmarks/table.md"), "| OmniVaT minus").items():
        for rung, cell in zip(RUNGS, cells, strict=False):
            less = minus(by_rung[rung]["omnivat"], by_rung[rung][METHODS[name]])
            count.text(f"table, OmniVaT minus {name}, {rung}", cell, drawn(less))
    said = re.search(
        rf"({NUMBER}) % as it comes, ({NUMBER}) with 5 pictures, ({NUMBER}) with 20", text
    )
    assert said, "the README has no finding on pictures of a new sensor"
    for printed, rung in zip(said.groups(), RUNGS, strict=False):
        maps = by_rung[rung]["linear_maps"]
        count.compare(f"README, linear maps, {rung}", float(printed), mean_of(maps))


def check_relief(count: Count) -> None:
    """Compare the table by relief: accuracies, and gains over colours with their limits."""
    text = document("docs/benchmarks/table.md")
    part = text[text.index("## By relief") :]
    by_rung = {rung: cells_of(rung, record="relief") for rung, _ in LIT.values()}
    plain = {rung: cells_of(rung) for _, rung in LIT.values()}
    for name, (seeds, *row) in table(part, "| method | seeds").items():
        method = METHODS[name]
        own = next(iter(next(iter(by_rung["n20"][method].values())).values()))
        count.compare(f"by relief, {name}, seeds", float(seeds), len(own), 0)
        for (column, (rung, base)), cell in zip(LIT.items(), row, strict=True):
            if cell == "–":
                continue
            mean, _, gain = cell.partition(" ")
            lit = by_rung[rung][method]
            count.compare(f"by relief, {name}, {column}", float(mean), mean_of(lit))
            less = minus(lit, plain[base][method])
            count.text(f"by relief, {name}, {column}, gain", gain, drawn(less))
    said = re.search(
        rf"by relief ({NUMBER}) % as it comes, ({NUMBER}) by lamps of 20 pictures, ({NUMBER}) with",
        document("README.md"),
    )
    assert said, "the README has no finding on the relief"
    for printed, rung in zip(said.groups(), ("none", "l20", "n20"), strict=True):
        found = mean_of(by_rung[rung]["linear_maps"])
        count.compare(f"README, by relief, {rung}", float(printed), found)
    rungs = [rung for column, (rung, _) in LIT.items() if "," not in column]
    for name, row in table(part, "| OmniVaT minus").items():
        for rung, cell in zip(rungs, row, strict=True):
            less = minus(by_rung[rung]["omnivat"], by_rung[rung][METHODS[name]])
            count.text(f"by relief, OmniVaT minus {name}, {rung}", cell, drawn(less))
    for name, row in table(part, "| relief and colours").items():
        for (rung, _), cell in zip(LIT.values(), row, strict=True):
            if cell == "–":
                continue
            mean, _, gain = cell.partition(" ")
            alone = METHODS.get(name, "linear_maps")
            inputs = "wide_maps" if "one vector" in name else "three_maps"
            both = by_rung[rung][alone + "+colours" if name in METHODS else inputs]
            count.compare(f"relief and colours, {name}, {rung}", float(mean), mean_of(both))
            less = minus(both, by_rung[rung][alone])
            count.text(f"relief and colours, {name}, {rung}, gain", gain, drawn(less))


def triples(count: Count, what: str, text: str, wanted: Sequence[Cells]) -> None:
    """Compare the means with limits in a text, in their order."""
    found = re.findall(rf"({NUMBER})(?: %)? \[({NUMBER}), ({NUMBER})\]", text)
    for n, (printed, cells) in enumerate(zip(found, wanted, strict=True)):
        count.text(f"{what}, figure {n + 1}", " ".join(printed), drawn(cells))


def check_report(count: Count) -> None:
    """Compare the report's paragraphs on the sensor and on pictures, and what averaging brings."""
    by_rung = {rung: cells_of(rung) for rung in ("home", *RUNGS)}
    ours, maps = ({r: by_rung[r][m] for r in by_rung} for m in ("omnivat", "linear_maps"))
    leads = {rung: minus(ours[rung], maps[rung]) for rung in ours}
    several = [by_rung["none"][f"{m}_mean"] for m in ("omnivat", "linear_maps")]
    text = document("paper/paper.md")
    part = text.partition("The sensor. ")[2].partition("Pictures and labels. ")
    wanted = [maps["home"], maps["none"], ours["home"], ours["none"], leads["none"]]
    triples(count, "report, sensor", part[0], [*wanted, minus(*several)])
    wanted = [maps[rung] for rung in ("n5", "n20", "k5")]
    wanted += [leads[rung] for rung in ("n5", "n20", "k5")]
    triples(count, "report, pictures", part[2].partition("Orders. ")[0], wanted)
    as_it_comes = by_rung["none"]
    for name, row in table(document("docs/benchmarks/table.md"), "| method | heads").items():
        mean, own = as_it_comes[f"{METHODS[name]}_mean"], as_it_comes[METHODS[name]]
        single = {
            source: {place: [fmean(seeds)] for place, seeds in targets.items()}
            for source, targets in own.items()
        }
        for cell, cells in zip(row[1:], (own, mean, minus(mean, single)), strict=True):
            count.text(f"averaged, {name}", cell, drawn(cells))


def chirps() -> dict[str, Cells]:
    """Return method -> source -> target -> accuracy of each seed, from stored predictions."""
    found: Any = defaultdict(lambda: defaultdict(lambda: defaultdict(list)))
    for run in lines(TIMES / "chirps.jsonl.gz"):
        for name, target in run["targets"].items():
            said, truth = target["answers"]["fused"], target["truth"]
            right = fmean(a == b for a, b in zip(said, truth, strict=True))
            found[run["method"]][run["source"]][name].append(100 * right)
    return dict(found)


def twins_of(method: str) -> Cells:
    """Return source -> accuracy by touch where the sensor alone changed, dots filled."""
    split = json.loads((TIMES / "twins.json").read_text(encoding="utf-8"))["split"]
    parts = split[method]["filled"]["touch"]["by_source"]
    return {s: {"others": [p["home"] - p["new_objects"] - p["sensor"]]} for s, p in parts.items()}


def check_good_for(count: Count) -> None:
    """Compare the table of what OmniVaT is good for, and the chirps of README and report."""
    none, vis, tac = (cells_of(rung) for rung in ("none", "vis", "tac"))
    alike, played = cells_of("none", alike=True), chirps()
    both = {
        "chirps, p searched": (played["omnivat"], played["linear_maps"]),
        "chirps, p = 0": (played["omnivat_p0"], played["linear_maps"]),
        "touch missing": (vis["omnivat"], vis["linear_maps"]),
        "photo missing": (tac["omnivat"], tac["linear_maps"]),
        "look-alikes": (alike["omnivat"], alike["linear_maps"]),
        "all seeds averaged": (none["omnivat_mean"], none["linear_maps_mean"]),
        "all pairs, 40 of each class": (none["omnivat"], none["linear_maps"]),
    }
    for few in (10, 20):
        both[f"{few} pairs of each class"] = (none[f"omnivat@{few}"], none[f"linear_maps@{few}"])
    what = "twins: the sensor alone changed, by touch"
    both[what] = twins_of("omnivat"), twins_of("linear_maps")
    rows = table(document("docs/protocol.md"), "| where")
    for where, (ours, theirs) in both.items():
        *means, lead = rows[where]
        for printed, cells in zip(means, (ours, theirs), strict=True):
            count.compare(f"good for, {where}", float(printed), mean_of(cells))
        count.text(f"good for, {where}", lead, drawn(minus(ours, theirs)))
    said = {
        "README.md": rf"({NUMBER}) % with a search for p, ({NUMBER}) at p = 0,"
        rf" linear maps ({NUMBER})",
        "paper/paper.md": rf"({NUMBER}) % where p = 0 has ({NUMBER}) % and linear maps ({NUMBER})",
    }
    for name, pattern in said.items():
        sentence = re.search(pattern, document(name))
        assert sentence, f"{name} has no finding on chirps"
        for value, method in zip(
            sentence.groups(), ("omnivat", "omnivat_p0", "linear_maps"), strict=True
        ):
            count.compare(f"{name}, chirps, {method}", float(value), mean_of(played[method]))


def check_twins(count: Count) -> None:
    """Compare the README's first finding with what the page shows of the twins."""
    record = json.loads((ROOT / "examples" / "twins.json").read_text(encoding="utf-8"))
    said = re.search(
        r"(\d+) % on the sensor that it learned, (\d+) on seven others; with the dots filled (\d+)"
        r" and (\d+); by relief (\d+) and (\d+)",
        document("README.md"),
    )
    assert said, "the README has no finding on dots"
    for look in range(3):
        home, away = (record[key]["touch"][0][look][0] for key in ("accuracy", "away"))
        for printed, share in zip(said.groups()[2 * look :], (home[0][0], away[0]), strict=False):
            count.compare(f"README, twins, look {look}", float(printed), 100 * share, 0.5)


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
        "the report, and what averaging brings": check_report,
        "what OmniVaT is good for": check_good_for,
        "the twins": check_twins,
        "the transform": check_transform,
        "the table by relief": check_relief,
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
