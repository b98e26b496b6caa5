"""A step seen at several fractional orders: from itself (p = 0) to its spectrum (p = 1).

python -m examples.fractional_order
"""

import torch

from omnivat import coefficients, synthesise

step = torch.zeros(64, dtype=torch.float64)
step[24:40] = 1
kept = coefficients(step)  # once; every order after that is one small product
for order in torch.linspace(0, 1, 6, dtype=torch.float64):
    moved = synthesise(kept, order)
    bars = "".join(" .:-=+*#%@"[min(9, int(6 * float(v)))] for v in moved.abs())
    print(f"p = {order:.1f}  |{bars}|  length {moved.norm():.6f}")
