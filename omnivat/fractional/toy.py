"""A toy that shows why the order p matters only after the ReLU.

Two short signals and two clouds in the plane are transformed with order p and then clipped, for the
page. docs/order.md covers the full head.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
import torch
from torch import Tensor

from omnivat.fractional import dfrft
from omnivat.kit.stages import IMAGES

SAMPLES = 64  # of a signal
SPIKE_ORDER = 0.35  # order at which each signal is one spike, as in the chirps set
SPIKES = (22, 43)  # sample of the spike of the photo's and of the touch's signal
POINTS = 40  # of a cloud
CENTRES = ((1.15, 0.55), (0.1, -1.1))  # of the photo's and the touch's cloud
WIDTH = 0.3  # standard deviation of a cloud
DIGITS = 3


def toy(orders: Sequence[float]) -> dict[str, Any]:
    """Return the toy at each of P orders.

    return  {"orders": (P), "signals": {"vis", "tac": {"re", "im": (P, 64)}}, "clouds": {"vis",
            "tac": (P, 40, 2)}, "distances": {"signals", "clouds": {"turned", "clipped": (P)}}}

    `signals` and `clouds` are turned and not yet clipped. `turned` is the distance after the
    transform, the same at every p; `clipped` is the distance after the ReLU on real and imaginary
    parts (Eq. 3). For clouds it is the distance between their middles, the gap.
    """
    signals, clouds = _signals(), _clouds()
    turned = {name: torch.stack([dfrft(x, p) for p in orders]) for name, x in signals.items()}
    angle = -torch.pi / 2 * torch.as_tensor(orders, dtype=torch.float64)
    # of the transform's first coefficient
    turns = torch.polar(torch.ones_like(angle), angle)[:, None]
    spun = {name: turns * z for name, z in clouds.items()}
    planes = {name: torch.view_as_real(x) for name, x in turned.items()}
    flat = {name: torch.view_as_real(x) for name, x in spun.items()}
    return {
        "orders": [float(p) for p in orders],
        "spike": SPIKE_ORDER,
        "signals": {
            name: {"re": _rounded(x[..., 0]), "im": _rounded(x[..., 1])}
            for name, x in planes.items()
        },
        "clouds": {name: _rounded(x) for name, x in flat.items()},
        "distances": {
            "signals": _apart(planes, lambda x: x.flatten(1)),
            "clouds": _apart(flat, lambda x: x.mean(1)),
        },
    }


def _signals() -> dict[str, Tensor]:
    """Return two real chirps (64,) of length one."""
    spikes = torch.eye(SAMPLES, dtype=torch.float64)[list(SPIKES)]
    chirps = [dfrft(spike, -SPIKE_ORDER).real for spike in spikes]
    return {name: chirp / chirp.norm() for name, chirp in zip(IMAGES, chirps, strict=True)}


def _clouds() -> dict[str, Tensor]:
    """Return two clouds (40,) of complex numbers: one coefficient of 40 embeddings."""
    random = np.random.default_rng(7)
    return {
        name: torch.from_numpy(
            (np.array(centre) + WIDTH * random.standard_normal((POINTS, 2))) @ np.array([1, 1j])
        )
        for name, centre in zip(IMAGES, CENTRES, strict=True)
    }


def _apart(parts: dict[str, Tensor], middle: Any) -> dict[str, list[float]]:
    """Return distances (P,) between photo and touch before and after the ReLU."""
    steps = {"turned": lambda x: x, "clipped": torch.relu}
    return {
        step: _rounded((middle(act(parts["vis"])) - middle(act(parts["tac"]))).norm(dim=-1))
        for step, act in steps.items()
    }


def _rounded(values: Tensor) -> Any:
    return values.double().numpy().round(DIGITS).tolist()
