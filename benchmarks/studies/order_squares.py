"""Orders or seeds: Latin squares of heads, with F_p and with controls in its place.

    python -m benchmarks.studies.order_squares [--kinds order,group] [--width 64] [--noise 0]
                                               [--size 5] [--sources TAG-sim,...] [--out FILE]
                                               [--head trained | ridge]
    python -m benchmarks.studies.order_squares --table [FILE ...]

A square is n x n heads of one source: n rows by n seeds. Rows are orders, evenly spaced from 0 to 1
("order": F_p, "group": exp(pA) of one random A), or random unitaries ("unitary"). Ensembles average
the probabilities of n heads: a row (n seeds), a column (n orders, one seed), a diagonal of either
direction (n orders, each with a seed of its own). "trained" is the head of the
page; "ridge" its first layers untrained (a random dense map, the transform, ReLU of both signs) and a
ridge regression in closed form: hundreds cost minutes. A line of the record is one square: what each head and each ensemble
predicts for every test pair, a digit a pair. --table recomputes every figure from the records.
"""

import argparse
import gzip
import json
from collections.abc import Sequence
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from scipy import stats
from torch import Tensor

from benchmarks.studies._order_matrix import heads_with, matrix_of
from benchmarks.studies._order_runs import QUICK_SENSORS
from omnivat.data.store import Embeddings, load_embeddings
from omnivat.head.head import build_head
from omnivat.head.heads import default_embeddings
from omnivat.kit.seeding import derive_seed
from omnivat.kit.stages import IMAGES
from omnivat.measure.evaluate import label_map, predicted_probabilities
from omnivat.measure.unseen import counted
from omnivat.training import train
from omnivat.training.batches import labels_of
from omnivat.training.from_pairs import plan_training
from omnivat.training.from_pairs.plan import TrainingPlan
from omnivat.training.order_search import RIDGE

MARGIN = 0.5  # points: orders and seeds are equivalent within it (docs/log.md)
OUT = Path("docs/benchmarks/order_squares.jsonl.gz")
Square = dict[str, Any]


def square(head: str, kind: str, width: int, noise: float, source: str, size: int, made: Embeddings) -> Square:
    """Train the heads of one source; return what heads and ensembles predict."""
    torch.set_num_threads(1)
    plan = plan_training(made, source, head={"width": width}, training=replace(QUICK_SENSORS, noise=noise))
    shares_of = _ridge if head == "ridge" else _trained
    cells: list[list[NDArray[np.float32]]] = []
    for row, stop in enumerate(np.linspace(0, 1, size).tolist()):
        matrix = matrix_of(kind, width, stop, draw=row if kind == "unitary" else 0)
        found = [shares_of(plan.at(stop, seed), matrix) for seed in range(size)]
        cells.append(found)
    keep = counted(made, source)
    shares = np.array(cells)[:, :, keep]  # (row, seed, pair, class)
    votes = {name: _digits(shares[rows, seeds].mean(0)) for name, rows, seeds in ensembles(size)}
    label = label_map(plan.settings.classes, made.header.classes)[made.label] % 10  # -1 becomes 9
    return {
        "head": head,
        "kind": kind,
        "width": width,
        "noise": noise,
        "source": source,
        "label": "".join(map(str, label[keep])),
        "domain": "".join(map(str, made.domain[keep])),
        "own": made.header.domains.index(source),
        "heads": [[_digits(one) for one in row] for row in shares],
        "ensembles": votes,
    }


def _trained(plan: TrainingPlan, matrix: Tensor) -> NDArray[np.float32]:
    """Return the probabilities (N, K) of a trained head with `matrix` in place of F_p."""
    with heads_with(matrix):
        model = train(plan.pairs, plan.settings, plan.training, bank=plan.bank, seed=plan.seed).model
        shares: NDArray[np.float32] = predicted_probabilities(model, plan.embeddings)["fused"].numpy()
    return shares


def _ridge(plan: TrainingPlan, matrix: Tensor) -> NDArray[np.float32]:
    """Return the outputs (N, K) of a ridge regression on the tokens of an untrained head.

    With noise, it learns from four noisy copies of every pair.
    """
    model = build_head(plan.settings, seed=derive_seed(plan.seed, "weights")).eval()
    fit = {n: torch.from_numpy(np.array(getattr(plan.pairs, n), np.float32)) for n in IMAGES}
    targets = torch.eye(len(plan.settings.classes))[labels_of(plan.pairs, plan.settings)]
    if plan.training.noise:
        random = torch.Generator().manual_seed(plan.seed)
        targets = targets.repeat(4, 1)
        for name, rows in fit.items():
            rows, scale = rows.repeat(4, 1), plan.training.noise * rows.std(0)
            fit[name] = rows + scale * torch.randn(rows.shape, generator=random)
    rest = {n: torch.from_numpy(np.array(getattr(plan.embeddings, n), np.float32)) for n in IMAGES}
    planes = torch.view_as_real(matrix.mT).movedim(-1, 0).float()[:, None]
    with torch.inference_mode():
        first, second = (_tokens(model.embedded(rows) @ planes) for rows in (fit, rest))
    middle = first.mean(0)
    gram = (first - middle) @ (first - middle).T
    gram.diagonal().add_(RIDGE * gram.diagonal().mean())
    weights = torch.linalg.solve(gram, targets - targets.mean(0))
    outputs: NDArray[np.float32] = ((second - middle) @ ((first - middle).T @ weights)).numpy()
    return outputs


def _tokens(parts: Tensor) -> Tensor:
    """Return ReLU of both signs of both parts of both halves: (2, M, N, D) -> (N, 8 D)."""
    return torch.cat((parts.relu(), (-parts).relu())).flatten(0, 1).movedim(0, 1).flatten(1)


def ensembles(size: int) -> list[tuple[str, list[int], list[int]]]:
    """Return the name, rows and seeds of every ensemble of a square."""
    line = list(range(size))
    found = [(f"seeds {k}", [k] * size, line) for k in line]
    found += [(f"orders, one seed {k}", line, [k] * size) for k in line]
    for way, name in ((1, "+"), (-1, "-")):
        found += [(f"orders {name}{k}", line, [(k + way * i) % size for i in line]) for k in line]
    pairs = list(product(line, line))
    return [*found, ("all", [a for a, _ in pairs], [b for _, b in pairs])]


def _digits(shares: NDArray[np.float32]) -> str:
    return "".join(map(str, shares.argmax(-1)))


def accuracy(found: Square, predicted: str) -> float:
    """Return the accuracy (%) of predictions, mean over unseen domains."""
    label, domain, digits = (_array(found["label"]), _array(found["domain"]), _array(predicted))
    own = [(digits == label)[domain == d].mean() for d in set(domain) - {found["own"]}]
    return 100 * float(np.mean(own))


def _array(digits: str) -> NDArray[np.int64]:
    return np.array(list(digits), dtype=np.int64)


def summary(found: Square) -> dict[str, float]:
    """Return the figures of a square: mean accuracies (%) and disagreement (%) of two heads."""
    votes = {name: accuracy(found, predicted) for name, predicted in found["ensembles"].items()}
    heads = np.array([[accuracy(found, one) for one in row] for row in found["heads"]])

    def mean(kind: str) -> float:
        return float(np.mean([v for name, v in votes.items() if name.rpartition(" ")[0] == kind]))

    return {
        "one": float(heads.mean()),
        "seeds": mean("seeds"),
        "orders": mean("orders"),
        "orders, one seed": mean("orders, one seed"),
        "all": votes["all"],
        "row 0": float(heads[0].mean()),
        "spread over orders": float(heads.mean(1).std(ddof=1)),
        "spread over seeds": float(np.sqrt(heads.var(1, ddof=1).mean())),
        "differ by seed": _disagreement(found, across=False),
        "differ by order": _disagreement(found, across=True),
    }


def _disagreement(found: Square, *, across: bool) -> float:
    """Return how many unseen pairs (%) two heads predict differently: same row, or same seed."""
    heads = np.array([[list(one) for one in row] for row in found["heads"]])
    heads = heads[:, :, _array(found["domain"]) != found["own"]]
    heads = heads.swapaxes(0, 1) if across else heads
    pairs = [(heads[:, a] != heads[:, b]).mean() for a in range(len(heads)) for b in range(a)]
    return 100 * float(np.mean(pairs))


def interval(values: Sequence[float], share: float) -> tuple[float, float, float]:
    """Return mean and Student's interval over sources."""
    mean, error = float(np.mean(values)), float(stats.sem(values))
    half = float(stats.t.ppf(0.5 + share / 2, len(values) - 1)) * error
    return mean, mean - half, mean + half


def table(squares: Sequence[Square]) -> str:
    """Return all figures by kind, width and noise, in Markdown."""
    lines = [
        "| head | transform | D | noise | n | sources | one head | n seeds | n orders "
        "| ... of one seed | all n² | orders less seeds [90 %] | within ± 0.5 | two heads differ: "
        "seeds, orders | spread: orders, seeds alone |",
        "| " + " | ".join(["---"] * 15) + " |",
    ]
    for key, rows in summaries(squares).items():
        mean = {name: float(np.mean([row[name] for row in rows])) for name in rows[0]}
        found = "–"
        within = "–"
        if len(rows) > 1:
            middle, low, high = less(rows)
            found = f"{middle:+.2f} [{low:+.2f}, {high:+.2f}]"
            within = "yes" if max(-low, high) < MARGIN else "no"
        figures = " | ".join(f"{mean[name]:.2f}" for name in ("one", "seeds", "orders", "orders, one seed", "all"))
        expected = mean["spread over seeds"] / key[4] ** 0.5
        lines.append(
            f"| {key[0]} | {key[1]} | {key[2]} | {key[3]:g} | {key[4]} | {len(rows)} | {figures} | {found} | {within} | "
            f"{mean['differ by seed']:.1f}, {mean['differ by order']:.1f} % | "
            f"{mean['spread over orders']:.2f}, {expected:.2f} |"
        )
    return "\n".join(lines)


def summaries(squares: Sequence[Square]) -> dict[tuple[str, str, int, float, int], list[Any]]:
    """Return (head, kind, width, noise, n) -> the summary of each source."""
    found: dict[tuple[str, str, int, float, int], list[Any]] = {}
    for one in squares:
        found.setdefault(_group(one), []).append(summary(one))
    return found


def less(rows: Sequence[dict[str, float]]) -> tuple[float, float, float]:
    """Return "n orders less n seeds" with its 90 % interval over sources."""
    return interval([row["orders"] - row["seeds"] for row in rows], 0.9)


def _group(found: Square) -> tuple[str, str, int, float, int]:
    names = (found["head"], found["kind"], found["width"], found["noise"])
    return (*names, len(found["heads"]))


def squares_of(files: Sequence[Path]) -> list[Square]:
    """Return the squares of record files; a file may be compressed."""
    found = []
    for file in files:
        data = file.read_bytes()
        text = gzip.decompress(data) if file.suffix == ".gz" else data
        found += [json.loads(line) for line in text.decode().splitlines()]
    return found


def main() -> None:
    """Make the missing squares, or print the table of the existing ones."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--head", choices=["trained", "ridge"], default="trained")
    parser.add_argument("--kinds", default="order")
    parser.add_argument("--width", type=int, default=64)
    parser.add_argument("--noise", type=float, default=0.0)
    parser.add_argument("--size", type=int, default=5, help="n")
    parser.add_argument("--sources", help="with commas; all domains if left out")
    parser.add_argument("--out", type=Path, default=Path("order_squares.jsonl"))
    parser.add_argument("--table", nargs="*", type=Path)
    options = parser.parse_args()
    if options.table is not None:
        return print(table(squares_of(options.table or [OUT])))
    there = squares_of([options.out]) if options.out.is_file() else []
    done = {(*_group(one), one["source"]) for one in there}
    made = load_embeddings(default_embeddings())
    sources = options.sources.split(",") if options.sources else made.header.domains
    for kind, source in product(options.kinds.split(","), sources):
        settings = (options.head, kind, options.width, options.noise)
        if (*settings, options.size, source) in done:
            continue
        found = square(*settings, source, options.size, made)
        with options.out.open("a", encoding="utf-8") as handle:
            handle.write(json.dumps(found) + "\n")
        print(*settings, source, {k: round(v, 2) for k, v in summary(found).items()}, flush=True)
    return None


if __name__ == "__main__":
    main()
