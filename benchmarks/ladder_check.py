"""Compute the ladder's figures again from the records, in plain Python, and compare with the table.

    python -m benchmarks.ladder_check [--records examples/records/ladder.jsonl.gz] [--table docs/benchmarks/ladder.md]

Nothing of the program is used: letters are compared with the truth one by one, and ECE and NLL come from the odds.
Exit code 1 if a figure differs.
"""

import argparse
import gzip
import json
import math
import struct
import sys
from base64 import b64decode
from pathlib import Path
from typing import Any


def mean(values: list[float]) -> float:
    return sum(values) / len(values)


def read(records: Path) -> tuple[Any, list[Any]]:
    """Return the first line, about the test pairs, and the lines of runs."""
    content = records.read_bytes()
    text = gzip.decompress(content) if records.suffix == ".gz" else content
    first, *runs = map(json.loads, text.decode().splitlines())
    return first, runs


def confidences(records: Path) -> dict[str, tuple[float, float]]:
    """Return method -> ECE (%) and NLL, over seeds, then sources, then unseen domains."""
    first, runs = read(records)
    by_source: dict[Any, list[tuple[float, float]]] = {}
    for run in (one for one in runs if "odds" in one):
        home, more = first["domains"].index(run["source"]), len(first["classes"]) - 1
        taught = {t for t, d in zip(first["truth"], first["domain"], strict=True) if d == home}
        raw = b64decode(run["odds"])
        odds = struct.unpack(f"<{len(raw) // 2}e", raw)
        cells: dict[int, list[tuple[float, bool, float]]] = {}
        for row, (truth, domain) in enumerate(zip(first["truth"], first["domain"], strict=True)):
            if domain == home or truth not in taught:
                continue
            powers = [*odds[row * more : (row + 1) * more], 0.0]
            shares = [math.exp(one - max(powers)) for one in powers]
            shares = [one / sum(shares) for one in shares]
            best, own = shares.index(max(shares)), ord(truth) - ord("a")
            cells.setdefault(domain, []).append((max(shares), best == own, shares[own]))
        found = []
        for rows in cells.values():
            bins: dict[int, float] = {}
            for top, right, _ in rows:
                place = math.ceil(top * 15)
                bins[place] = bins.get(place, 0.0) + right - top
            missed = 100 * sum(map(abs, bins.values())) / len(rows)
            found.append((missed, mean([-math.log(max(own, 1e-12)) for *_, own in rows])))
        key = run["method"], run["source"]
        by_source.setdefault(key, []).append((mean([a for a, _ in found]), mean([b for _, b in found])))
    methods: dict[str, list[tuple[float, float]]] = {}
    for (method, _), values in by_source.items():
        methods.setdefault(method, []).append((mean([a for a, _ in values]), mean([b for _, b in values])))
    return {m: (mean([a for a, _ in v]), mean([b for _, b in v])) for m, v in methods.items()}


def accuracies(records: Path) -> dict[tuple[str, str], float]:
    """Return (method, rung) -> accuracy (%): over seeds, then sources, then unseen domains."""
    first, runs = read(records)
    by_source: dict[Any, list[float]] = {}
    for run in runs:
        home = first["domains"].index(run["source"])
        taught = {t for t, d in zip(first["truth"], first["domain"], strict=True) if d == home}
        groups: dict[str, list[float]] = {}
        for rung, answers in run["answers"].items():
            counts: dict[int, list[int]] = {}
            for said, truth, domain in zip(answers, first["truth"], first["domain"], strict=True):
                if said != "." and truth in taught and (domain == home) == (rung == "home"):
                    counts.setdefault(domain, []).append(said == truth)
            if counts:
                shares = [sum(rows) / len(rows) for rows in counts.values()]
                groups.setdefault(rung.split(":")[0], []).append(100 * mean(shares))
        for rung, values in groups.items():
            by_source.setdefault((run["method"], rung, run["source"]), []).append(mean(values))
    found: dict[tuple[str, str], list[float]] = {}
    for (method, rung, _), values in by_source.items():
        found.setdefault((method, rung), []).append(mean(values))
    return {key: mean(values) for key, values in found.items()}


def main() -> None:
    """Compare, and say how many figures agree."""
    from benchmarks.ladder_table import BUDGETS, NAMES, SEEN
    from omnivat.measure.ladder import KNOWN

    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    records, table = Path("examples/records/ladder.jsonl.gz"), Path("docs/benchmarks/ladder.md")
    parser.add_argument("--records", type=Path, default=records, help="of benchmarks.ladder")
    parser.add_argument("--table", type=Path, default=table, help="of benchmarks.ladder_table")
    options = parser.parse_args()
    rows = [line.strip("| ").split(" | ") for line in options.table.read_text().splitlines()]
    head = next(row for row in rows if row[0] == "what is known of the target")
    cells = {row[0]: row[1:] for row in rows if len(row) == len(head)}
    wrong, right = [], 0
    shares = accuracies(options.records)
    for (method, rung), value in shares.items():
        said = cells[KNOWN[rung]][head[1:].index(NAMES[method])].split("<br>")[0]
        if abs(float(said) - value) > 0.051:
            wrong.append(f"{NAMES[method]}, {KNOWN[rung]}: {value:.2f}, and the table has {said}")
        right += 1
    said_of = {row[1]: row for row in rows if row[0] in BUDGETS and len(row) == len(SEEN) + 4}
    odds = confidences(options.records)
    for ours, *others in BUDGETS.values():
        for method in (name for name in (ours, *others) if NAMES[name] in said_of):
            _, _, *cells_of, ece, nll = said_of[NAMES[method]]
            pairs = [(ece, odds[method][0], 0.051), (nll, odds[method][1], 0.0051)]
            for rung, cell in zip(SEEN, cells_of, strict=True):
                value, less = shares[method, rung], shares[ours, rung] - shares[method, rung]
                parts = cell.replace("<br>", " ").split()
                pairs += [(parts[0], value, 0.051), *((p, less, 0.051) for p in parts[1:2])]
            for printed, value, room in pairs:
                right += 1
                if abs(float(printed) - value) > room:
                    wrong.append(f"{NAMES[method]}, budget: {value:.3f}, and the table has {printed}")
    print("\n".join(wrong) or f"{right} figures agree")
    sys.exit(bool(wrong))


if __name__ == "__main__":
    main()
