"""The table of heads with the same budget on three sets, from the records alone: docs/benchmarks/ladder_sets.md.

    python -m benchmarks.ladder_sets_table

The records are those of `benchmarks.ladder_sets` and, for three members on the shipped set, of `benchmarks.ladder`. It
imports nothing of omnivat. A cell is one set and one source: the mean over its unseen domains. Intervals are those of a
two-way layout in which sources and sets are drawn at random.
"""

import argparse
import gzip
import json
from base64 import b64decode
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.stats import t

RECORDS, OUT = Path("examples/records"), Path("docs/benchmarks")
SHIPPED = "0"  # the set whose seed is 0
MEMBERS = 5
NAMES = {
    "omnivat": "OmniVaT",
    "dtg_recipe": "its tree alone (DTG)",
    "erm_recipe": "ERM-MLP",
    "logistic_recipe": "logistic regression",
    "distilled": "OmniVaT, five in one",
}
BUDGETS = {"one": "one head", "five": "five heads"}
MEASURES = ("acc", "f1", "nll", "nll at", "ece")  # "nll at": at the source's temperature
HEATS = [2 ** (k / 8) for k in range(-16, 33)]
Array = NDArray[Any]
Cells = dict[str, dict[tuple[str, str], float]]  # measure -> (set, source) -> value


class Interval(NamedTuple):
    """A mean with its 95 % interval."""

    mean: float
    low: float
    high: float


def objects(file: Path) -> Iterator[Any]:
    """Yield the records of a file of JSON lines, compressed or not."""
    content = file.read_bytes()
    yield from map(json.loads, (gzip.decompress(content) if file.suffix == ".gz" else content).decode().splitlines())


def letters(text: str) -> Array:
    """Return class indices of letters; -1 for a dot."""
    codes = np.frombuffer(text.encode(), np.uint8).astype(int)
    return np.where(codes == ord("."), -1, codes - ord("a"))


def shares_of(odds: str, classes: int) -> Array:
    """Return the probabilities (N, K) of stored log-odds."""
    logs = np.frombuffer(b64decode(odds), "<f2").reshape(-1, classes - 1).astype(float)
    logs = np.column_stack([logs, np.zeros(len(logs))])
    powers = np.exp(logs - logs.max(1, keepdims=True))
    shares: Array = powers / powers.sum(1, keepdims=True)
    return shares


class Pairs(NamedTuple):
    """The pairs of a set."""

    truth: Array
    domain: Array
    tested: Array
    domains: Sequence[str]
    classes: int


def facts(first: Mapping[str, Any]) -> Pairs:
    """Return the pairs of a set's first line; the ladder's has test pairs only, and numbers of domains."""
    truth, raw = letters(first["truth"]), first["domain"]
    domain = letters(raw) if isinstance(raw, str) else np.array(raw)
    tested = np.array([c == "e" for c in first["split"]]) if "split" in first else np.ones(len(truth), bool)
    return Pairs(truth, domain, tested, first["domains"], len(first["classes"]))


def unseen(pairs: Pairs, source: str, some: Array) -> list[Array]:
    """Return a mask of the pairs `some` of each unseen domain, without classes that the source lacks."""
    home = pairs.domains.index(source)
    known = np.isin(pairs.truth, pairs.truth[pairs.domain == home]) & some
    masks = [known & (pairs.domain == d) for d in range(len(pairs.domains)) if d != home]
    return [mask for mask in masks if mask.any()]


def right(truth: Array, said: Array) -> tuple[float, float]:
    """Return accuracy and Macro-F1 over the classes in the truth, in percent."""
    f1 = [
        2 * float(((truth == c) & (said == c)).sum()) / float((truth == c).sum() + (said == c).sum())
        for c in np.unique(truth)
    ]
    return 100 * float((truth == said).mean()), 100 * float(np.mean(f1))


def odd(truth: Array, shares: Array) -> tuple[float, float]:
    """Return NLL (nats) and ECE (percent; 15 bins)."""
    own, top, hit = shares[np.arange(len(truth)), truth], shares.max(1), shares.argmax(1) == truth
    bins = np.ceil(top * 15)
    missed = sum(abs((hit[bins == b] - top[bins == b]).sum()) for b in np.unique(bins))
    return float(-np.log(np.maximum(own, 1e-12)).mean()), 100 * float(missed) / len(truth)


def cooled(shares: Array, heat: float) -> Array:
    """Return probabilities at a temperature."""
    powers = np.maximum(shares, 1e-12) ** (1 / heat)
    found: Array = powers / powers.sum(1, keepdims=True)
    return found


def measured(pairs: Pairs, source: str, said: Array, some: Array, shares: Array) -> dict[str, float]:
    """Return the measures of one head: classes of all pairs in `some`, probabilities of test pairs."""
    rows = [right(pairs.truth[m], said[m]) for m in unseen(pairs, source, some)]
    every = np.full((len(pairs.truth), pairs.classes), np.nan)
    every[pairs.tested] = shares
    masks, home = unseen(pairs, source, pairs.tested), pairs.tested & (pairs.domain == pairs.domains.index(source))
    chances = [odd(pairs.truth[m], every[m]) for m in masks]
    heat = min(HEATS, key=lambda one: odd(pairs.truth[home], cooled(every[home], one))[0])
    nll, ece = np.mean(chances, axis=0)
    own = np.mean([odd(pairs.truth[m], cooled(every[m], heat))[0] for m in masks])
    values = (*np.mean(rows, axis=0), nll, own, ece)
    return dict(zip(MEASURES, map(float, values), strict=True))


class Runs:
    """All runs of the records, by set, source and method."""

    def __init__(self, sets: Path, ladder: Path) -> None:
        self.pairs: dict[str, Pairs] = {}
        self.runs: dict[tuple[str, str, str], dict[Any, Any]] = defaultdict(dict)
        lines = objects(ladder)
        self.pairs[SHIPPED] = shipped = facts(next(lines))
        for one in lines:
            if one["method"] in NAMES and one["method"] != "distilled" and "odds" in one:
                kept = {"odds": one["odds"], "n5": one["answers"]["n5"], "n20": one["answers"]["n20"]}
                self.runs[SHIPPED, one["source"], one["method"]][one["seed"]] = kept
        for one in objects(sets):
            if "truth" in one and one["set"] != SHIPPED:
                self.pairs[one["set"]] = facts(one)
            elif "method" in one:
                self.runs[one["set"], one["source"], one["method"]].setdefault(one["member"], one)
        self.sources = tuple(shipped.domains)

    def cell(self, name: str, source: str, method: str, budget: str) -> dict[str, float] | None:
        """Return the measures of a method on a set from a source; None where members are missing."""
        pairs, own = self.pairs[name], self.runs.get((name, source, method), {})
        every = np.ones(len(pairs.truth), bool)
        members = [0] if method == "distilled" else range(MEMBERS)
        if any(member not in own for member in members):
            return None
        shares = [shares_of(own[member]["odds"], pairs.classes) for member in members]
        if name == SHIPPED:
            said = [one.argmax(1) for one in (shares if budget == "one" else [np.mean(shares, axis=0)])]
        else:
            named = members if budget == "one" or method == "distilled" else ["mean"]
            said = [letters(own[member]["all"]) for member in named]
        chances = shares if budget == "one" else [np.mean(shares, axis=0)]
        found = [measured(pairs, source, one, every, two) for one, two in zip(said, chances, strict=True)]
        return {key: float(np.mean([one[key] for one in found])) for key in MEASURES}

    def known(self, name: str, source: str, method: str, budget: str, rung: str) -> float | None:
        """Return accuracy with unlabelled pairs, on test pairs; None where nothing is recorded."""
        pairs, own = self.pairs[name], self.runs.get((name, source, method), {})
        wanted = range(MEMBERS) if budget == "one" else ["mean"]
        lines = [own[k] for k in ([0] if method == "distilled" else wanted) if k in own and rung in own[k]]
        if not lines or (name == SHIPPED and budget == "five"):
            return None
        found = []
        for line in lines:
            said = np.full(len(pairs.truth), -1)
            said[pairs.tested] = letters(line[rung])
            found.append(np.mean([right(pairs.truth[m], said[m])[0] for m in unseen(pairs, source, pairs.tested)]))
        return float(np.mean(found))


def crossed(cells: Array) -> Interval:
    """Return the mean of cells (sources, sets) and its interval, both of them drawn at random.

    The variance of the mean is (MS of sources + MS of sets - MS of the rest) / cells, by Satterthwaite's degrees of
    freedom, and no less than one of the three alone. With one set, it is Student's interval over sources.
    """
    many, sets = cells.shape
    centre = float(cells.mean())
    rows, columns = cells.mean(1) - centre, cells.mean(0) - centre
    of_rows, free = sets * float(np.square(rows).sum()) / (many - 1), many - 1
    if sets == 1:
        half = float(t.ppf(0.975, free)) * (of_rows / many) ** 0.5
        return Interval(centre, centre - half, centre + half)
    of_columns = many * float(np.square(columns).sum()) / (sets - 1)
    rest = cells - centre - rows[:, None] - columns[None]
    of_rest = float(np.square(rest).sum()) / ((many - 1) * (sets - 1))
    whole = of_rows + of_columns - of_rest
    parts = (of_rows, free), (of_columns, sets - 1), (of_rest, free * (sets - 1))
    spread = sum(ms**2 / df for ms, df in parts)
    if max(ms for ms, _ in parts) >= whole:
        whole, degrees = max(parts)
    else:
        degrees = whole**2 / spread
    half = float(t.ppf(0.975, degrees)) * (whole / cells.size) ** 0.5
    return Interval(centre, centre - half, centre + half)


def grid(runs: Runs, method: str, budget: str, sets: Sequence[str]) -> dict[str, Array] | None:
    """Return measure -> cells (sources, sets) of a method; None where a cell is missing."""
    found = [[runs.cell(name, source, method, budget) for name in sets] for source in runs.sources]
    if any(one is None for row in found for one in row):
        return None
    return {key: np.array([[one[key] for one in row if one] for row in found]) for key in MEASURES}


def written(one: Interval, places: int = 1) -> str:
    """Return "-1.2 (-2.0 to +0.1)"."""
    return f"{one.mean:+.{places}f} ({one.low:+.{places}f} to {one.high:+.{places}f})"


def table(runs: Runs) -> str:
    """Return the page as Markdown."""
    sets = sorted(runs.pairs)
    text = ["# Heads with the same budget, on sets of other seeds", ""]
    text += [
        "`python -m benchmarks.ladder_sets` wrote the records, `python -m benchmarks.ladder_sets_table` this page, and",
        "`python -m benchmarks.recompute` computes its figures again in another way. Simulated sensors only.",
        "",
        "Set 0 is the shipped one: 60 pairs a class, 40 for training, scored on its test objects. The others are drawn with other",
        "seeds: 30 pairs a class, 20 for training, scored on all objects of the other domains, none of which a head has met; NLL and",
        "ECE on test objects. Eight sources each. Every row has the page's recipe (standardised input, noise 4, imitated sensors, 120",
        "epochs; logistic regression four such copies of each pair). One head: mean of five; five heads: the mean of their",
        "probabilities. Nothing was chosen on these sets; the recipe was, on set 0 for one OmniVaT head. NLL and ECE as they come; in",
        "brackets NLL at one temperature for each head or ensemble, fitted to the test pairs of its own source (not foretold).",
        "",
    ]
    head = " | ".join(f"set {name}: ACC / Macro-F1, NLL (at a temperature), ECE" for name in sets)
    text += [f"| budget | method | {head} |", "| --- | --- |" + " --- |" * len(sets)]
    grids = {}
    for budget, words in BUDGETS.items():
        for method in NAMES if budget == "one" else [m for m in NAMES if m != "distilled"]:
            cells = []
            for name in sets:
                one = grid(runs, method, budget, [name])
                if one is None:
                    cells.append("–")
                    continue
                acc, f1, nll, own, ece = (float(one[key].mean()) for key in MEASURES)
                cells.append(f"{acc:.1f} / {f1:.1f}, {nll:.2f} ({own:.2f}), {ece:.1f}")
            if any(cell != "–" for cell in cells):
                text.append(f"| {words} | {NAMES[method]} | {' | '.join(cells)} |")
            grids[method, budget] = grid(runs, method, budget, sets)
    text += ["", "## OmniVaT minus the row", ""]
    text += [
        "Sources and sets are both drawn at random: mean, 95 % interval of the two-way layout (mean squares of sources and sets,",
        "Satterthwaite's degrees of freedom). In brackets the mean of each set. Cells: of all sets and sources, those where OmniVaT",
        "has the higher accuracy, and those where it has the lower NLL.",
        "",
        "| budget | minus | ACC, points | Macro-F1, points | NLL | NLL at the source's temperature | cells: ACC, NLL |",
        "| --- | --- | --- | --- | --- | --- | --- |",
    ]
    pairs = [(b, "omnivat", m, b) for b in BUDGETS for m in ("dtg_recipe", "erm_recipe", "logistic_recipe")]
    for budget, ours, theirs, other in pairs:
        a, b = grids[ours, budget], grids[theirs, other]
        if a and b:
            text.append(_less(a, b, BUDGETS[budget], NAMES[theirs]))
    a, b = grids["omnivat", "five"], grids["omnivat", "one"]
    if a and b:
        text.append(_less(a, b, "five heads", "one head of OmniVaT"))
    some = [name for name in sets if grid(runs, "distilled", "one", [name])]
    one, five, alone = (
        grid(runs, m, b, some) if some else None
        for m, b in (("distilled", "one"), ("omnivat", "five"), ("omnivat", "one"))
    )
    if one and five and alone:
        text.append(_less(one, five, f"five in one, sets {', '.join(some)}", "five heads of OmniVaT"))
        text.append(_less(one, alone, f"five in one, sets {', '.join(some)}", "one head of OmniVaT"))
    text += ["", "## With unlabelled pairs of the target", "", "Accuracy on test objects; one head, then five.", ""]
    text += ["| budget | method | set | 5 pairs | 20 pairs |", "| --- | --- | --- | ---: | ---: |"]
    for budget, words in BUDGETS.items():
        for method in NAMES if budget == "one" else [m for m in NAMES if m != "distilled"]:
            for name in sets:
                said = [[runs.known(name, s, method, budget, rung) for s in runs.sources] for rung in ("n5", "n20")]
                if all(value is not None for row in said for value in row):
                    means = " | ".join(f"{np.mean([v for v in row if v is not None]):.1f}" for row in said)
                    text.append(f"| {words} | {NAMES[method]} | {name} | {means} |")
    return "\n".join(text) + "\n"


def _less(ours: Mapping[str, Array], theirs: Mapping[str, Array], budget: str, name: str) -> str:
    less = {key: ours[key] - theirs[key] for key in MEASURES}
    each = ", ".join(f"{value:+.1f}" for value in less["acc"].mean(0))
    cells = f"{(less['acc'] > 0).sum()}, {(less['nll'] < 0).sum()} of {less['acc'].size}"
    others = [written(crossed(less["f1"])), *(written(crossed(less[key]), 2) for key in ("nll", "nll at"))]
    return f"| {budget} | {name} | {written(crossed(less['acc']))} [{each}] | {' | '.join(others)} | {cells} |"


def main() -> None:
    """Write the table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--records", type=Path, default=OUT / "ladder_sets.jsonl.gz", help="of benchmarks.ladder_sets")
    parser.add_argument("--ladder", type=Path, default=RECORDS / "ladder.jsonl.gz", help="of benchmarks.ladder")
    parser.add_argument("--out", type=Path, default=OUT / "ladder_sets.md")
    options = parser.parse_args()
    text = table(Runs(options.records, options.ladder))
    options.out.write_text(text, encoding="utf-8")
    print(text)


if __name__ == "__main__":
    main()
