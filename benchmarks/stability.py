"""Worst errors of the fractional transform over orders, lengths, scales, precisions and chains.

    python -m benchmarks.stability [--quick] [--out docs/benchmarks/stability.json]

Prints a table and writes the record. Exits with 1 when an error is above its target.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path

import torch
from torch import Tensor

from benchmarks._markdown import table
from benchmarks._reference import reference
from omnivat.fractional import dfrft
from omnivat.kit.files import write_text

SIZES = (1, 2, 3, 4, 5, 6, 7, 8, 63, 64, 65, 511, 512, 513, 768, 1024, 2048, 4096)
QUICK = (1, 2, 3, 4, 5, 8, 63, 64, 512)
NEAR = [sign * 10.0**power for power in range(-12, 0) for sign in (1, -1)]
ORDERS = {
    "whole": [0.0, 1.0, 2.0, 3.0, -1.0, 401.0],
    "near whole": [n + d for n, d in zip([0, 1, 2, 3] * 6, NEAR, strict=True)],
    "between": [0.3, 0.5, 1.7, -2.6],
    "thousands": [1000.3, -1234.56],
    "millions": [1e6, 1e6 + 0.37, -1e6 + 0.123],
    "denormal": [5e-324, -1e-310, 1e-300],
}
SCALES = (1e-30, 1.0, 1e30)
REFERENCE = {torch.float64: 4e-15, torch.float32: 1.5e-6}
UNITARITY = {torch.float64: 1.2e-14, torch.float32: 3e-6}
STEPS = 1000


@dataclass(frozen=True)
class Cell:
    """The worst relative error of one check, with its limit."""

    check: str
    size: int
    dtype: str
    error: float
    target: float


def relative(computed: Tensor, exact: Tensor) -> float:
    """Return |computed - exact| / |exact|, in float64."""
    wide = computed.to(torch.complex128)
    return float((wide - exact).norm() / exact.norm())


def samples(size: int) -> Tensor:
    """Return two fixed vectors (2, N), float64, that float32 holds exactly."""
    generator = torch.Generator().manual_seed(size)
    return torch.randn(2, size, generator=generator).double()


def against_reference(size: int, dtype: torch.dtype) -> list[Cell]:
    """Measure every group of orders, at three scales, with autocast on for one."""
    x, name = samples(size), str(dtype).removeprefix("torch.")
    cells = []
    for group, orders in ORDERS.items():
        # long arithmetic is slow: the longest vectors use a few orders of each group
        chosen = orders if size < 600 else orders[:2]
        worst = 0.0
        for order in chosen:
            exact = torch.from_numpy(reference(x.numpy(), order))
            worst = max(worst, relative(dfrft(x.to(dtype), order), exact))
            kept = torch.tensor(order, dtype=torch.float64, requires_grad=True)  # no short path
            worst = max(worst, relative(dfrft(x.to(dtype), kept).detach(), exact))
        cells.append(Cell(f"p {group}", size, name, worst, REFERENCE[dtype]))
    exact, worst = torch.from_numpy(reference(x.numpy(), 0.3)), 0.0
    for scale in SCALES:
        scaled = (x * scale).to(dtype)
        ideal = torch.from_numpy(reference(scaled.double().numpy() / scale, 0.3))
        worst = max(worst, relative(dfrft(scaled, 0.3).to(torch.complex128) / scale, ideal))
    cells.append(Cell("scale 1e-30 … 1e30", size, name, worst, REFERENCE[dtype]))
    with torch.autocast("cpu", dtype=torch.bfloat16):
        found = dfrft(x.to(dtype), 0.3)
    cells.append(Cell("autocast", size, name, relative(found, exact), REFERENCE[dtype]))
    return cells


def laws(size: int, dtype: torch.dtype) -> list[Cell]:
    """Measure there and back, sums of orders, a long chain of small steps, and both gradients."""
    x, name, bound = samples(size).to(dtype), str(dtype).removeprefix("torch."), UNITARITY[dtype]
    wide = x.to(torch.complex128)
    back = relative(dfrft(dfrft(x, 0.375), -0.375), wide)
    added = relative(dfrft(dfrft(x, 0.375), 0.8125), dfrft(x, 1.1875).to(torch.complex128))
    cells = [
        Cell("unitarity", size, name, back, bound),
        Cell("additivity", size, name, added, bound * 4 / 3),
    ]
    step, y = 2.0**-10, x
    for _ in range(STEPS):
        y = dfrft(y, step)
    chain = relative(y, dfrft(x, STEPS * step).to(torch.complex128))
    cells.append(Cell(f"{STEPS} steps", size, name, chain, REFERENCE[dtype] * STEPS**0.5 * 2))
    return [*cells, gradients(size, dtype)]


def gradients(size: int, dtype: torch.dtype) -> Cell:
    """Measure both gradients of a random linear loss at p = 0.3 and 1."""
    x, worst = samples(size).to(dtype).requires_grad_(), 0.0
    weight = samples(size).flip(0).to(dtype)
    for order in (0.3, 1.0):
        p = torch.tensor(order, dtype=torch.float64, requires_grad=True)
        to_x, to_p = torch.autograd.grad((dfrft(x, p).real * weight).sum(), (x, p))
        exact_x = torch.from_numpy(reference(weight.double().numpy(), order)).real
        slope = torch.from_numpy(reference(x.detach().double().numpy(), order, power=1))
        exact_p = (slope.real * weight).sum()
        scale = max(float(slope.norm() * weight.norm()), 1e-300)
        worst = max(worst, float((to_p - exact_p).abs()) / scale)
        worst = max(worst, float((to_x.double() - exact_x).norm() / weight.double().norm()))
    name = str(dtype).removeprefix("torch.")
    return Cell("gradients", size, name, worst, REFERENCE[dtype])


def report(cells: list[Cell]) -> str:
    """Markdown: worst error and target of each check and precision, and where it is worst."""
    rows = []
    for key in dict.fromkeys((c.check, c.dtype) for c in cells):
        worst = max(
            (c for c in cells if (c.check, c.dtype) == key),
            key=lambda c: math.inf if math.isnan(c.error) else c.error / c.target,
        )
        met = "yes" if worst.error <= worst.target else "**no**"
        rows.append([*key, f"{worst.error:.1e}", str(worst.size), f"{worst.target:.1e}", met])
    return table(["check", "dtype", "worst", "at N", "target", "met"], rows, "---")


def measure(sizes: tuple[int, ...], on_size: Callable[[int], None]) -> list[Cell]:
    """Return the worst errors of all checks, at all lengths and in both precisions."""
    cells: list[Cell] = []
    for size in sizes:
        for dtype in (torch.float64, torch.float32):
            cells += against_reference(size, dtype) + laws(size, dtype)
        on_size(size)
    return cells


def main(arguments: list[str] | None = None) -> int:
    """Measure and write; return 0 if every target is met, else 1."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="lengths up to 512 only")
    parser.add_argument("--out", type=Path, default=Path("docs/benchmarks/stability.json"))
    given = parser.parse_args(arguments)
    sizes = QUICK if given.quick else SIZES
    cells = measure(sizes, lambda size: print(f"N = {size}: done", flush=True))
    record = json.dumps([asdict(cell) for cell in cells], indent=1)
    write_text(given.out, record + "\n")
    print(report(cells))
    missed = [cell for cell in cells if not cell.error <= cell.target]
    for cell in missed:
        print(f"missed: {cell}", file=sys.stderr)
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
