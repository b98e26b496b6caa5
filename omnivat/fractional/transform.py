"""The transform: `dfrft`, and its two halves `coefficients` and `synthesise`."""

from __future__ import annotations

import torch
from torch import Tensor

from omnivat.errors import ShapeError
from omnivat.fractional import gradients
from omnivat.fractional.arguments import axis_from_end, checked_order, full_precision, split_for, working_precision
from omnivat.fractional.batches import leading_shape, synthesise_rows
from omnivat.fractional.coefficients import Coefficients
from omnivat.fractional.whole_orders import fft_is_exact, quarter_turn, whole_turns


def coefficients(x: Tensor, dim: int = -1, *, centered: bool = False) -> Coefficients:
    """The part of the transform that does not depend on the order: x in the eigenbasis.

    x: any shape, real or complex. float64 stays float64; half and integers use float32.
    dim: the axis of length N that is transformed.
    centered: the origin is sample N//2 instead of sample 0, in input and output.

    Raises ShapeError if the axis is missing or empty.
    """
    dim = axis_from_end(x, dim)
    x = working_precision(x)
    if centered:
        x = torch.fft.ifftshift(x, dim)
    x = x.movedim(dim, -1)
    with full_precision(x.device):
        return Coefficients(gradients.analyse(x, split_for(x)), dim, centered)


def synthesise(
    coefficients: Coefficients, order: float | Tensor, *, planar: bool = False, out: Tensor | None = None
) -> Tensor:
    """Return the transform of order `order` from coefficients.

    order: a number, or a tensor that broadcasts against the leading axes: (B,) is one order for
    each row of (B, N); (P, 1) gives P transforms of all rows, (P, B, N). In quarter turns, period
    4. planar: stack real and imaginary part, real (2, ..., N), instead of complex (..., N). out: a
    contiguous tensor for the result, with its shape and dtype; outside autograd and for the last
    axis only. It avoids allocating a large tensor.

    Raises SettingsError for NaN or infinite orders, ShapeError if the axes do not fit.
    """
    values, dim = coefficients.values, coefficients.dim
    p = checked_order(order, values.device)
    split = split_for(values)
    try:
        lead = leading_shape(values, p)
    except RuntimeError as error:
        raise ShapeError(
            f"The order has shape {tuple(p.shape)}, expected one that broadcasts against the "
            f"leading axes {tuple(values.shape[:-1])}: use order[:, None] for many orders of all rows."
        ) from error
    with full_precision(values.device):
        if out is not None:
            _check_out(out, coefficients, (*lead, values.shape[-1]), planar)
            return synthesise_rows(split, values.detach(), p.detach(), planar=planar, out=out)
        result = gradients.synthesise(values, p, split, planar)
    result = result.movedim(-1, dim)
    return torch.fft.fftshift(result, dim) if coefficients.centered else result


def dfrft(x: Tensor, order: float | Tensor, dim: int = -1, *, centered: bool = False, planar: bool = False) -> Tensor:
    """Return the discrete fractional Fourier transform of x along dim; order 1 is the unitary DFT.

    F_p = V diag(exp(-iπpk/2)) Vᵀ with the Hermite-like eigenvectors V of the DFT, k = 0 … N-2 and N
    for even N, 0 … N-1 for odd N. Arguments as in `coefficients` and `synthesise`. The result is
    complex and has the shape of x, plus the axes that a tensor of orders adds.

    Unitary, additive in the order, differentiable in x and in the order any number of times. Orders
    0, 1, 2, 3 (mod 4) use the identity, the FFT, the reversal and the inverse FFT if no gradient is
    needed (the FFT only if no prime factor of N exceeds 13: beyond, libraries lose digits). For
    many orders of the same x, keep `coefficients(x)` and call `synthesise`.

    Source: Candan, Kutay, Ozaktas, "The discrete fractional Fourier transform", 2000.
    """
    wants_gradient = torch.is_grad_enabled() and (
        x.requires_grad or (isinstance(order, Tensor) and order.requires_grad)
    )
    dim = axis_from_end(x, dim)
    turns = None if wants_gradient else whole_turns(order)
    by_fft = turns in (1, 3)
    if turns is None or (by_fft and not fft_is_exact(x.shape[dim])):
        return synthesise(coefficients(x, dim, centered=centered), order, planar=planar)
    result = quarter_turn(working_precision(x), turns, dim, centered=centered)
    return torch.stack([result.real, result.imag]) if planar else result


def _check_out(out: Tensor, coefficients: Coefficients, shape: tuple[int, ...], planar: bool) -> None:
    kind = coefficients.values.dtype
    wanted = ((2, *shape), kind.to_real()) if planar else (shape, kind.to_complex())
    if coefficients.dim != -1 or coefficients.centered:
        raise ShapeError("`out` works only for the last axis without centring: do not pass it here.")
    if (tuple(out.shape), out.dtype) != wanted or not out.is_contiguous():
        raise ShapeError(
            f"out has shape {tuple(out.shape)} and {out.dtype}, expected contiguous {wanted[0]} and {wanted[1]}."
        )
