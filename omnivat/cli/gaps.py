"""Measure the gaps of a set at one stage: between modalities, and between all pairs of domains.

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
        "--measure", choices=list(GAPS), default="centroid", help="default: centroid"
    )
    add_json(parser)


def run(options: argparse.Namespace) -> None:
    """Compute the features, measure, print the matrices."""
    found = stage_features(options, by_domain=True)
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
            f"estimated by random features, because the set is large; standard error of the gap over all "
            f"pairs ± {record['standard_error']:.2g}\n"
        )
    print("between VIS and TAC")
    for name, value in record["modality_gap"].items():
        print(f"  {name:<18} {value:.4f}")
    for modality in ("vis", "tac"):
        print(f"\nbetween domains, {modality.upper()}")
        print(matrix(record["domain_gap"][modality]))


def gaps_of(found: StageFeatures, measure: str) -> dict[str, Any]:
    """Return "modality_gap": domain (or "all") -> value, "domain_gap": modality -> a -> b -> value.

    found  points in the order of their domains, from `stage_features(by_domain=True)`
    """
    import numpy as np

    from omnivat.gaps.domain import pairwise_gaps
    from omnivat.tables import load

    gap = load(GAPS, measure, kind="gap")
    names = found.embeddings.header.domains
    sizes = np.bincount(found.embeddings.domain, minlength=len(names)).tolist()
    sets = {
        modality: {
            name: rows for name, rows in zip(names, every.split(sizes), strict=True) if len(rows)
        }
        for modality, every in found.rows.items()
    }
    vis, tac = found.rows["vis"], found.rows["tac"]
    modality_gap = {"all": float(gap(vis, tac))}
    modality_gap |= {name: float(gap(sets["vis"][name], sets["tac"][name])) for name in sets["vis"]}
    domain_gap: dict[str, dict[str, dict[str, float]]] = {}
    for modality, own in sets.items():
        table = {a: dict.fromkeys(own, 0.0) for a in own}
        for (a, b), value in pairwise_gaps(own, gap).items():
            table[a][b] = table[b][a] = float(value)
        domain_gap[modality] = table
    return {
        "modality_gap": modality_gap,
        "domain_gap": domain_gap,
        **error_of(measure, vis, tac),
    }


def error_of(measure: str, vis: "Tensor", tac: "Tensor") -> dict[str, float]:
    """Return the standard error of the gap over all pairs if the measure is an estimate."""
    from omnivat.gaps.mmd import is_estimated, mmd_rbf_estimate

    if measure != "mmd_rbf" or not is_estimated(vis, tac):
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
