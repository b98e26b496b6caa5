"""The transform under torch.func (vmap, jvp, grad), in forward mode, exported and compiled."""

import warnings

import pytest
import torch
from torch.func import jacfwd, jacrev, vmap

from omnivat.fractional import FractionalTransform, dfrft
from omnivat.fractional.build import _built

# torch 2.13 scripts its own rules the first time that forward mode is used, and warns of that.
pytestmark = pytest.mark.filterwarnings("ignore:`torch.jit.script:DeprecationWarning")


@pytest.fixture
def x():
    return torch.linspace(-1, 2, 5 * 16, dtype=torch.float64).reshape(5, 16).sin()


@pytest.fixture
def orders():
    return torch.linspace(0.1, 0.9, 5, dtype=torch.float64)


@pytest.mark.parametrize("planar", [False, True])
def test_vmap_over_vectors_orders_or_both_is_the_batched_transform(x, orders, planar):
    def transform(vector, order):
        return dfrft(vector, order, planar=planar)

    wanted = dfrft(x, orders, planar=planar)
    batch = 1 if planar else 0
    torch.testing.assert_close(vmap(transform, out_dims=batch)(x, orders), wanted)
    across = vmap(transform, (1, 0), out_dims=batch)(x.T.contiguous(), orders)
    torch.testing.assert_close(across, wanted)
    wanted = dfrft(x[0], orders[:, None].expand(5, 1), planar=planar)
    found = vmap(transform, (None, 0), out_dims=batch)(x[0], orders)
    torch.testing.assert_close(found, wanted.squeeze(batch + 1))
    torch.testing.assert_close(
        vmap(transform, (0, None), out_dims=batch)(x, 0.3), dfrft(x, 0.3, planar=planar)
    )


@pytest.mark.parametrize("order", [0.3, 1.0])
@pytest.mark.parametrize("argument", [0, 1])
def test_forward_and_reverse_derivatives_agree_once_and_twice(x, order, argument):
    at = x[0], torch.tensor(order, dtype=torch.float64)
    _built.cache_clear()  # what is built under a transform serves later ones, too

    def cubes(vector, p):
        return dfrft(vector, p, planar=True)[0].pow(3)

    def loss(vector, p):
        return cubes(vector, p).sum()

    torch.testing.assert_close(*(way(cubes, argument)(*at) for way in (jacfwd, jacrev)))
    twice = [
        outer(inner(loss, argument), argument)(*at)
        for outer in (jacfwd, jacrev)
        for inner in (jacfwd, jacrev)
    ]
    wanted = torch.autograd.functional.hessian(loss, at)[argument][argument]
    for second in twice:
        torch.testing.assert_close(second, wanted)


class _Real(torch.nn.Module):
    def forward(self, x):
        return dfrft(x, 0.3).real


@pytest.mark.slow
def test_an_exported_program_transforms_other_vectors_too(x):
    """Exported first of all, too: tensors of the tracing do not stay in the cache."""
    _built.cache_clear()
    program = torch.export.export(_Real(), (x,), strict=False)
    torch.testing.assert_close(program.module()(2 * x), dfrft(2 * x, 0.3).real)


class _Layer(torch.nn.Module):
    def __init__(self):
        super().__init__()
        self.turn = FractionalTransform(0.3)

    def forward(self, x):
        return self.turn(x).abs()


@pytest.mark.slow
@pytest.mark.parametrize("wants_gradient", [True, False])
def test_an_exported_layer_keeps_its_learned_order_and_its_gradient(x, wants_gradient):
    layer = _Layer()
    with torch.set_grad_enabled(wants_gradient):
        program = torch.export.export(layer, (x,), strict=False).module()
    (order,) = program.parameters()
    with torch.no_grad():
        order.fill_(0.8)
        layer.turn.order.fill_(0.8)
    torch.testing.assert_close(program(2 * x), layer(2 * x))
    for one in (program, layer):
        one(x).pow(4).sum().backward()
    torch.testing.assert_close(order.grad, layer.turn.order.grad)


@pytest.mark.slow
def test_a_compiled_layer_learns_its_order(x):
    layer = _Layer()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        found = torch.compile(layer, backend="eager")(x)
    torch.testing.assert_close(found, layer(x))
    (slope,) = torch.autograd.grad(found.pow(4).sum(), layer.turn.order)
    (wanted,) = torch.autograd.grad(layer(x).pow(4).sum(), layer.turn.order)
    torch.testing.assert_close(slope, wanted)
