"""The paper's printed figures, marked where data or encoder differ from ours."""

import json
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

from omnivat.data.domains import paper_name

FILE = Path(__file__).with_name("paper.json")
BACKBONE = "ViT-B/16"  # the backbone of the paper's ablations and single targets
# the project's name of an encoder -> the paper's name of its backbone
BACKBONES = {"clip-vit-b16": BACKBONE, "clip-rn50": "ResNet-50", "clip-vit-l14": "ViT-L/14"}
MARK = "*not comparable*"


@cache
def paper() -> dict[str, Any]:
    """Return the printed figures.

    main       backbone -> method -> source -> [ACC, F1], and "average"
    targets    backbone -> source -> method -> target -> [ACC, F1], and "average"
    margins    method -> target or "[A; B]" -> cosine margin from TAG
    cost       method -> quantity -> figure
    ablations  table -> row -> source -> [ACC, F1]
    """
    found: dict[str, Any] = json.loads(FILE.read_text(encoding="utf-8"))
    return found


def backbone(data: Mapping[str, Any]) -> str:
    """Return the paper's backbone for this encoder, ViT-B/16 for others."""
    return BACKBONES.get(data["encoder"], BACKBONE)


def not_comparable(data: Mapping[str, Any], *, ablations: bool = False) -> str:
    """Return why printed figures are not comparable with figures on these data, or "".

    ablations  True for tables that are printed for ViT-B/16 only
    """
    if data["simulated"]:
        return "other data: ours are simulated"
    if data["encoder"] not in BACKBONES:
        return f"other encoder: ours is {data['encoder']}"
    if ablations and backbone(data) != BACKBONE:
        return f"printed for {BACKBONE} only: ours is {backbone(data)}"
    return ""


def mark(data: Mapping[str, Any], *, ablations: bool = False) -> str:
    """Return what follows a printed figure: " *not comparable* (why)", or "" where it is."""
    why = not_comparable(data, ablations=ablations)
    return f" {MARK} ({why})" if why else ""


def paper_rows(sources: Sequence[str], data: Mapping[str, Any]) -> list[list[str]]:
    """Return the main table's printed rows for the sources, marked if not comparable."""
    name, columns = backbone(data), [*map(paper_name, sources), "average"]
    return [
        [f"printed: {method}, {name}{mark(data)}", *(_cell(row.get(column)) for column in columns)]
        for method, row in paper()["main"][name].items()
    ]


def target_rows(source: str, targets: Sequence[str], data: Mapping[str, Any]) -> list[list[str]]:
    """Return every method's printed figures from one source on single targets, if printed."""
    sign = f" {MARK}" * bool(not_comparable(data, ablations=True))
    printed = paper()["targets"][BACKBONE].get(paper_name(source), {})
    return [
        [f"{method}{sign}", *(_cell(row.get(paper_name(target))) for target in targets)]
        for method, row in printed.items()
    ]


def ablation_cell(table: str, row: str, source: str) -> str:
    """Return the printed "ACC / F1" of one row of an ablation, or ""."""
    printed = paper()["ablations"].get(table, {}).get(row, {})
    return _cell(printed.get(paper_name(source)))


def _cell(pair: Sequence[float] | None) -> str:
    return "" if pair is None else f"{pair[0]:.1f} / {pair[1]:.1f}"
