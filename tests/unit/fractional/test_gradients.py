"""Gradients in x and in the order, once and twice, against finite differences and closed forms."""

import pytest
import torch
from torch.autograd import gradcheck, gradgradcheck

from omnivat.fractional import FractionalTransform, basis, dfrft

ORDERS = {
    "between": torch.tensor(0.37, dtype=torch.float64),
    "whole": torch.tensor(1.0, dtype=torch.float64),
    "zero": torch.tensor(0.0, dtype=torch.float64),
    "a row": torch.tensor([0.5, 2.0], dtype=torch.float64),
    "many": torch.tensor([[0.1], [3.0], [-7.2]], dtype=torch.float64),
}


@pytest.mark.slow
@pytest.mark.parametrize("size", [1, 3, 4])
@pytest.mark.parametrize("kind", [torch.float64, torch.complex128])
@pytest.mark.parametrize("order", ORDERS)
def test_gradients_pass_finite_differences_twice(size, kind, order):
    x = torch.randn(2, size, dtype=kind, requires_grad=True)
    p = ORDERS[order].clone().requires_grad_()
    planar = size % 2 == 0
    assert gradcheck(lambda x, p: dfrft(x, p, planar=planar), (x, p))
    assert gradgradcheck(lambda x, p: dfrft(x, p, planar=planar), (x, p))


@pytest.mark.parametrize("size", [64, 511, 512])
@pytest.mark.parametrize("order", [0.3, 1.0, 1e6 + 0.37])
def test_both_gradients_are_exact_to_fifteen_digits(size, order):
    vectors, k = basis(size)
    x = torch.randn(40, size, dtype=torch.float64, requires_grad=True)
    p = torch.tensor(order, dtype=torch.float64, requires_grad=True)
    grad = torch.randn(40, size, dtype=torch.complex128)
    to_x, to_p = torch.autograd.grad(dfrft(x, p), (x, p), grad)
    with torch.no_grad():
        exact_x = dfrft(grad, -order).real
        step = dfrft(x, order) @ vectors.to(torch.complex128) * (-0.5j * torch.pi * k)
        exact_p = (grad.conj() * (step @ vectors.T.to(torch.complex128))).real.sum()
        scale = step.norm() * grad.norm()
    assert (to_x - exact_x).norm() / grad.norm() < 4e-15
    assert (to_p - exact_p).abs() / scale < 4e-15


def test_a_layer_keeps_its_order_in_float64_and_learns():
    layer = FractionalTransform(0.3, centered=True)
    assert layer.half().order.dtype == torch.float64
    assert float(layer.order.detach()) == 0.3
    # Smooth vectors: for noise the loss has side minima about 4/N apart, and the order would stick.
    grid = (torch.arange(32, dtype=torch.float64) - 16) * (2 * torch.pi / 32) ** 0.5
    x = torch.exp(-0.5 * (grid - torch.tensor([[0.0], [1.0], [2.0]])) ** 2)
    wanted = dfrft(x, 0.4, centered=True)
    optimizer = torch.optim.Adam(layer.parameters(), lr=0.01)
    for _ in range(120):
        optimizer.zero_grad()
        (layer(x) - wanted).abs().pow(2).sum().backward()
        optimizer.step()
    assert abs(float(layer.order.detach()) - 0.4) < 1e-3
    assert "order=0.4" in repr(layer)


def test_a_fixed_layer_has_no_parameters_and_keeps_its_order_in_its_state():
    layer = FractionalTransform(1.25, learnable=False, planar=True)
    assert list(layer.parameters()) == []
    other = FractionalTransform(0.0, learnable=False, planar=True)
    other.load_state_dict(layer.state_dict())
    x = torch.randn(2, 8)
    assert torch.equal(other(x), dfrft(x, 1.25, planar=True))
