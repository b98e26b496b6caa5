"""Heads with any unitary matrix in place of F_p: the controls of the study of the order."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any
from unittest.mock import patch

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from omnivat.fractional import Coefficients, basis, dfrft
from omnivat.head import head, reference

KINDS = ("order", "group", "unitary", "identity")


def matrix_of(kind: str, width: int, order: float, draw: int = 0) -> Tensor:
    """Return the unitary (D, D) complex128 of a kind.

    order     F_p
    group     exp(pA): the eigenvalues of F_p on a random orthogonal eigenbasis, one for each draw
    unitary   a random unitary (Haar), one for each draw; p has no effect
    identity  neither p nor the draw has an effect
    """
    random = np.random.default_rng([22, draw, width])
    if kind == "order":
        return dfrft(torch.eye(width, dtype=torch.float64), order).to(torch.complex128)
    if kind == "group":
        vectors = torch.from_numpy(_haar(random.standard_normal((width, width))))
        turns = torch.exp(-0.5j * torch.pi * order * basis(width).indices)
        return (vectors * turns) @ vectors.mT.to(torch.complex128)
    if kind == "unitary":
        normal = random.standard_normal((2, width, width))
        return torch.from_numpy(_haar(normal[0] + 1j * normal[1]))
    return torch.eye(width, dtype=torch.complex128)


def _haar(normal: NDArray[Any]) -> NDArray[Any]:
    """Return a random orthogonal or unitary matrix: QR with the phases of R's diagonal divided out.

    Source: Mezzadri, How to generate random matrices from the classical compact groups, 2007.
    """
    q, r = np.linalg.qr(normal)
    diagonal = np.diagonal(r)
    found: NDArray[Any] = q * (diagonal / np.abs(diagonal))
    return found


@contextmanager
def heads_with(matrix: Tensor) -> Iterator[None]:
    """Within, heads transform embeddings by `matrix` (D, D), in training and in prediction."""
    planes = torch.view_as_real(matrix.mT).movedim(-1, 0).float().contiguous()  # (2, D, D)

    def transform(embedding: Tensor, order: Tensor) -> Tensor:
        return embedding @ planes.to(embedding)[:, None]

    def synthesise(kept: Coefficients, order: object, *, planar: bool) -> Tensor:
        return kept.values @ planes.to(kept.values)[:, None]

    training = patch.object(reference, "transform", transform)
    with training, patch.multiple(head, coefficients=Coefficients, synthesise=synthesise):
        yield
