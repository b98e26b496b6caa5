"""Compute the ladder's figures again from the records, in plain Python, and compare with the table.

    python -m benchmarks.ladder_check [--records examples/records/ladder.jsonl.gz] [--table docs/benchmarks/ladder.md]

Nothing of the program is used: letters are compared with the truth one by one. Exit code 1 if a figure differs.
"""

import argparse
import gzip
import json
import sys
from pathlib import Path
from typing import Any


def mean(values: list[float]) -> float:
    return sum(values) / len(values)


def accuracies(records: Path) -> dict[tuple[str, str], float]:
    """Return (method, rung) -> accuracy (%): over seeds, then sources, then unseen domains."""
    content = records.read_bytes()
    text = gzip.decompress(content) if records.suffix == ".gz" else content
    first, *runs = map(json.loads, text.decode().splitlines())
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
    from benchmarks.ladder_table import NAMES
    from omnivat.ladder import KNOWN

    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    records, table = Path("examples/records/ladder.jsonl.gz"), Path("docs/benchmarks/ladder.md")
    parser.add_argument("--records", type=Path, default=records, help="of benchmarks.ladder")
    parser.add_argument("--table", type=Path, default=table, help="of benchmarks.ladder_table")
    options = parser.parse_args()
    rows = [line.strip("| ").split(" | ") for line in options.table.read_text().splitlines()]
    head = next(row for row in rows if row[0] == "what is known of the target")
    cells = {row[0]: row[1:] for row in rows if len(row) == len(head)}
    wrong, right = [], 0
    for (method, rung), value in accuracies(options.records).items():
        said = cells[KNOWN[rung]][head[1:].index(NAMES[method])].split("<br>")[0]
        if abs(float(said) - value) > 0.051:
            wrong.append(f"{NAMES[method]}, {KNOWN[rung]}: {value:.2f}, and the table has {said}")
        right += 1
    print("\n".join(wrong) or f"{right} figures agree")
    sys.exit(bool(wrong))


if __name__ == "__main__":
    main()
