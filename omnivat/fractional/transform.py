"""The transform: `dfrft`, its two halves `coefficients` and `synthesise`, its layer, and its
basis.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any, NamedTuple

import torch
from jaxtyping import Complex, Float, Float64, Inexact, Shaped
from torch import Tensor, nn

from omnivat.fractional import gradients
from omnivat.fractional.arguments import axis_from_end, checked_order, full_precision, readable
from omnivat.fractional.batches import product_rows
from omnivat.fractional.build import split_for
from omnivat.fractional.coefficients import Coefficients
from omnivat.kit.config import is_count
from omnivat.kit.errors import DataError, ShapeError
from omnivat.kit.shapes import tensor_of


def coefficients(
    x: Shaped[Tensor, "..."] | Any, dim: int = -1, *, centered: bool = False
) -> Coefficients:
    """Return the part of the transform that does not depend on the order: x in the eigenbasis.

    x: a tensor or array of any shape, real or complex. float64 stays float64; half and integers use
    float32.
    dim: the axis of length N that is transformed.
    centered: the origin is sample N//2 instead of sample 0, in input and output.

    Raises ShapeError if the axis is missing or empty, DataError if x holds no numbers.

    >>> x = torch.randn(3, 64)
    >>> kept = coefficients(x)  # once; then each order is one product
    >>> all(torch.allclose(synthesise(kept, p), dfrft(x, p), atol=1e-5) for p in (0.2, 0.35, 0.5))
    True
    """
    x = tensor_of("x", x)
    dim = axis_from_end(x, dim)
    if centered:
        x = torch.fft.ifftshift(x, dim)
    x = x.movedim(dim, -1)
    with full_precision(x.device):
        return Coefficients(gradients.apply(x, split_for(x)), dim, centered)


def synthesise(
    coefficients: Coefficients, order: float | Shaped[Tensor, "..."], *, planar: bool = False
) -> Inexact[Tensor, "..."]:
    """Return the transform of order `order` from coefficients.

    order: a number, or a tensor that broadcasts against the leading axes: (B,) is one order for
    each row of (B, N); (P, 1) gives P transforms of all rows, (P, B, N). In quarter turns, period
    4. planar: stack real and imaginary part, real (2, ..., N), instead of complex (..., N).

    Raises SettingsError for NaN or infinite orders, ShapeError if the axes do not fit, DataError
    for anything but coefficients and for a sparse, nested or quantised order.

    >>> x, orders = torch.randn(3, 64), torch.linspace(0, 1, 11)
    >>> tuple(synthesise(coefficients(x), orders[:, None]).shape)  # all orders of all rows
    (11, 3, 64)
    """
    if not isinstance(coefficients, Coefficients):
        raise DataError(
            f"{type(coefficients).__name__} was given; give coefficients(x), or call dfrft(x, p)."
        )
    values, dim = coefficients.values, coefficients.dim
    p = checked_order(order, values.device)
    lead = values.shape[:-1]  # of the result
    if p.dim() and p.shape != lead[-p.dim() :]:  # broadcast_shapes is written in Python and slow
        try:
            lead = torch.broadcast_shapes(lead, p.shape)
        except RuntimeError as error:
            raise ShapeError(
                f"The order has shape {tuple(p.shape)}, expected one that broadcasts against the"
                f" leading axes {tuple(lead)}: use order[:, None] for many orders of all rows."
            ) from error
    with full_precision(values.device):
        result = gradients.synthesise(values, p, lead, split_for(values), planar)
    result = result.movedim(-1, dim)
    return torch.fft.fftshift(result, dim) if coefficients.centered else result


def dfrft(
    x: Shaped[Tensor, "..."] | Any,
    order: float | Shaped[Tensor, "..."],
    dim: int = -1,
    *,
    centered: bool = False,
    planar: bool = False,
) -> Inexact[Tensor, "..."]:
    """Return the discrete fractional Fourier transform of x along dim; order 1 is the unitary DFT.

    F_p = V diag(exp(-iπpk/2)) Vᵀ with the Hermite-like eigenvectors V of the DFT, k = 0 … N-2 and N
    for even N, 0 … N-1 for odd N. Arguments as in `coefficients` and `synthesise`. The result is
    complex and has the shape of x, plus the axes that a tensor of orders adds.

    Unitary, additive in the order, differentiable in x and in the order any number of times. Orders
    0, 1, 2, 3 (mod 4) use the identity, the FFT, the reversal and the inverse FFT if no gradient is
    needed (the FFT only if no prime factor of N exceeds 13: beyond, libraries lose digits). For
    many orders of the same x, keep `coefficients(x)` and call `synthesise`.

    Source: Candan, Kutay, Ozaktas, "The discrete fractional Fourier transform", 2000.

    A unit impulse: order 0 leaves it, order 1 is the unitary FFT, order 2 reverses time.

    >>> impulse = torch.tensor([1.0, 0.0, 0.0, 0.0])
    >>> dfrft(impulse, 1).real
    tensor([0.5000, 0.5000, 0.5000, 0.5000])
    >>> dfrft(torch.arange(4.0), 2).real
    tensor([0., 3., 2., 1.])

    Orders add, and the length of a vector stays.

    >>> x = torch.randn(5, 64)
    >>> torch.allclose(dfrft(dfrft(x, 0.3), 0.7), dfrft(x, 1), atol=1e-5)
    True
    >>> torch.allclose(dfrft(x, 0.35).norm(dim=1), x.norm(dim=1))
    True

    One order for each row, many orders of all rows, another axis, real and imaginary part as two.

    >>> p = torch.linspace(0, 1, 5)
    >>> tuple(dfrft(x, p).shape), tuple(dfrft(x, p[:, None]).shape)
    ((5, 64), (5, 5, 64))
    >>> tuple(dfrft(x, 0.35, dim=0).shape), tuple(dfrft(x, 0.35, planar=True).shape)
    ((5, 64), (2, 5, 64))

    The order can be learned: the result has a gradient by p.

    >>> p = torch.tensor(0.35, requires_grad=True)
    >>> dfrft(x, p).real.relu().sum().backward()
    >>> p.grad.isfinite().item()
    True
    """
    x = tensor_of("x", x)
    wants_gradient = torch.is_grad_enabled() and (
        x.requires_grad or (isinstance(order, Tensor) and order.requires_grad)
    )
    dim = axis_from_end(x, dim)
    turns = None if wants_gradient else whole_turns(order)
    by_fft = turns in (1, 3)
    if turns is None or (by_fft and not fft_is_exact(x.shape[dim])):
        return synthesise(coefficients(x, dim, centered=centered), order, planar=planar)
    result = quarter_turn(x, turns, dim, centered=centered)
    return torch.stack([result.real, result.imag]) if planar else result


def whole_turns(order: float | Shaped[Tensor, "..."]) -> int | None:
    """Return 0, 1, 2 or 3 if the order is a single whole number (mod 4), else None.

    An order that cannot be read (`arguments.readable`) gives None.
    """
    if isinstance(order, Tensor):
        if order.dim() or order.is_complex() or not readable(order):
            return None
        order = order.item()
    if isinstance(order, float) and order.is_integer():
        order = int(order)
    return order % 4 if isinstance(order, int) else None


@functools.cache
def fft_is_exact(size: int) -> bool:
    """True if the library's FFT of that length is accurate on every processor.

    That requires that no prime factor exceeds 13. For larger ones, MKL loses up to two digits in
    float64 on processors with AVX-512 (1.8e-14 at N = 511 = 7 · 73); the eigenbasis is used then.
    """
    for prime in (2, 3, 5, 7, 11, 13):
        while size % prime == 0:
            size //= prime
    return size == 1


def quarter_turn(
    x: Inexact[Tensor, "*any"], turns: int, dim: int, *, centered: bool
) -> Complex[Tensor, "*any"]:
    """Return the transform of order `turns` along dim as a new complex tensor."""
    x = torch.fft.ifftshift(x, dim) if centered else x
    if turns == 0 or not x.numel():  # MKL refuses a batch of no vectors
        result = x.to(x.dtype.to_complex(), copy=True)
    elif turns == 2:
        result = x.flip(dim).roll(1, dim).to(x.dtype.to_complex())
    else:
        transform = torch.fft.fft if turns == 1 else torch.fft.ifft
        # the inverse of real input is a lazy conjugate, which has no `.numpy()`
        result = transform(x, dim=dim, norm="ortho").resolve_conj()
    return torch.fft.fftshift(result, dim) if centered else result


class FractionalTransform(nn.Module):
    """`dfrft` with a learnable order.

    order: initial value, in quarter turns. For real input, the gradient of a modulus or a real part
    is exactly zero at 0 and 2, so do not start there. The order stays float64 when the layer is
    cast, because rounding it to float32 changes the result by 1e-5. learnable: True makes the
    order a parameter, False a buffer. dim, centered, planar: as in `dfrft`.

    >>> layer = FractionalTransform(0.3)
    >>> layer(torch.randn(5, 64)).real.relu().sum().backward()  # its order learns like any weight
    >>> layer, layer.order.grad.isfinite().item()
    (FractionalTransform(order=0.3, dim=-1, centered=False), True)
    """

    order: Float64[Tensor, ""]

    def __init__(
        self,
        order: float,
        *,
        learnable: bool = True,
        dim: int = -1,
        centered: bool = False,
        planar: bool = False,
    ) -> None:
        super().__init__()
        start = checked_order(order, torch.device("cpu"))
        if learnable:
            self.order = nn.Parameter(start)
        else:
            self.register_buffer("order", start)
        self.dim, self.centered, self.planar = dim, centered, planar

    def forward(self, x: Shaped[Tensor, "..."]) -> Inexact[Tensor, "..."]:
        """Transform x along `dim`; complex, or (2, ...) if `planar`."""
        return dfrft(x, self.order, self.dim, centered=self.centered, planar=self.planar)

    def extra_repr(self) -> str:
        return f"order={self.order.item():.6g}, dim={self.dim}, centered={self.centered}"

    def _apply(self, fn: Callable[[Tensor], Tensor], recurse: bool = True) -> FractionalTransform:
        """Move to another device, but keep the precision."""
        exact = self.order.detach().clone()
        super()._apply(fn, recurse)  # type: ignore[no-untyped-call]
        if self.order.dtype != torch.float64:
            self.order.data = exact.to(self.order.device)
            if self.order.grad is not None:
                self.order.grad.data = self.order.grad.double()
        return self


class Basis(NamedTuple):
    """Eigenvectors of the DFT; column c has the eigenvalue exp(-iπk/2), k = indices[c]."""

    vectors: Float[Tensor, "N N"]
    indices: Float64[Tensor, " N"]


def basis(
    size: int, *, dtype: torch.dtype = torch.float64, device: torch.device | str = "cpu"
) -> Basis:
    """Return the Hermite-like eigenvectors of the DFT of length N, ordered by sign changes k.

    k = 0 … N-2 and N for even N, 0 … N-1 for odd N. The sign of each vector is arbitrary.
    The transform of order p is vectors · diag(exp(-iπp·indices/2)) · vectorsᵀ.

    Raises ShapeError if the size is no whole number from 1, or the dtype not float32 or float64.

    >>> vectors, indices = basis(8)
    >>> indices.tolist()
    [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0]
    >>> x = torch.randn(8, dtype=torch.float64)
    >>> phases = torch.exp(-0.5j * torch.pi * 0.3 * indices)
    >>> torch.allclose((vectors * phases * (x @ vectors)).sum(-1), dfrft(x, 0.3))
    True
    """
    if not is_count(size, 1) or dtype not in (torch.float32, torch.float64):
        raise ShapeError(
            f"A basis of size {size!r:.40} in {dtype} was requested, expected a whole number "
            "from 1 in torch.float32 or torch.float64."
        )
    identity = torch.eye(size, dtype=dtype, device=device)
    split = split_for(identity)
    rows = product_rows(split, identity, back=True)
    indices, order = split.indices.sort()
    return Basis(rows[order].T.contiguous(), indices)
