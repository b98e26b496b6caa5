"""The transform of the few rows of a training batch, with its gradient.

For so few rows, calls cost more than products, so the full matrix V beats V in blocks.
"""

from functools import lru_cache
from typing import NamedTuple

import torch
from torch import Tensor

from omnivat.fractional import Basis, basis
from omnivat.fractional.phases import phases


class Turn(NamedTuple):
    """A transform of order p, prepared for training."""

    vectors: Tensor  # V (D, D)
    slope: Tensor  # π k / 2 of every column (D,), float64
    planes: Tensor  # (O, R, 2, D) Re and Im of exp(-iπpk/2) for orders (O, R), see `turn_of`


class Turned(NamedTuple):
    """Channels, and what the backward pass needs."""

    channels: Tensor  # (M, B, C, D): Re and Im, or Re alone
    inner: Tensor  # (M, B, 1, D) in the eigenbasis


class TurnedBack(NamedTuple):
    """Gradients of a transform."""

    embedding: Tensor  # (M, B, D)
    order: Tensor  # (O, R) float64


@lru_cache(maxsize=8)
def _eigenbasis(width: int, dtype: torch.dtype, device: torch.device) -> Basis:
    with torch.inference_mode(False):
        return basis(width, dtype=dtype, device=device)


def turn_of(order: Tensor, like: Tensor) -> Turn:
    """Prepare the transform for embeddings like (..., D).

    order  () for all, (M, 1) for each modality, or (1, B) for each row
    """
    vectors, indices = _eigenbasis(like.shape[-1], like.dtype, like.device)
    orders = order.detach().reshape(order.shape or (1, 1))  # (O, R)
    planes = torch.view_as_real(phases(orders.reshape(-1), indices)).unflatten(0, orders.shape)
    planes = planes.movedim(-1, 2).to(like.dtype, memory_format=torch.contiguous_format)
    return Turn(vectors, indices * (torch.pi / 2), planes)


def turned(embedding: Tensor, turn: Turn, channels: int) -> Turned:
    """Transform embeddings (M, B, D) into their first one or two channels."""
    inner = (embedding @ turn.vectors)[:, :, None]
    return Turned((inner * turn.planes[:, :, :channels]) @ turn.vectors.T, inner)


def turned_back(grad: Tensor, inner: Tensor, turn: Turn) -> TurnedBack:
    """Return the gradients, given the gradient (M, B, C, D) of the channels.

    With θ = πpk/2 the planes are cos θ and -sin θ. The derivative of each is the other plane, up to
    sign.
    """
    count = grad.shape[2]
    within = grad @ turn.vectors
    orders, rows = turn.planes.shape[:2]
    to_planes = (within * inner).sum_to_size(orders, rows, count, within.shape[-1])
    real, imaginary = turn.planes.unbind(2)
    by_order = to_planes[:, :, 0] * imaginary
    if count == 2:
        by_order = by_order - to_planes[:, :, 1] * real
    embedding = (within * turn.planes[:, :, :count]).sum(2) @ turn.vectors.T
    return TurnedBack(embedding, by_order.double() @ turn.slope)
