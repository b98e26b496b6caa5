"""Linear maps of transformed vectors, fused: turn the few directions instead of the many vectors."""

from __future__ import annotations

import torch
from torch import Tensor

from omnivat.fractional import gradients
from omnivat.fractional.arguments import (
    checked_order,
    full_precision,
    split_for,
    working_precision,
)
from omnivat.fractional.coefficients import Coefficients
from omnivat.fractional.phases import smooth_phases
from omnivat.shapes import require_shapes


def project(coefficients: Coefficients, order: float | Tensor, directions: Tensor) -> Tensor:
    """Sums Σ_n F_p(x)_n directions[d, n] for every vector, complex (..., D).

    order: as in `synthesise`. directions (D, N), real or complex, not conjugated: a real map a of
    the real part plus b of the imaginary part is the real part of the result for a - ib.

    F_p is symmetric, so the sum is Σ_k λ_k^p c_k (Vᵀ directions)_k: one product with (N, 2D)
    weights. A picture of 20,000 vectors costs a tenth of the transform. Differentiable in all three.
    """
    values = coefficients.values
    require_shapes(values=(values, "... N"), directions=(directions, "D N"))
    p = checked_order(order, values.device)
    directions = working_precision(directions).to(values.device)
    real, wide = values.dtype.to_real(), values.dtype.to_complex()
    directions = directions.to(wide if directions.is_complex() else real)
    if coefficients.centered:
        directions = torch.fft.ifftshift(directions, -1)
    split = split_for(values)
    with full_precision(values.device):
        turned = gradients.analyse(directions, split)
        one_row = p.dim() > 0 and p.shape[-1] == 1 and values.dim() > 1
        p = p[..., 0] if one_row else p
        weights = smooth_phases(p, split.indices).to(wide)[..., None, :] * turned
        if p.dim() and not one_row:
            return torch.einsum("...n,...dn->...d", values.to(wide), weights)
        if values.is_complex():
            return values @ weights.mT
        return torch.complex(values @ weights.real.mT, values @ weights.imag.mT)
