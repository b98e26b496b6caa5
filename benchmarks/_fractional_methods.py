"""Implementations of a fractional transform, ours and others', with one interface."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import torch
from torch import Tensor

from omnivat.fractional import basis, coefficients, dfrft, synthesise
from omnivat.fractional.build import build_split
from omnivat.kit.tables import need

Transform = Callable[[Tensor, float | Tensor], Tensor]


@dataclass(frozen=True)
class Method:
    """One implementation.

    build: N -> a new precomputation, independent of x and the order. transform: (x, order) -> F_p
    x, complex or planar. keep: x -> (order -> F_p x), with everything cached that does not depend
    on p.
    """

    transform: Transform
    keep: Callable[[Tensor], Callable[[float], Tensor]]
    build: Callable[[int], object] | None = None
    dtype: torch.dtype = torch.float32
    device: str = "cpu"
    differentiable: bool = True
    slow: bool = False
    continuous: bool = False  # it samples the continuous transform, which is another transform


def _keep_nothing(transform: Transform) -> Callable[[Tensor], Callable[[float], Tensor]]:
    return lambda x: lambda order: transform(x, order)


def _ours(planar: bool, dtype: torch.dtype) -> Method:
    def keep(x: Tensor) -> Callable[[float], Tensor]:
        kept = coefficients(x)
        return lambda order: synthesise(kept, order, planar=planar)

    return Method(
        lambda x, order: dfrft(x, order, planar=planar),
        keep,
        lambda size: build_split(size, torch.empty(0, dtype=dtype)),
        dtype,
    )


def _on_cuda() -> Method:
    """Return a call on vectors that stay on the accelerator; it ends when its work is done."""

    def finished(y: Tensor) -> Tensor:
        torch.cuda.synchronize()
        return y

    def keep(x: Tensor) -> Callable[[float], Tensor]:
        kept = coefficients(x)
        return lambda order: finished(synthesise(kept, order, planar=True))

    return Method(
        lambda x, order: finished(dfrft(x, order, planar=True)),
        keep,
        lambda size: finished(build_split(size, torch.empty(0, device="cuda")).indices),
        device="cuda",
    )


def _dense() -> Method:
    def keep(x: Tensor) -> Callable[[float], Tensor]:
        vectors, indices = basis(x.shape[-1])
        v = vectors.float()
        kept = x @ v

        def frame(order: float) -> Tensor:
            angle = indices * (-math.pi / 2 * order)
            phase = torch.stack([angle.cos(), angle.sin()]).float()
            return (kept * phase[:, None]) @ v.T

        return frame

    return Method(lambda x, order: keep(x)(float(order)), keep, differentiable=False)


def _torch_frft() -> dict[str, Method]:
    module = need("torch_frft.dfrft_module", purpose="the comparison with torch-frft")
    chirp = need("torch_frft.frft_module", purpose="the comparison with torch-frft")

    def cached(x: Tensor) -> Callable[[float], Tensor]:
        v = module._get_dfrft_evecs(x.shape[-1]).type(torch.complex64)
        indices = module._dfrft_index(x.shape[-1])

        def frame(order: float) -> Tensor:
            values = torch.exp(-1j * order * (torch.pi / 2) * indices).type(torch.complex64)
            matrix = torch.einsum("ij,j,kj->ik", v, values, v)
            return torch.einsum("ab,...b->...a", matrix, x.type(torch.complex64))

        return frame

    return {
        "torch-frft dfrft": Method(
            module.dfrft, _keep_nothing(module.dfrft), module._get_dfrft_evecs
        ),
        "torch-frft dfrft, eigenvectors kept": Method(
            module.dfrft, cached, differentiable=False, slow=True
        ),
        "torch-frft frft (chirp)": Method(
            chirp.frft, _keep_nothing(chirp.frft), slow=True, continuous=True
        ),
    }


def _torch_frft2d() -> dict[str, Method]:
    """Return the algorithm of torch-frft2d, which turns two axes, on one axis, made of its own
    parts in their order.
    """
    parts = need("torch_frft2d._frft2d", purpose="the comparison with torch-frft2d")

    def transform(x: Tensor, order: float | Tensor) -> Tensor:
        field = x.to(x.dtype.to_complex())
        turned = parts._cdft(field, -1)
        orders = torch.as_tensor(order, dtype=x.dtype).reshape(-1)
        orders = torch.remainder(orders + 2, 4) - 2
        far = (orders.abs() < 0.5) | (orders.abs() > 1.5)  # from the spectrum, an order less
        near = torch.where(far, torch.remainder(orders + 1, 4) - 2, orders)
        into, low, high, out, scale = parts._axis_terms(x.shape[-1], near[None], field.dtype)
        doubled = (parts._interp2x_last(values)[None] for values in (turned, field))
        source = torch.where(far[:, None, None], *doubled)
        found = parts._chirp_conv_last(source, *(term[0][:, None] for term in (into, low, high)))
        found = found * (out[0] * scale[0][:, None])[:, None]
        result: Tensor = found if torch.is_tensor(order) and order.dim() else found[0]
        return result

    chirp = Method(transform, _keep_nothing(transform), slow=True, continuous=True)
    return {"torch-frft2d, on one axis (chirp)": chirp}


def methods() -> dict[str, Method]:
    """Return all installed methods, ours first."""
    found = {
        "omnivat float32": _ours(False, torch.float32),
        "omnivat float32, planar": _ours(True, torch.float32),
        "omnivat float64": _ours(False, torch.float64),
        "dense V, two real products": _dense(),
    }
    if torch.cuda.is_available():
        found["omnivat float32, planar, CUDA"] = _on_cuda()
    for others in (_torch_frft, _torch_frft2d):
        try:
            found |= others()
        except ImportError:
            continue
    return found
