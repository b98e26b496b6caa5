"""Recompute the tables of the protocol and of the order, and the README's figures, from the records.

    python -m benchmarks.recompute

It imports nothing of omnivat, so that a mistake in the reports cannot repeat itself here: accuracy and
Macro-F1 from every stored prediction, ECE, NLL and AURC from the stored odds, the README's intervals with
draws of its own. It prints how many figures it compared and the largest deviation, and ends with 1 if a
printed figure is not the recomputed one.
"""

import gzip
import json
import re
import sys
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from statistics import fmean, stdev
from typing import Any

import numpy as np

from benchmarks import _recompute_order, _recompute_sets
from benchmarks._recompute_numbers import Said, confidence, drawn_scores, probabilities

ROOT = Path(__file__).resolve().parent.parent
RECORDS, TABLES = ROOT / "examples" / "records", ROOT / "docs" / "benchmarks"
READINGS = ("vis", "tac", "mean", "chosen")
ROOM = {"ece": 0.02, "nll": 0.004, "aurc": 0.006}  # of half precision, which ties the surest pairs
LUCK = 0.3  # points; what other draws of the bootstrap may change in a limit
Record = Mapping[str, Any]
Pair = tuple[float, float]  # ACC and Macro-F1, in percent


def lines(file: Path) -> list[Record]:
    """Return the records of runs that were not skipped; of two equal runs, the later one."""
    found = {}
    for line in gzip.decompress(file.read_bytes()).decode().splitlines():
        record = json.loads(line)
        if "targets" in record and record["fold"] is None:
            train = record["settings"].get("train", {})
            key = (record["method"], train.get("epochs"), train.get("noise"))
            found[(*key, record["source"], record["seed"])] = record
    return list(found.values())


def predicted(record: Record, target: Record, reading: str) -> str | None:
    """Return a reading's classes, one character each; "mean" and "chosen" are late fusions."""
    answers, late = target["answers"], "fusion:mean" in target["answers"]
    if reading == "mean":
        name = "fusion:mean" if late else "fused"
    elif reading == "chosen":
        name = f"fusion:{record['chosen'].get('fusion')}" if late else ""
    else:
        name = reading
    found: str | None = answers.get(name)
    return found


def both_scores(truth: str, guess: str, classes: str | None = None) -> Pair:
    """Return ACC and Macro-F1 in percent, the latter over the classes present in the truth."""
    pairs = list(zip(truth, guess, strict=True))
    right = [a for a, b in pairs if a == b]
    f1 = [2 * right.count(c) / (truth.count(c) + guess.count(c)) for c in set(truth)]
    return 100 * len(right) / len(pairs), 100 * fmean(f1)


def of_run(record: Record, reading: str) -> Pair | None:
    """Return the mean of both scores over a run's targets."""
    guesses = [(t["truth"], predicted(record, t, reading)) for t in record["targets"].values()]
    cells = [both_scores(truth, guess) for truth, guess in guesses if guess]
    return (fmean(c[0] for c in cells), fmean(c[1] for c in cells)) if cells else None


def by_seed(records: Iterable[Record], reading: str) -> list[Pair]:
    """Return, for each seed, the mean over sources."""
    found = defaultdict(list)
    for record in records:
        if (pair := of_run(record, reading)) is not None:
            found[record["seed"]].append(pair)
    return [(fmean(p[0] for p in ps), fmean(p[1] for p in ps)) for ps in found.values()]


def labelled(records: Iterable[Record]) -> dict[str, list[Record]]:
    """Return label -> records."""
    found = defaultdict(list)
    for record in records:
        found[record["label"]].append(record)
    return found


class Count:
    """Compared figures, the largest deviation, and the figures that are wrong."""

    def __init__(self) -> None:
        self.number, self.largest, self.wrong = 0, 0.0, list[str]()

    def compare(self, what: str, printed: float, found: float, room: float = 0.0501) -> None:
        """Note one figure; a printed one may be off by its rounding."""
        self.number += 1
        self.largest = max(self.largest, abs(printed - found))
        if not abs(printed - found) <= room:
            self.wrong.append(f"{what}: printed {printed}, recomputed {found:.3f}")


def check_text(count: Count, what: str, cell: str, seeds: Sequence[Pair]) -> None:
    """Compare "52.3 ± 1.0 / 50.1 ± 1.3", or without ±, with values of the seeds."""
    for part, values in zip(cell.split(" / "), zip(*seeds, strict=True), strict=True):
        numbers = [float(text) for text in part.split(" ± ")]
        wanted = [fmean(values)] + ([stdev(values)] if len(values) > 1 else [])
        for printed, found in zip(numbers, wanted, strict=len(numbers) > 1):
            count.compare(what, printed, found)


def rows_below(text: str, heading: str) -> dict[str, list[str]]:
    """Return the rows of the first table below a heading: first cell -> other cells."""
    table = re.search(r"(^\|.*\n)+", text[text.index(heading) :], re.M)
    assert table, heading
    cells = [[c.strip() for c in line.strip("|\n ").split(" | ")] for line in table[0].splitlines()]
    return {row[0].strip(): row[1:] for row in cells[2:]}


def check_tables(count: Count, name: str, records: Sequence[Record]) -> None:
    """Compare a report's readings, sources and single targets with the records."""
    text = (TABLES / name).read_text(encoding="utf-8")
    readings = rows_below(text, "## Photo only, touch only")
    sources = rows_below(text, "## Each source")
    for label, own in labelled(records).items():
        for reading, cell in zip(READINGS, readings[label], strict=False):
            if cell != "–":
                check_text(count, f"{name}, {label}, {reading}", cell, by_seed(own, reading))
        order = list(dict.fromkeys(r["source"] for r in records))
        for source, cell in zip(order, sources[label], strict=False):
            runs = [r for r in own if r["source"] == source]
            found = [pair for r in runs if (pair := of_run(r, "mean"))]
            check_text(count, f"{name}, {label}, {source}", cell, found)
        matrix = rows_below(text, f"### {label}\n")
        targets = list(dict.fromkeys(t for r in own for t in r["targets"]))
        for source, cells in matrix.items():
            for target, cell in zip(targets, cells, strict=False):
                runs = [r for r in own if r["source"] == source and target in r["targets"]]
                found = [
                    both_scores(t["truth"], guess)
                    for r in runs
                    if (guess := predicted(r, t := r["targets"][target], "mean"))
                ]
                if cell:
                    check_text(count, f"{name}, {label}, {source}, {target}", cell, found)


def check_confidence(count: Count, records: Iterable[Record]) -> None:
    """Compare ECE, NLL and AURC, with temperature and without, with those from the odds."""
    for record in records:
        for target in (t for t in record["targets"].values() if "odds" in t):
            for heat, suffix in ((1.0, "_raw"), (record["temperature"]["fused"], "")):
                shares = probabilities(target, len(record["classes"]), heat)
                for name, found in confidence(shares, target["truth"]).items():
                    printed = target["scores"]["fused"][name + suffix]
                    what = f"{record['label']}, {record['source']}, {name}{suffix}"
                    count.compare(what, printed, found, room=ROOM[name])


def check_readme(count: Count, full: Sequence[Record], light: Sequence[Record]) -> None:
    """Compare the README's table and the differences below it."""
    text = (ROOT / "README.md").read_text(encoding="utf-8").replace("**", "").replace("−", "-")
    own = labelled(full)
    names = {
        "ERM-MLP: one hidden layer on both embeddings": "ERM-MLP",
        "OmniVaT's tree alone (DTG)": "DTG alone",
        "OmniVaT": "OmniVaT",
        "nearest class mean": "Nearest class mean",
        "logistic regression on both embeddings": "Linear probe, early fusion (concatenation)",
    }
    table = rows_below(text, "Does the method help?")
    assert set(table) == set(names), table
    for name, label in names.items():
        for reading, cell in zip(READINGS, table[name], strict=False):
            check_text(count, f"README, {name}, {reading}", cell, by_seed(own[label], reading))
    erm = mean_of(own["ERM-MLP"], "mean")
    dropped = {r["source"] for r in own["OmniVaT"] if r["chosen"]["settings"] != "as set"}
    kept = {label: [r for r in rs if r["source"] not in dropped] for label, rs in own.items()}

    def lead(records: Sequence[Record], reading: str) -> Pair:
        found = mean_of(records, reading)
        return found[0] - erm[0], found[1] - erm[1]

    wanted = {
        "D = 512, mean fusion": lead(own["OmniVaT"], "mean"),
        "D = 512, chosen fusion": lead(own["OmniVaT"], "chosen"),
        "D = 64, mean fusion": lead(light, "mean"),
        "D = 64, chosen fusion": lead(light, "chosen"),
    }
    number = r"(-?[+]?\d+\.\d)"
    rows = rows_below(text, "Against the best other row")
    for name, pair in wanted.items():
        for cell, found in zip(rows[name], pair, strict=True):
            printed = re.match(number, cell)
            assert printed, cell
            count.compare(f"README, {name}", float(printed[1]), found)
    whole, parts = mean_of(kept["OmniVaT"], "mean")[0], text[text.index("What a part adds") :]
    for part, label in (
        ("L_NOD", "OmniVaT without L_NOD"),
        ("L_MMA", "OmniVaT without L_MMA"),
        ("LANG", "OmniVaT without LANG"),
        ("a learned p in place of p = 0", "OmniVaT, p = 0 fixed"),
    ):
        printed = re.search(rf"{re.escape(part)}[^\[]*?\s{number} \[", parts)
        assert printed, part
        found = whole - mean_of(kept[label], "mean")[0]
        count.compare(f"README, {part}", float(printed[1]), found)


def check_limits(count: Count, file: str, records: Sequence[Record]) -> None:
    """Compare a report's intervals of "OmniVaT minus ERM-MLP" alone with those of other draws."""
    text = (TABLES / file).read_text("utf-8")
    rows = rows_below(text, "## OmniVaT, both images by mean fusion, minus")
    own = labelled(records)
    less = np.subtract(*(drawn_scores(_said(own[name])) for name in ("OmniVaT", "ERM-MLP")))
    for values, cell in zip(less, rows["ERM-MLP, both, mean fusion"][1::2], strict=True):
        found = values[0], *np.quantile(values[1:], (0.025, 0.975))
        for one, other in zip(re.findall(r"-?\d+\.\d", cell), found, strict=True):
            count.compare(f"{file}, OmniVaT minus ERM-MLP", float(one), float(other), LUCK)


def _said(records: Iterable[Record]) -> Iterator[Said]:
    for r in records:
        targets = r["targets"].items()
        yield (
            r["source"],
            r["seed"],
            {n: (t["truth"], predicted(r, t, "mean") or "", t["objects"]) for n, t in targets},
        )


def check_printed(count: Count) -> None:
    """Find every difference with an interval that the README prints in a report or in the ladder."""
    names = ("protocol_full", "protocol", "noise", "ladder", "ladder_sets")
    known = set().union(*(_triples((TABLES / f"{n}.md").read_text("utf-8")) for n in names))
    for one in sorted(_triples((ROOT / "README.md").read_text(encoding="utf-8"))):
        count.number += 1
        if one not in known:
            count.wrong.append(f"README: no report has {one[0]} [{one[1]}, {one[2]}]")


def _triples(text: str) -> set[tuple[float, ...]]:
    """Return (difference, low, high) of every "+1.4 [0.1, 2.6]" and "+1.4 (+0.1 to +2.6)"."""
    number = r"([+-]?\d+\.\d)"
    pattern = rf"{number} [\[(]{number}(?:,| to) {number}[\])]"
    return {tuple(map(float, found)) for found in re.findall(pattern, text.replace("−", "-"))}


def check_noise(count: Count, light: Sequence[Record]) -> None:
    """Compare the README's sentence on noise with the records of noise."""
    text = (ROOT / "README.md").read_text(encoding="utf-8").replace("−", "-")
    runs = [r for r in lines(TABLES / "noise.jsonl.gz") if r["method"] == "omnivat"]
    noisy = [r for r in runs if r["settings"]["train"].get("noise") == 2]
    longer = [r for r in runs if not r["settings"]["train"].get("noise")]
    found = [mean_of(records, "mean")[0] for records in (noisy, light, longer)]
    printed = re.search(r"(\d+\.\d) % at D = 64, \+(\d+\.\d) \[.*?\+(\d+\.\d) \[", text.replace("\n", " "))
    assert printed, "the README has no sentence on noise"
    wanted = (found[0], found[0] - found[1], found[0] - found[2])
    for text_of, value in zip(printed.groups(), wanted, strict=True):
        count.compare("README, noise", float(text_of), value)


def mean_of(records: Sequence[Record], reading: str) -> Pair:
    """Return both scores: mean over targets, sources and seeds."""
    seeds = by_seed(records, reading)
    return fmean(p[0] for p in seeds), fmean(p[1] for p in seeds)


def main() -> None:
    """Compare everything and print the counts."""
    full = lines(RECORDS / "protocol_full.jsonl.gz")
    light = lines(RECORDS / "protocol.jsonl.gz")
    odds = lines(TABLES / "confidence.jsonl.gz")  # the first runs with odds
    own = {r["method"] for r in light}
    others = [r for r in full if r["base"] != "omnivat" and r["method"] not in own]
    ours, failed = [r for r in light if r["method"] == "omnivat"], False
    checks: tuple[tuple[str, Callable[[Count], None]], ...] = (
        ("tables at D = 512", lambda c: check_tables(c, "protocol_full.md", full)),
        ("tables at D = 64", lambda c: check_tables(c, "protocol.md", others + light)),
        ("ECE, NLL and AURC from the odds", lambda c: check_confidence(c, [*full, *light, *odds])),
        ("README, table and leads", lambda c: check_readme(c, full, ours)),
        ("README, noise", lambda c: check_noise(c, ours)),
        ("intervals at D = 512", lambda c: check_limits(c, "protocol_full.md", full)),
        ("intervals at D = 64", lambda c: check_limits(c, "protocol.md", others + ours)),
        ("README, all intervals", check_printed),
        ("heads on three sets", lambda c: _recompute_sets.check(c.compare)),
        ("orders or seeds", lambda c: _recompute_order.check_squares(c.compare)),
        ("other unitaries on chirps", lambda c: _recompute_order.check_controls(c.compare)),
        ("the search for p", lambda c: _recompute_order.check_search(c.compare)),
    )
    for title, check in checks:
        count = Count()
        check(count)
        print(f"{title}: {count.number} figures, largest deviation {count.largest:.3f}")
        print(*count.wrong, sep="\n", end="\n" if count.wrong else "")
        failed |= bool(count.wrong)
    sys.exit(failed)


if __name__ == "__main__":
    main()
