"""Measure the gaps of a set at one stage: between the modalities, and between every two domains.

python -m omnivat gaps [--stage S] [--order P] [--measure M] [--json]
"""

import argparse
import json
import sys
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from omnivat.cli.arguments import add_json
from omnivat.cli.features import StageFeatures, add_stage, stage_features
from omnivat.gaps import GAPS

if TYPE_CHECKING:
    from torch import Tensor


def add(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    add_stage(parser)
    parser.add_argument(
        "--measure", choices=list(GAPS), default="centroid", help="centroid if left out"
    )
    add_json(parser)


def run(options: argparse.Namespace) -> None:
    """Compute the features, measure, print the matrices."""
    found = stage_features(options)
    record = {
        "stage": options.stage,
        "order": found.order,
        "measure": options.measure,
        "pairs": len(found.embeddings),
        "simulated": found.embeddings.header.simulated,
        **gaps_of(found, options.measure),
    }
    if options.json:
        json.dump(record, sys.stdout, indent=2, ensure_ascii=False)
        print()
        return
    print(f"{options.measure} at {options.stage}: {found.about}\n")
    if "standard_error" in record:
        print(
            f"estimated by random features, as the set is large; standard error of the gap over all "
            f"pairs ± {record['standard_error']:.2g}\n"
        )
    print("between VIS and TAC")
    for name, value in record["modality_gap"].items():
        print(f"  {name:<18} {value:.4f}")
    for modality in ("vis", "tac"):
        print(f"\nbetween domains, {modality.upper()}")
        print(matrix(record["domain_gap"][modality]))


def gaps_of(found: StageFeatures, measure: str) -> dict[str, Any]:
    """Return "modality_gap": domain (or "all") -> value, "domain_gap": modality -> a -> b -> value."""
    import torch

    from omnivat.gaps.domain import pairwise_gaps
    from omnivat.gaps.unit import unit
    from omnivat.tables import load

    gap = load(GAPS, measure, kind="gap")
    names = found.embeddings.header.domains
    domain = torch.from_numpy(found.embeddings.domain.copy())
    members = {name: domain == i for i, name in enumerate(names) if bool((domain == i).any())}
    units = {modality: unit(rows) for modality, rows in found.rows.items()}
    everywhere = {"all": torch.ones_like(domain, dtype=torch.bool)}
    modality_gap = {
        name: float(gap(units["vis"][inside], units["tac"][inside]))
        for name, inside in (everywhere | members).items()
    }
    domain_gap: dict[str, dict[str, dict[str, float]]] = {}
    for modality, rows in units.items():
        table = {a: dict.fromkeys(members, 0.0) for a in members}
        sets = {name: rows[inside] for name, inside in members.items()}
        for (a, b), value in pairwise_gaps(sets, gap).items():
            table[a][b] = table[b][a] = float(value)
        domain_gap[modality] = table
    return {
        "modality_gap": modality_gap,
        "domain_gap": domain_gap,
        **error_of(measure, units["vis"], units["tac"]),
    }


def error_of(measure: str, vis: "Tensor", tac: "Tensor") -> dict[str, float]:
    """Return the standard error of the gap over all pairs where the measure is an estimate."""
    from omnivat.gaps.mmd import MOST_ROWS, mmd_rbf_estimate

    if measure != "mmd_rbf" or len(vis) + len(tac) <= MOST_ROWS:
        return {}
    return {"standard_error": float(mmd_rbf_estimate(vis, tac).error)}


def matrix(table: Mapping[str, Mapping[str, float]]) -> str:
    """Return a symmetric table as aligned text, domains as rows and columns."""
    width = max((len(name) for name in table), default=0)
    cell = max(9, width + 1)
    lines = [" " * (width + 2) + "".join(f"{name:>{cell}}" for name in table)]
    for name, row in table.items():
        values = (f"{'·' if name == other else format(row[other], '.4f'):>{cell}}" for other in row)
        lines.append(f"  {name:<{width}}" + "".join(values))
    return "\n".join(lines)
