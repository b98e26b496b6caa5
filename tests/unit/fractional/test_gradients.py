"""Gradients in x and in the order, once and twice, against finite differences and closed forms."""

import pytest
import torch
from torch.autograd import gradcheck, gradgradcheck

from omnivat.fractional import FractionalTransform, dfrft

ORDERS = {
    "one": torch.tensor(1.0, dtype=torch.float64),
    "a row": torch.tensor([0.5, 2.0], dtype=torch.float64),
    "many": torch.tensor([[3.0], [-7.2]], dtype=torch.float64),
}


@pytest.mark.parametrize(
    ("order", "size", "kind"),
    [
        *(("one", 3, torch.complex128), ("one", 4, torch.float64), ("a row", 3, torch.float64)),
        *(
            ("a row", 4, torch.complex128),
            ("many", 3, torch.complex128),
            ("many", 4, torch.float64),
        ),
    ],
)
def test_gradients_pass_finite_differences_twice(size, kind, order):
    x = torch.randn(2, size, dtype=kind, requires_grad=True)
    p = ORDERS[order].clone().requires_grad_()
    planar = size % 2 == 0
    assert gradcheck(lambda x, p: dfrft(x, p, planar=planar), (x, p))
    assert gradgradcheck(lambda x, p: dfrft(x, p, planar=planar), (x, p))


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
