"""The table of a comparison, in Markdown and as a figure."""

import math
from collections.abc import Mapping
from typing import Any

from omnivat.study.reports.markdown import markdown

Record = Mapping[str, Any]


def table(comparison: Record) -> str:
    """Return the comparison as a Markdown table, the differences to the first set, and notes."""
    columns = comparison["columns"]
    kinds = _gaps(comparison)
    head = ["set", *(c["title"] for c in columns), *kinds.values(), "values", "ms a picture"]
    rows = [
        [
            entry["name"],
            *(_cell(entry["cells"].get(c["id"]), c["id"]) for c in columns),
            *(_gap(entry["gaps"].get(kind)) for kind in kinds),
            str(entry["width"]),
            "–" if entry["cost_ms"] is None else f"{entry['cost_ms']:.0f}",
        ]
        for entry in comparison["sets"]
    ]
    first, *others = comparison["sets"]
    less = [
        [f"{entry['name']} less {first['name']}"]
        + [_cell((entry["cells"].get(c["id"]) or {}).get("less"), c["id"], "+") for c in columns]
        for entry in others
    ]
    differences = markdown(["difference", *(c["title"] for c in columns)], less)
    return "\n\n".join((markdown(head, rows), differences, " ".join(notes(comparison)))) + "\n"


def notes(comparison: Record) -> list[str]:
    """Return what the table shows, in sentences."""
    what = {"both": "photo and touch", "vis": "photos", "tac": "touches"}[comparison["view"]]
    probe = (
        f"a ridge regression that predicts {comparison['target']}"
        if comparison["target"]
        else "linear maps, the yardstick of `omnivat report`; percent right"
    )
    words = [
        f"{comparison['pairs']} pairs{' (simulated)' * comparison['simulated']} of"
        f" {len(comparison['domains'])} domains, {what}: {probe}. Each of"
        f" {len(comparison['sources'])} domains is learned; home is its own held-out pairs,"
        " away the mean over all others."
    ]
    if len(comparison["domains"]) > 1:
        words.append(
            f"Pictures have no labels and give a profile; what is known is not tested, and is drawn"
            f" {comparison['draws']} times (fewer than 5 or 20 where a domain is small)."
        )
    if comparison["drawn"]:
        words.append(
            f"Brackets are 95 % intervals over {comparison['drawn']}, paired between sets. Bold:"
            " better than every other set, by intervals that hold together."
        )
    else:
        words.append("A domain has one object only, so there are no intervals and nothing is bold.")
    if _gaps(comparison):
        words.append(
            "Gaps are distances of centroids; in parentheses, of two halves of one domain."
        )
    lit = {s["name"]: s["lamps_from"] for s in comparison["sets"] if s["lamps_from"]}
    words += [
        f"In '{name}' lamps of each domain are known from up to {count} touches, in every column."
        for name, count in lit.items()
    ]
    return words


def chart(comparison: Record) -> list[dict[str, Any]]:
    """Return the records of `figures.dots`: shares, or R² of numbers."""
    return [
        {"row": entry["name"], "series": c["title"], **entry["cells"][c["id"]]}
        for entry in comparison["sets"]
        for c in comparison["columns"]
        if c["id"] in entry["cells"] and not c["id"].endswith(":mae")
    ]


def _gaps(comparison: Record) -> dict[str, str]:
    """Return the gaps that are shown: of modalities, and of touches or else of photos."""
    there = dict.fromkeys(kind for entry in comparison["sets"] for kind in entry["gaps"])
    of = "tac" if comparison["view"] != "vis" else "vis"
    wanted = {
        "between modalities": "gap of photo and touch",
        f"between domains, {of}": "gap between sensors",
    }
    return {kind: title for kind, title in wanted.items() if kind in there}


def _gap(interval: Record | None) -> str:
    if interval is None or math.isnan(interval["value"]):
        return "–"
    level = "" if interval["floor"] is None else f" ({interval['floor']:.2f})"
    return f"{interval['value']:.2f}{level}"


def _cell(cell: Record | None, column: str, sign: str = "") -> str:
    """Return "71.3 [67.0, 75.1]", bold for the best; `sign` "+" for differences."""
    if cell is None:
        return "–"

    def number(value: float, sign: str = sign) -> str:
        if column.endswith((":r2", ":mae")):
            return f"{value:{sign}.3g}"
        return f"{100 * value:{sign}.1f}"

    ends = (
        "" if cell["low"] is None else f" [{number(cell['low'], '')}, {number(cell['high'], '')}]"
    )
    return (
        f"**{number(cell['value'])}**{ends}" if cell.get("best") else number(cell["value"]) + ends
    )
