"""Check arguments: vectors, axes and orders."""

from __future__ import annotations

import math
from contextlib import AbstractContextManager, nullcontext
from typing import Any

import torch
from jaxtyping import Float64, Shaped
from torch import Tensor
from torch.autograd.forward_ad import unpack_dual

from omnivat.kit.errors import SettingsError, ShapeError
from omnivat.kit.shapes import dense


def axis_from_end(x: Shaped[Tensor, "..."], dim: int) -> int:
    """Return dim counted from the end (-1 is the last axis), after checking the axis."""
    shape = tuple(x.shape)
    if not -len(shape) <= dim < len(shape):
        raise ShapeError(f"x has shape {shape}, expected an axis {dim}: choose an existing axis.")
    if shape[dim] == 0:
        raise ShapeError(f"x has shape {shape}, expected one sample or more along axis {dim}.")
    return dim - len(shape) if dim >= 0 else dim


def under_transform(*tensors: Tensor) -> bool:
    """True inside `torch.func` transforms (vmap, jvp, grad) and for tensors with a tangent.

    Their values cannot be read, and every operation must be an autograd function.
    """
    if torch._C._are_functorch_transforms_active():
        return True
    return any(unpack_dual(tensor).tangent is not None for tensor in tensors)


def readable(order: Tensor) -> bool:
    """True if the numbers of an order can be read: on the CPU, not transformed, not exported."""
    traced = torch.compiler.is_exporting() or under_transform(order)
    return order.device.type == "cpu" and not traced


def checked_order(order: float | Tensor | Any, device: torch.device) -> Float64[Tensor, "..."]:
    """Return the order as float64 on `device`; it stays in the graph.

    A Python int of any size is reduced modulo 4 exactly. An order on an accelerator, under a
    `torch.func` transform or in a program being exported is not read, so there NaN gives NaN rows.
    Raises SettingsError for NaN, infinite or complex orders.
    """
    if isinstance(order, int):
        order %= 4
    if isinstance(order, int | float) and math.isfinite(order):
        return torch.full((), order, dtype=torch.float64, device=device)
    try:
        turns = order if isinstance(order, Tensor) else torch.as_tensor(order, dtype=torch.float64)
    except (TypeError, ValueError, OverflowError, RuntimeError) as error:
        raise SettingsError(
            f"The order is {order!r:.60}, expected a finite real number, or a tensor of them."
        ) from error
    if turns.is_complex():
        raise SettingsError(f"The order is complex ({turns.dtype}), expected real quarter turns.")
    turns = dense("The order", turns, torch.float64)
    if turns.is_meta and device.type != "meta":
        raise SettingsError("The order has no values, as it is a meta tensor; give quarter turns.")
    if readable(turns) and not bool(torch.isfinite(turns).all()):
        raise SettingsError("The order holds NaN or infinity, expected finite quarter turns.")
    return turns.to(device)


def full_precision(device: torch.device) -> AbstractContextManager[object]:
    """Turn autocast off: in bfloat16 the transform would be wrong in its third digit."""
    kind = device.type
    if torch.amp.is_autocast_available(kind) and torch.is_autocast_enabled(kind):
        return torch.autocast(kind, enabled=False)
    return nullcontext()
