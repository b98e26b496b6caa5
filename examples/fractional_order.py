"""A step seen at several fractional orders, from itself (p = 0) to its spectrum (p = 1).

python -m examples.fractional_order [FILE.svg]    FILE: also draw a chirp at three orders
"""

import sys

import torch

from omnivat import coefficients, dfrft, synthesise
from omnivat.figures import lines, write

step = torch.zeros(64, dtype=torch.float64)
step[24:40] = 1
kept = coefficients(step)  # once; every order after that is one small product
for order in torch.linspace(0, 1, 6, dtype=torch.float64):
    moved = synthesise(kept, order)
    bars = "".join(" .:-=+*#%@"[min(9, int(6 * float(v)))] for v in moved.abs())
    print(f"p = {order:.1f}  |{bars}|  length {moved.norm():.6f}")

spike = torch.zeros(64, dtype=torch.float64)
spike[20] = 1
chirp = dfrft(spike, -0.35)  # a signal that is a single spike at p = 0.35
if len(sys.argv) > 1 and sys.argv[1].endswith(".svg"):
    seen = {f"p = {p:g}": (range(64), dfrft(chirp, p).abs().tolist()) for p in (0, 0.35, 1)}
    chart = lines(seen, title="One chirp at three orders", across="sample", up="magnitude",
                  caption="p = 0 shows the signal, p = 1 its spectrum. At 0.35, one sample holds all of it.")  # fmt: skip  # noqa: E501
    write(sys.argv[1], chart)
