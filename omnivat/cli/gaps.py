"""Measure the gaps of a set at one stage: between modalities, and between all pairs of domains.

python -m omnivat gaps [--stage S] [--order P] [--measure M] [--json] [--figure FILE]
"""

import argparse
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from omnivat.cli.arguments import as_json, declare, figure, one_of
from omnivat.cli.features import StageFeatures, add_stage, stage_features
from omnivat.measure.gaps import GAPS

LARGE = 50_000  # pairs; more are not held in memory for an exact measure


def add(parser: argparse.ArgumentParser) -> None:
    add_stage(parser)
    declare(parser, "json", measure=one_of(list(GAPS), first="centroid"))
    figure(parser, "the gaps between domains")


def run(options: argparse.Namespace) -> None:
    """Compute the features, measure, print the matrices."""
    features = stage_features(options)
    record = {
        "stage": options.stage,
        "order": features.order,
        "measure": options.measure,
        "pairs": len(features.embeddings),
        "simulated": features.embeddings.header.simulated,
        **gaps_of(features, options.measure),
    }
    if options.figure:
        from omnivat.figures import gap_tables, write

        write(options.figure, gap_tables(record))
    if options.json:
        return print(as_json(record))
    print(f"{options.measure} at {options.stage}: {features.about}\n")
    if "standard_error" in record:
        print(
            f"estimated from {record['drawn']:,} random pairs, because the set is large; standard"
            f" error of a gap at most ± {record['standard_error']:.2g}\n"
        )
    levels = {name: value for name, value in record["floor"].items() if value is not None}
    level = ", ".join(f"{name.upper()} {value:.4f}" for name, value in levels.items())
    print(f"two random halves of one domain, mean over domains: {level or 'too few pairs'}\n")
    print("between VIS and TAC")
    for name, value in record["modality_gap"].items():
        print(f"  {name:<18} {value:.4f}")
    for modality in ("vis", "tac"):
        print(f"\nbetween domains, {modality.upper()}")
        print(matrix(record["domain_gap"][modality]))


def gaps_of(features: StageFeatures, measure: str) -> dict[str, Any]:
    """Return the gaps as `omnivat.measure.gaps.domain.gap_record` has them.

    Of a large set, exact measures come from moments, and the others from random pairs of each
    domain: then also "drawn" pairs and the largest "standard_error" of a value.
    """
    from omnivat.measure.gaps.domain import gap_record
    from omnivat.measure.gaps.large import ESTIMATES, MOMENT_GAPS, drawn, moments_of, parts_of
    from omnivat.measure.gaps.mmd import MOST_ROWS

    data, names = features.embeddings, features.embeddings.header.domains
    if measure in ESTIMATES and 2 * len(data) > MOST_ROWS:
        rows, alike = drawn(data.domain)
        some = replace(features, embeddings=data.select(rows))
        sets, every = parts_of(some.points(), data.domain[rows], names, alike)
        errors = []

        def estimated(a: Any, b: Any) -> Any:
            found = ESTIMATES[measure](a, b)
            errors.append(float(found.error))
            return found.value

        record = gap_record(every, sets, estimated)
        return record | {"drawn": len(rows), "standard_error": max(errors)}
    if measure in MOMENT_GAPS and len(data) > LARGE:
        squares = measure == "frechet"
        of_domains, whole, halves = moments_of(
            features.blocks(), data.domain, names, squares=squares
        )
        return gap_record(whole, of_domains, MOMENT_GAPS[measure], halves)
    sets, every = parts_of(features.points(), data.domain, names)
    return gap_record(every, sets, measure)


def matrix(table: Mapping[str, Mapping[str, float]]) -> str:
    """Return a symmetric table as aligned text, domains as rows and columns."""
    width = max((len(name) for name in table), default=0)
    cell = max(9, width + 1)
    lines = [" " * (width + 2) + "".join(f"{name:>{cell}}" for name in table)]
    for name, row in table.items():
        values = (f"{'·' if name == other else format(row[other], '.4f'):>{cell}}" for other in row)
        lines.append(f"  {name:<{width}}" + "".join(values))
    return "\n".join(lines)
