"""The table of heads on three sets, computed again pair by pair, for `benchmarks.recompute`."""

import gzip
import json
import math
import re
import struct
from base64 import b64decode
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from statistics import fmean
from typing import Any

from scipy.special import stdtrit

DOCS = Path(__file__).resolve().parent.parent / "docs"
RECORDS = DOCS.parent / "examples" / "records"
TABLE, RECORD = "benchmarks/ladder_sets.md", DOCS / "benchmarks" / "ladder_sets.jsonl.gz"
ROWS = {
    "OmniVaT": "omnivat",
    "its tree alone (DTG)": "dtg_recipe",
    "ERM-MLP": "erm_recipe",
    "logistic regression": "logistic_recipe",
    "OmniVaT, five in one": "distilled",
}
Compare = Callable[..., None]
Five = tuple[float, ...]  # ACC, Macro-F1, NLL, NLL at the source's temperature, ECE
Run = Mapping[str, Any]


def opened(file: Path) -> Iterator[Any]:
    """Yield the objects of a file of records."""
    for line in gzip.decompress(file.read_bytes()).decode().splitlines():
        yield json.loads(line)


class Set:
    """One set: truth, domain and split of every pair as text, and its runs."""

    def __init__(self, first: Run, names: str) -> None:
        self.truth, self.names, self.domains = first["truth"], names, first["domains"]
        self.split = first.get("split", "e" * len(self.truth))
        self.more = len(first["classes"]) - 1
        self.runs: dict[tuple[str, str], dict[Any, Run]] = defaultdict(dict)

    def rows(self, source: str) -> dict[str, list[int]]:
        """Return the pairs of every unseen domain whose class the source has."""
        home, found = chr(97 + self.domains.index(source)), defaultdict(list)
        taught = {c for c, d in zip(self.truth, self.names, strict=True) if d == home}
        for row, (c, d) in enumerate(zip(self.truth, self.names, strict=True)):
            if d != home and c in taught:
                found[d].append(row)
        return found

    def shares(self, run: Run) -> dict[int, list[float]]:
        """Return the probabilities of the test pairs by row."""
        raw = b64decode(run["odds"])
        odds, found = struct.unpack(f"<{len(raw) // 2}e", raw), {}
        for place, row in enumerate(r for r, s in enumerate(self.split) if s == "e"):
            powers = [*odds[place * self.more : (place + 1) * self.more], 0.0]
            powers = [math.exp(one - max(powers)) for one in powers]
            found[row] = [one / sum(powers) for one in powers]
        return found

    def five(self, source: str, said: Mapping[int, str] | str, shares: Mapping[int, Sequence[float]]) -> Five:
        """Return the measures of one head: the mean over unseen domains."""
        cells, heat = [], self.heat(source, shares)
        for rows in self.rows(source).values():
            pairs = [(self.truth[row], said[row]) for row in rows]
            own = [a for a, b in pairs if a == b]
            truth, guess = [a for a, _ in pairs], [b for _, b in pairs]
            f1 = fmean(2 * own.count(c) / (truth.count(c) + guess.count(c)) for c in set(truth))
            bins: defaultdict[int, float] = defaultdict(float)
            tested = [row for row in rows if row in shares]
            for row in tested:
                chances, right = shares[row], ord(self.truth[row]) - 97
                bins[math.ceil(max(chances) * 15)] += (chances.index(max(chances)) == right) - max(chances)
            missed = 100 * sum(map(abs, bins.values())) / len(tested)
            losses = (self.loss(tested, shares, one) for one in (1.0, heat))
            cells.append((100 * len(own) / len(pairs), 100 * f1, *losses, missed))
        return _mean(cells)

    def loss(self, rows: Sequence[int], shares: Mapping[int, Sequence[float]], heat: float) -> float:
        """Return the mean log loss of some pairs at a temperature."""
        lost = 0.0
        for row in rows:
            logs = [math.log(max(one, 1e-12)) / heat for one in shares[row]]
            lost += math.log(sum(map(math.exp, logs))) - logs[ord(self.truth[row]) - 97]
        return lost / len(rows)

    def heat(self, source: str, shares: Mapping[int, Sequence[float]]) -> float:
        """Return the temperature of an eighth of a doubling that fits the source's own test pairs best."""
        home = chr(97 + self.domains.index(source))
        own = [row for row in shares if self.names[row] == home]
        return min((2 ** (k / 8) for k in range(-16, 33)), key=lambda one: self.loss(own, shares, one))


def _mean(rows: Sequence[Five]) -> Five:
    return tuple(fmean(column) for column in zip(*rows, strict=True))


def sets() -> dict[str, Set]:
    """Return the sets with their runs; the ladder's lines are members of the shipped one."""
    ladder = opened(RECORDS / "ladder.jsonl.gz")
    first = next(ladder)
    found = {"0": Set(first, "".join(chr(97 + d) for d in first["domain"]))}
    for run in ladder:
        if run["method"].endswith(("omnivat", "_recipe")) and "odds" in run:
            found["0"].runs[run["source"], run["method"]][run["seed"]] = run
    for run in opened(RECORD):
        if "method" not in run:
            found.setdefault(run["set"], Set(run, run["domain"]))
        else:
            found[run["set"]].runs[run["source"], run["method"]].setdefault(run["member"], run)
    return found


def cells(name: str, one: Set, method: str, heads: str) -> list[Five]:
    """Return the measures of a method on a set, source by source."""
    found = []
    for source in one.domains:
        runs = one.runs[source, method]
        members = [runs[k] for k in ([0] if method == "distilled" else range(5))]
        shares = [one.shares(run) for run in members]
        if heads == "five heads":
            joint = {row: [fmean(x) for x in zip(*(s[row] for s in shares), strict=True)] for row in shares[0]}
            shares, members = [joint], [runs["mean"]] if "mean" in runs else []
        best = [{row: chr(97 + s.index(max(s))) for row, s in each.items()} for each in shares]
        said = best if name == "0" else [run["all"] for run in members]
        found.append(_mean([one.five(source, a, b) for a, b in zip(said, shares, strict=True)]))
    return found


def interval(values: Sequence[Sequence[float]]) -> tuple[float, float, float]:
    """Return mean and 95 % limits of values[set][source], sources and sets drawn at random."""
    many, each = len(values), len(values[0])
    centre = fmean(map(fmean, values))
    sets_, sources = [fmean(row) for row in values], [fmean(column) for column in zip(*values, strict=True)]
    own = each * sum((x - centre) ** 2 for x in sets_) / (many - 1)
    other = many * sum((x - centre) ** 2 for x in sources) / (each - 1)
    rest = sum((values[j][i] - sets_[j] - sources[i] + centre) ** 2 for j in range(many) for i in range(each)) / (
        (many - 1) * (each - 1)
    )
    parts = [(own, many - 1), (other, each - 1), (rest, (many - 1) * (each - 1))]
    whole, free = own + other - rest, 0.0
    if whole > max(parts)[0]:
        free = whole**2 / sum(ms * ms / df for ms, df in parts)
    else:
        whole, free = max(parts)
    half = float(stdtrit(free, 0.975)) * math.sqrt(whole / (many * each))
    return centre, centre - half, centre + half


def check(compare: Compare) -> None:
    """Compare the table's measures, its differences and their limits."""
    text = (DOCS / TABLE).read_text(encoding="utf-8")
    every, kept = sets(), dict[tuple[str, str], dict[str, list[Five]]]()
    names = sorted(every)
    rows = [[c.strip() for c in line.strip("|").split(" | ")] for line in text.splitlines() if line.startswith("| ")]
    for heads, label, *printed in (row for row in rows if row[1] in ROWS and " / " in row[-1]):
        for name, cell in zip(names, printed, strict=True):
            if cell != "–":
                own = cells(name, every[name], ROWS[label], heads)
                kept.setdefault((heads, label), {})[name] = own
                for one, value in zip(re.findall(r"\d+\.\d+", cell), _mean(own), strict=True):
                    room = 0.51 * 10.0 ** -len(one.split(".")[1])
                    compare(f"{TABLE}, {heads}, {label}, set {name}", float(one), value, room)
    readme = (DOCS.parent / "README.md").read_text(encoding="utf-8")
    best = re.search(r"of OmniVaT \((\d+\.\d) %\) and of ERM-MLP \((\d+\.\d) %\)", readme)
    for label, printed_best in zip(("OmniVaT", "ERM-MLP"), best.groups() if best else ("nan", "nan"), strict=True):
        found = fmean(_mean(kept["five heads", label][name])[0] for name in names)
        compare(f"README, five heads, {label}", float(printed_best), found)
    heads_of = {"its tree alone (DTG)", "ERM-MLP", "logistic regression"}
    for heads, label, *printed in (row for row in rows if len(row) == 7 and row[0] in ("one head", "five heads")):
        if label in heads_of:
            ours, theirs = kept[heads, "OmniVaT"], kept[heads, label]
        elif label == "one head of OmniVaT":
            ours, theirs = kept["five heads", "OmniVaT"], kept["one head", "OmniVaT"]
        else:
            continue
        for place, cell in enumerate(printed[:4]):
            less = [[a[place] - b[place] for a, b in zip(ours[n], theirs[n], strict=True)] for n in names]
            wanted = interval(less)
            for one, value in zip(map(float, re.findall(r"[+-]\d+\.\d+", cell.split(" [")[0])), wanted, strict=True):
                compare(f"{TABLE}, {heads}, OmniVaT less {label}", one, value, 0.0051 if place > 1 else 0.0501)
