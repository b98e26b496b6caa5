"""The tables of docs/order.md from their records, with no code of the studies."""

import gzip
import json
import re
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping
from itertools import combinations
from pathlib import Path
from statistics import fmean, median, stdev
from typing import Any

DOCS = Path(__file__).resolve().parent.parent / "docs"
STUDENT = 1.894579  # 95 % quantile of Student's t with 7 degrees of freedom: eight sources
Compare = Callable[[str, float, float, float], None]  # what, printed, found, room
Rows = Mapping[str, Any]


def records(name: str) -> list[Rows]:
    """Return the rows of a record: lines, compressed or not, or the rows of a JSON file."""
    data = (DOCS / "benchmarks" / name).read_bytes()
    text = (gzip.decompress(data) if name.endswith(".gz") else data).decode()
    found: list[Rows] = (
        json.loads(text)["rows"] if name.endswith(".json") else [json.loads(line) for line in text.splitlines()]
    )
    return found


def table(heading: str) -> Iterator[list[str]]:
    """Yield the cells of each row of the first table below a heading of order.md."""
    text = (DOCS / "order.md").read_text(encoding="utf-8").replace("−", "-").replace("**", "")
    found = re.search(r"(^\|.*\n)+", text[text.index(heading) :], re.M)
    assert found, heading
    for line in found[0].splitlines()[2:]:
        yield [cell.strip() for cell in line.strip("| ").split(" | ")]


def numbers(cell: str) -> list[float]:
    """Return the numbers of a cell."""
    return [float(text) for text in re.findall(r"[+-]?\d+\.?\d*", cell)]


def accuracy(square: Rows, digits: str) -> float:
    """Return the percentage of right pairs, mean over the domains that are not the source."""
    right = defaultdict(list)
    for domain, label, digit in zip(square["domain"], square["label"], digits, strict=True):
        right[domain].append(label == digit)
    return 100 * fmean(fmean(own) for d, own in right.items() if d != str(square["own"]))


def differing(square: Rows, pairs: Iterable[tuple[str, str]]) -> float:
    """Return the percentage of unseen pairs on which two heads differ, mean over pairs of heads."""
    away = [k for k, d in enumerate(square["domain"]) if d != str(square["own"])]
    return 100 * fmean(fmean(a[k] != b[k] for k in away) for a, b in pairs)


def figures(square: Rows) -> dict[str, float]:
    """Return the figures of one source, by the column of the table."""
    heads = [[accuracy(square, one) for one in row] for row in square["heads"]]
    votes = defaultdict(list)
    for name, digits in square["ensembles"].items():
        votes[name.rpartition(" ")[0] or name].append(accuracy(square, digits))
    rows, columns = square["heads"], list(zip(*square["heads"], strict=True))
    within = fmean(stdev(row) ** 2 for row in heads) ** 0.5
    return {
        "one": fmean(map(fmean, heads)),
        "seeds": fmean(votes["seeds"]),
        "orders": fmean(votes["orders"]),
        "column": fmean(votes["orders, one seed"]),
        "all": fmean(votes["all"]),
        "differ by seed": differing(square, (p for row in rows for p in combinations(row, 2))),
        "differ by order": differing(square, (p for c in columns for p in combinations(c, 2))),
        "spread": stdev(map(fmean, heads)),
        "luck": within / len(heads) ** 0.5,
    }


def check_squares(compare: Compare) -> None:
    """Compare every figure of the table of squares."""
    groups = defaultdict(list)
    for made in records("order_squares.jsonl.gz"):
        key = (made["head"], made["kind"], made["width"], made["noise"], len(made["heads"]))
        groups[key].append(figures(made))
    printed = list(table("## Orders or seeds?"))
    assert len(printed) == len(groups), "another number of rows"
    for cells in printed:
        key = (cells[0], cells[1], int(cells[2]), float(cells[3]), int(cells[4]))
        own = groups[key]
        assert int(cells[5]) == len(own) == 8, key
        mean = {name: fmean(one[name] for one in own) for name in own[0]}
        less = [one["orders"] - one["seeds"] for one in own]
        half = STUDENT * stdev(less) / len(less) ** 0.5
        ends = (fmean(less) - half, fmean(less) + half)
        wanted = [mean[name] for name in ("one", "seeds", "orders", "column", "all")]
        wanted += [fmean(less), *ends]
        said = [value for cell in cells[6:12] for value in numbers(cell)]
        wanted += [mean["differ by seed"], mean["differ by order"], mean["spread"], mean["luck"]]
        said += numbers(cells[13]) + numbers(cells[14])
        rooms = [0.0051] * 8 + [0.051] * 2 + [0.0051] * 2
        for value, found, room in zip(said, wanted, rooms, strict=True):
            compare(f"order.md, squares, {key}", value, found, room)
        compare(f"order.md, within, {key}", cells[12] == "yes", max(-ends[0], ends[1]) < 0.5, 0)


def check_controls(compare: Compare) -> None:
    """Compare the table of other unitaries on chirps."""
    rows = records("order_controls.jsonl")
    kinds = ("order", "identity", "unitary", "group")
    for cells, kind in zip(table("## Controls: any unitary"), kinds, strict=True):
        own = [row for row in rows if row["kind"] == kind]
        unseen = [row["unseen"] for row in own]
        source = fmean(row["source_test"] for row in own)
        said = [value for cell in cells[1:] for value in numbers(cell)]
        wanted = (len(own), fmean(unseen), min(unseen), max(unseen), source)
        for one, found in zip(said, wanted, strict=True):
            compare(f"order.md, controls, {kind}", one, found, 0.0501)


def check_search(compare: Compare) -> None:
    """Compare the table of the search for p."""
    rows = records("order_others.json")
    own = {name: [r for r in rows if r["program"] == name] for name in ("other", "beside", "this")}
    own["near"] = records("order_near.json")
    for cells, (name, found) in zip(table("## Finding p"), own.items(), strict=True):
        errors = [abs(row["found"] - row["order"]) for row in found]
        said = [value for cell in cells[1:5] for value in numbers(cell)]
        wanted = (len(errors), sum(e <= 0.015 for e in errors), median(errors), max(errors))
        for one, value in zip(said, wanted, strict=True):
            compare(f"order.md, search, {name}", one, value, 0.000051)
