"""Run time against error of the fractional transform, ours and others', in one process.

    python -m benchmarks.fractional [--quick] [--out docs/benchmarks/fractional.json]

Times are milliseconds, median of interleaved rounds, CPU time for one thread and wall clock for
two. Errors are the worst of three rows against 80-bit arithmetic; chirps sample the continuous
transform, so theirs are against that, on the Hermite-Gauss functions 0 and 10. "×" is the time of
torch-frft over that of the method, "share" the time of N²B operations at the rate of a matrix
product over the time of a new p.
"""

from __future__ import annotations

import argparse
import json
import math
import random
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path

import numpy as np
import torch
from torch import Tensor

from benchmarks._fractional_methods import Method, Transform, methods
from benchmarks._machine import Spread, interleaved, machine, product_call, threads
from benchmarks._markdown import table
from benchmarks._reference import reference
from omnivat.kit.files import write_text

SIZES = ((1, 1024), (16, 512), (2000, 512), (20000, 768))
HUGE_SIZE = 2048  # from here on the peer's eigenvectors, found at every call, take minutes
FEW = ((16, 64), (16, 256), (16, 1024), (16, 4096))  # rows and N where calls weigh most
SEVERAL = 21  # orders at once
HUGE = 10**7  # samples; above, slow methods and gradients are left out
CHECKED = 3  # rows compared with the reference
ORDERS = (0.3, 1.7, 1000.3)
PEER = "torch-frft dfrft"
OURS = ("omnivat float32", "omnivat float32, planar")
CHIRP = "torch-frft2d, on one axis (chirp)"


@dataclass(frozen=True)
class Row:
    """One method at one size: milliseconds, and error against 80-bit arithmetic."""

    task: str
    method: str
    rows: int
    size: int
    threads: int
    time: Spread
    error: float | None  # None from HUGE_SIZE on, where the reference takes minutes
    share: float | None  # of the measured rate of matrix products, counting N²B operations


def as_complex(y: Tensor, planar: bool) -> Tensor:
    """Return planar or complex values as complex ones."""
    return torch.complex(y[0], y[1]) if planar else y


def error_of(method: Method, x: Tensor) -> float:
    """Return the worst relative error over some orders."""
    if method.continuous:
        return distance(method, x.shape[-1], (0, 10))
    x = x[:CHECKED].to(method.dtype)
    mine = x.to(method.device)
    worst = 0.0
    for order in ORDERS:
        exact = torch.from_numpy(reference(x.double().numpy(), order))
        found = method.keep(mine)(order).cpu()
        found = as_complex(found, planar=not found.is_complex()).to(torch.complex128)
        worst = max(worst, float((found - exact).norm() / exact.norm()))
    return worst


def distance(method: Method, size: int, degrees: Sequence[int]) -> float:
    """Return the largest distance to the continuous transform, on unit Hermite-Gauss functions.

    Order p multiplies the function of degree k by exp(-iπpk/2). Samples lie at (n - N//2)/√N.
    """
    worst = 0.0
    for degree in degrees:
        x = hermite_gauss(degree, size).to(method.dtype)[None]
        for order in ORDERS[:2]:
            if method.continuous:
                found = method.transform(x, order)
            else:
                found = torch.fft.fftshift(method.transform(torch.fft.ifftshift(x, -1), order), -1)
            exact = x * complex(math.cos(angle := -math.pi / 2 * order * degree), math.sin(angle))
            worst = max(worst, float((found - exact).norm()))
    return worst


def hermite_gauss(degree: int, size: int) -> Tensor:
    """Return the function of a degree at N points, of length 1, by its three-term recurrence."""
    u = (torch.arange(size, dtype=torch.float64) - size // 2) * math.sqrt(2 * math.pi / size)
    before, now = torch.zeros_like(u), torch.exp(-u * u / 2)
    for k in range(1, degree + 1):
        before, now = now, math.sqrt(2 / k) * u * now - math.sqrt((k - 1) / k) * before
    return torch.nn.functional.normalize(now, dim=0)


def backward_call(method: Method, x: Tensor, orders: Callable[[], float]) -> Callable[[], object]:
    """Transform and both gradients, for a fixed gradient of the result."""
    x = x.detach().clone().requires_grad_()
    with torch.no_grad():
        grad = torch.randn_like(method.transform(x, 0.3))

    def call() -> object:
        order = torch.tensor(orders(), requires_grad=True)
        return torch.autograd.grad(method.transform(x, order), (x, order), grad)

    return call


def several(transform: Transform, x: Tensor, *, ours: bool, orders: Callable[[], float]) -> Tensor:
    """Transform all rows by SEVERAL new orders at once."""
    drawn = torch.tensor([orders() for _ in range(SEVERAL)], dtype=torch.float64)
    return transform(x, drawn[:, None] if ours else drawn.to(x.dtype))


def calls_for(
    task: str, methods: dict[str, Method], x: Tensor, orders: Callable[[], float]
) -> dict[str, Callable[[], object]]:
    """Return the calls for a task; methods without it are left out."""
    calls: dict[str, Callable[[], object]] = {}
    for name, method in methods.items():
        mine = x.to(method.device, method.dtype)
        if task == "build" and method.build is not None:
            calls[name] = lambda build=method.build: build(x.shape[-1])  # type: ignore[misc]
        elif task == "new p":
            frame = method.keep(mine)
            calls[name] = lambda frame=frame: frame(orders())  # type: ignore[misc]
        elif task == "new x" and "kept" not in name:
            calls[name] = lambda f=method.transform, y=mine: f(y, orders())  # type: ignore[misc]
        elif task == f"{SEVERAL} orders" and name in (*OURS, CHIRP):
            call = partial(several, method.transform, mine, ours=name in OURS, orders=orders)
            calls[name] = call
        elif task == "forward + backward" and method.differentiable:
            calls[name] = backward_call(method, mine, orders)
    return calls


def measure(rows: int, size: int, count: int, rounds: int) -> list[Row]:
    """Measure all tasks and methods at one size with `count` threads."""
    generator = np.random.default_rng(rows + size)
    x = torch.from_numpy(generator.normal(size=(rows, size)))
    draw = random.Random(size)
    few = (OURS[0], CHIRP, *((PEER,) if size < HUGE_SIZE else ()))
    huge = rows * size > HUGE
    found = {
        name: m
        for name, m in methods().items()
        if not (huge and (m.slow or m.dtype == torch.float64))
        and ((rows, size) not in FEW or name in few)
    }
    errors = {n: error_of(m, x) if size < HUGE_SIZE else None for n, m in found.items()}
    x = x.float() if huge else x
    result = []
    tasks = ["new p", "new x"]
    if not huge:
        tasks = ["build", *tasks, "forward + backward"]
    if (rows, size) in FEW:
        tasks = ["new x", f"{SEVERAL} orders", "forward + backward"]
    for task in tasks:
        calls = calls_for(task, found, x, draw.random)
        product, operations = product_call()
        times = interleaved({**calls, "product": product}, rounds, cpu=count == 1)
        rate = operations / times.pop("product").median
        for name, spread in times.items():
            single = found[name].dtype == torch.float32
            share = rows * size**2 / rate / spread.median if task == "new p" and single else None
            result.append(Row(task, name, rows, size, count, spread, errors[name], share))
    return result


def main() -> None:
    """Measure, then write the results."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="small sizes and few rounds")
    parser.add_argument("--out", type=Path, default=Path("docs/benchmarks/fractional.json"))
    given = parser.parse_args()
    torch.manual_seed(0)
    rows: list[Row] = []
    for count in (1, 2):
        for batch, size in SIZES[:2] if given.quick else SIZES:
            rounds = 3 if given.quick or batch * size > HUGE // 10 else 7
            with threads(count):
                rows += measure(batch, size, count, rounds)
            print(f"{batch} x {size}, {count} thread(s): done", flush=True)
            write(rows, given.out)
    with threads(1):
        for batch, size in () if given.quick else FEW:
            rows += measure(batch, size, 1, 7)
    write(rows, given.out)
    print(report(rows))


def write(rows: list[Row], file: Path) -> None:
    """Write all results so far, so that a long run can be interrupted."""
    record = {"machine": machine(), "rows": [asdict(row) for row in rows]}
    write_text(file, json.dumps(record, indent=1) + "\n")


def report(rows: Sequence[Row]) -> str:
    """Return a table for each size and number of threads, as Markdown."""
    text = []
    for key in dict.fromkeys((r.rows, r.size, r.threads) for r in rows):
        some = [r for r in rows if (r.rows, r.size, r.threads) == key]
        tasks = list(dict.fromkeys(r.task for r in some))
        peer = {r.task: r.time.median for r in some if r.method == PEER}
        head, lines = ["method", "error", "share"], []
        for task in tasks:
            head += [task, "×"]
        for name in dict.fromkeys(r.method for r in some):
            own = {r.task: r for r in some if r.method == name}
            share = own["new p"].share if "new p" in own else None
            error = next(iter(own.values())).error
            cells = [f"{error:.1e}" if error else "", f"{share:.0%}" if share else ""]
            for task in tasks:
                spread = own[task].time if task in own else None
                cells.append(
                    f"{spread.median:.3g} ({spread.low:.3g} to {spread.high:.3g})" if spread else ""
                )
                cells.append(f"{peer[task] / spread.median:.1f}" if spread and task in peer else "")
            lines.append([name, *cells])
        text += ["{} × {}, {} thread(s)".format(*key), "", table(head, lines, "---"), ""]
    return "\n".join(text)


if __name__ == "__main__":
    main()
