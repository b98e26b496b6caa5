"""The transform with p as a tensor: with gradients in p, exact at even orders, and exportable.

No line looks at a value, so `torch.export` takes p as an input. A new p of many pairs is cheaper by
`omnivat.fractional.synthesise`.
"""

from functools import lru_cache

import torch
from jaxtyping import Float, Float64
from torch import Tensor
from torch.nn.functional import linear

from omnivat.fractional import Basis, basis


@lru_cache(maxsize=8)
def eigenbasis(width: int, dtype: torch.dtype, device: torch.device) -> Basis:
    """Return the eigenvectors V of the Fourier matrix, and the index k of each."""
    with torch.inference_mode(False):
        return basis(width, dtype=dtype, device=device)


def transform(
    embedding: Float[Tensor, "*any D"], order: Float64[Tensor, "..."]
) -> Float[Tensor, "2 *any D"]:
    """Return F_p(E) = V diag(exp(-iπpk/2)) Vᵀ E, as Re and Im. Eq. 2.

    order  broadcast against the leading axes of E; with gradients, once
    """
    vectors, k = eigenbasis(embedding.shape[-1], embedding.dtype, embedding.device)
    # (..., D) float64, quarter turns
    turns = torch.fmod(torch.fmod(order, 4.0)[..., None] * k, 4.0)
    whole = torch.round(turns)  # applied as 0 or ±1, so that even orders are exact
    angle, quarter = (turns - whole) * (torch.pi / 2), torch.remainder(whole.detach(), 4.0)
    step = (quarter - 2).abs() - 1, 1 - (quarter - 1).abs()  # cosine and sine of it
    cos = (angle.cos() * step[0] - angle.sin() * step[1]).to(embedding.dtype)
    sin = (angle.sin() * step[0] + angle.cos() * step[1]).to(embedding.dtype)
    inner = embedding @ vectors  # (..., D)
    return linear(torch.stack((inner * cos, inner * -sin)), vectors)  # (2, ..., D)
