"""A sweep of 101 orders over 2,000 pairs, against a lower bound of operations.

    python -m benchmarks.sweep [--widths 64,512] [--pairs 2000] [--orders 101] [--runs 3]
                              [--threads N] [--out FILE]

Embeddings are random with width 512 (times do not depend on their values); the head is untrained.
The predictions of the sweep are compared with the head's before timing.
"""

import argparse
import json
import resource
from pathlib import Path
from typing import Any

import numpy as np
import torch

from benchmarks.measure import as_dict, machine, product_rate, timed
from omnivat.data.materials import MATERIALS
from omnivat.data.store import ROW_NAMES, Embeddings, Header
from omnivat.head.head import OmniVaT, build_head
from omnivat.head.settings import HeadSettings
from omnivat.maps.sweep import sweep

TARGETS = {64: 3.0, 512: 45.0}  # wall seconds on two cores
INPUT_WIDTH = 512


def made_embeddings(pairs: int) -> Embeddings:
    """Return random embeddings of eight domains and five classes."""
    rng = np.random.default_rng(0)
    return Embeddings(
        header=Header(
            encoder="random",
            weights_hash="none",
            preprocessing="none",
            domains=tuple(f"domain {k}" for k in range(8)),
            classes=MATERIALS,
            simulated=True,
        ),
        vis=rng.normal(size=(pairs, INPUT_WIDTH)).astype(np.float32),
        tac=rng.normal(size=(pairs, INPUT_WIDTH)).astype(np.float32),
        domain=rng.integers(0, 8, pairs),
        label=rng.integers(0, len(MATERIALS), pairs),
        rows={name: [""] * pairs for name in ROW_NAMES},
    )


def floor_operations(model: OmniVaT) -> int:
    """Count the operations of one pair at one order that remain after all known simplifications.

    With D the width: the transform of a real vector D² (cached coefficients, quarter split);
    scores between the distinct rectified parts, two for each sign among θ_e, through one D×D
    matrix; values folded into the feed-forward network's first layer, and its second; each for
    two modalities; DTG folded into one matrix, once. Products count 2 D². Element-wise work and
    the classifier are not counted.
    """
    settings = model.settings
    square, signs = settings.width**2, 0
    for theta in (model.mffa.theta["vis"], model.mffa.theta["tac"]):
        signs += int((theta > 0).any()) + int((theta < 0).any())
    modalities = 2 * square + 2 * signs * 2 * square + 2 * 2 * 2 * settings.ffn_ratio * square
    return modalities + 2 * square


def report_width(width: int, arguments: argparse.Namespace) -> dict[str, Any]:
    """Check and time the sweep of one width of head."""
    embeddings = made_embeddings(arguments.pairs)
    settings = HeadSettings(classes=MATERIALS, input_width=INPUT_WIDTH, width=width)
    model = build_head(settings).eval()
    orders = np.linspace(0, 1, arguments.orders).tolist()
    require_right(model, embeddings, orders[: len(orders) // 2 + 1 : max(len(orders) // 4, 1)])
    time = timed(lambda: sweep(model, embeddings, orders), arguments.runs)
    answers = timed(lambda: sweep(model, embeddings, orders[::10], stages=(), measures=("accuracy",)), 1)
    rate = product_rate(width)
    floor = floor_operations(model) * arguments.pairs * arguments.orders / rate
    return {
        "width": width,
        "time": as_dict(time),
        "target_wall": TARGETS.get(width),
        "head_share": answers.cpu / len(orders[::10]) * len(orders) / time.cpu,
        "product_rate": rate,
        "floor_cpu": floor,
        "share_of_floor": floor / time.cpu,
        "peak_memory_mb": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024,
    }


@torch.no_grad()
def require_right(model: OmniVaT, embeddings: Embeddings, orders: list[float]) -> None:
    """Raise an error if the sweep's predictions differ from the head's."""
    found = sweep(model, embeddings, orders)
    for place, order in enumerate(orders):
        direct = model(torch.tensor(embeddings.vis), torch.tensor(embeddings.tac), order=order)
        torch.testing.assert_close(torch.tensor(found.probabilities[place]), direct.probabilities)


def show(report: dict[str, Any]) -> None:
    """Print the table of docs/benchmarks/sweep.md."""
    print(json.dumps(report["machine"]))
    print("| D | wall s (low to high) | target | CPU s | in the head | rate | floor, CPU s | share |")
    print("| --- | --- | --- | --- | --- | --- | --- | --- |")
    for row in report["widths"]:
        time = row["time"]
        print(
            f"| {row['width']} | {time['wall']:.1f} ({time['wall_low']:.1f} to "
            f"{time['wall_high']:.1f}) | {row['target_wall']} | {time['cpu']:.1f} "
            f"| {row['head_share']:.0%} "
            f"| {row['product_rate'] / 1e9:.0f} GFLOP/s | {row['floor_cpu']:.1f} "
            f"| {row['share_of_floor']:.0%} |"
        )
    print(f"peak memory {report['widths'][-1]['peak_memory_mb']:.0f} MB")


def main() -> None:
    """Read the arguments, measure, print, and write the JSON where asked."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--widths", default="64,512")
    parser.add_argument("--pairs", type=int, default=2000)
    parser.add_argument("--orders", type=int, default=101)
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--threads", type=int, default=torch.get_num_threads())
    parser.add_argument("--out", type=Path)
    arguments = parser.parse_args()
    torch.set_num_threads(arguments.threads)
    widths = [int(width) for width in arguments.widths.split(",")]
    report = {
        "machine": machine(),
        "pairs": arguments.pairs,
        "orders": arguments.orders,
        "widths": [report_width(width, arguments) for width in widths],
    }
    show(report)
    if arguments.out:
        arguments.out.write_text(json.dumps(report, indent=2) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
