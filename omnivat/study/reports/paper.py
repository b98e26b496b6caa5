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


def paper_rows(sources: Sequence[str], data: Mapping[str, Any]) -> list[list[str]]:
    """Return the main table's printed rows for the sources, marked if not comparable."""
    why, name = not_comparable(data), backbone(data)
    mark = f" {MARK} ({why})" if why else ""
    rows = []
    for method, printed in paper()["main"][name].items():
        cells = [_cell(printed.get(paper_name(source))) for source in sources]
        rows.append([f"printed: {method}, {name}{mark}", *cells, _cell(printed.get("average"))])
    return rows


def target_rows(source: str, targets: Sequence[str], data: Mapping[str, Any]) -> list[list[str]]:
    """Return every method's printed figures from one source on single targets, if printed."""
    why = not_comparable(data, ablations=True)
    mark = f" {MARK}" if why else ""
    printed = paper()["targets"][BACKBONE].get(paper_name(source), {})
    return [
        [f"{method}{mark}", *(_cell(row.get(paper_name(target))) for target in targets)]
        for method, row in printed.items()
    ]


def ablation_cell(table: str, row: str, source: str) -> str:
    """Return the printed "ACC / F1" of one row of an ablation, or ""."""
    printed = paper()["ablations"].get(table, {}).get(row, {})
    return _cell(printed.get(paper_name(source)))


def _cell(pair: Sequence[float] | None) -> str:
    return "" if pair is None else f"{pair[0]:.1f} / {pair[1]:.1f}"
