"""Figures that the paper prints, beside ours and marked where the data differ."""

import json
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

from omnivat.data.domains import paper_name

FILE = Path(__file__).with_name("paper.json")
BACKBONE = "ViT-B/16"  # the one whose ablations the paper prints
MARK = "*not comparable*"


@cache
def paper() -> dict[str, Any]:
    """Return the printed figures: {"main": {backbone: {method: {source: [ACC, F1]}}}, ...}."""
    found: dict[str, Any] = json.loads(FILE.read_text(encoding="utf-8"))
    return found


def not_comparable(data: Mapping[str, Any]) -> str:
    """Return why printed figures cannot be compared with figures on these data, or nothing."""
    if data["simulated"]:
        return "other data: ours are simulated"
    if "vit-b/16" not in data["encoder"].lower().replace("_", "-"):
        return f"other encoder: ours is {data['encoder']}"
    return ""


def paper_rows(sources: Sequence[str], why: str) -> list[list[str]]:
    """Return the main table's printed rows for the sources, each marked when `why` is given."""
    mark = f" {MARK} ({why})" if why else ""
    rows = []
    for method, printed in paper()["main"][BACKBONE].items():
        cells = [_cell(printed.get(paper_name(source))) for source in sources]
        rows.append([f"printed: {method}, {BACKBONE}{mark}", *cells, _cell(printed.get("average"))])
    return rows


def ablation_cell(table: str, row: str, source: str) -> str:
    """Return what the paper prints for one row of an ablation, "ACC / F1", or nothing."""
    printed = paper()["ablations"].get(table, {}).get(row, {})
    return _cell(printed.get(paper_name(source)))


def _cell(pair: Sequence[float] | None) -> str:
    return "" if pair is None else f"{pair[0]:.1f} / {pair[1]:.1f}"
