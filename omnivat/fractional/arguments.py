"""Check arguments: vectors, axes and orders."""

from __future__ import annotations

import math
from contextlib import AbstractContextManager, nullcontext
from typing import Any

import numpy as np
import torch
from jaxtyping import Float64, Inexact, Shaped
from torch import Tensor
from torch.autograd.forward_ad import unpack_dual

from omnivat.kit.errors import DataError, SettingsError, ShapeError, first_line

_KEPT = (torch.float32, torch.float64, torch.complex64, torch.complex128)


def tensor_of(x: Tensor | Any) -> Tensor:
    """Return a tensor as it is, and an array or list of numbers as one in single or double
    precision. Raises DataError for anything else.
    """
    if isinstance(x, Tensor):
        return x
    try:
        array = np.asarray(x)
    except ValueError as error:  # a list of lists of differing lengths
        raise DataError(f"x is no array of numbers ({first_line(error)}).") from error
    if array.dtype.kind not in "fcbiu":
        raise DataError(f"x holds values of type {array.dtype}; give a tensor or array of numbers.")
    kind, parts = ("c", 2) if array.dtype.kind == "c" else ("f", 1)
    wide = array.dtype.kind in "fc" and array.dtype.itemsize > 4 * parts
    return torch.from_numpy(array.astype(f"{kind}{(8 if wide else 4) * parts}"))


def working_precision(x: Shaped[Tensor, "..."]) -> Inexact[Tensor, "..."]:
    """Convert half precision, integers and booleans to single precision."""
    if x.dtype in _KEPT:
        return x
    return x.to(torch.complex64 if x.is_complex() else torch.float32)


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
            f"The order is {order!r}, expected a finite real number, or a tensor of them."
        ) from error
    if turns.is_complex():
        raise SettingsError(f"The order is complex ({turns.dtype}), expected real quarter turns.")
    if readable(turns) and not bool(torch.isfinite(turns).all()):
        raise SettingsError("The order holds NaN or infinity, expected finite quarter turns.")
    return turns.to(device=device, dtype=torch.float64)


def full_precision(device: torch.device) -> AbstractContextManager[object]:
    """Turn autocast off: in bfloat16 the transform would be wrong in its third digit."""
    kind = device.type
    if torch.amp.is_autocast_available(kind) and torch.is_autocast_enabled(kind):
        return torch.autocast(kind, enabled=False)
    return nullcontext()
