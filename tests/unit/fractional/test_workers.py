"""Parallel pieces: the same bits as in sequence, and no thread left waiting."""

import os
import sys
import threading
import warnings

import pytest
import torch

from omnivat.fractional import coefficients, dfrft, synthesise
from omnivat.fractional.build import build_split
from omnivat.fractional.workers import for_each, side_by_side

pytestmark = pytest.mark.usefixtures("two_threads")


def both_ways(call):
    found = []
    for count in (1, 2):
        torch.set_num_threads(count)
        result = call()
        found.append(result if isinstance(result, tuple) else (result,))
    return found


ORDERS = {
    "one": torch.tensor(0.3),
    "a row": torch.linspace(-2, 2, 1500),
    "many": torch.tensor([[0.1], [1.7]]),
}


@pytest.mark.parametrize(("size", "kind"), [(256, torch.float32), (258, torch.complex64)])
@pytest.mark.parametrize("order", ORDERS)
def test_two_threads_give_the_bits_of_one(size, kind, order):
    x = torch.randn(1500, size, dtype=kind, requires_grad=True)
    p = ORDERS[order].double().requires_grad_()

    def call():
        y = dfrft(x, p)
        weight = torch.linspace(0, 1, y.numel(), dtype=torch.complex64).view(y.shape)
        return (y.detach(), *torch.autograd.grad(y, (x, p), weight))

    one, two = both_ways(call)
    assert all(torch.equal(a, b) for a, b in zip(one, two, strict=True))


@pytest.mark.parametrize("size", [258])
def test_a_basis_built_by_two_threads_has_the_bits_of_one(size):
    def call():
        out = torch.empty(size, size, dtype=torch.float64)
        split = build_split(size, torch.empty(0, dtype=torch.float64))
        torch.set_num_threads(1)  # compare the builds, not the products that follow
        split.analyse(torch.eye(size, dtype=torch.float64), out)
        return out

    (one,), (two,) = both_ways(call)
    assert torch.equal(one, two)


def test_workers_are_used_and_have_one_thread_of_torch_each():
    seen = set()
    meet = threading.Barrier(2)

    def work(_):
        meet.wait(120)  # both parts at once, or never
        seen.add((threading.current_thread().name, torch.get_num_threads()))

    for_each(work, range(2), spread=True)
    assert len(seen) == 2
    assert {count for _, count in seen} == {1}
    assert torch.get_num_threads() == 2


def test_one_thread_of_torch_means_no_workers():
    torch.set_num_threads(1)
    names = side_by_side([lambda: threading.current_thread().name] * 2)
    assert set(names) == {threading.current_thread().name}


def test_a_failing_part_is_heard_of():
    def work(part):
        if part == 3:
            raise ArithmeticError("part three")

    with pytest.raises(ArithmeticError, match="part three"):
        for_each(work, range(9), spread=True)


def test_large_batches_work_in_inference_mode():
    x = torch.randn(1500, 256)
    with torch.inference_mode():
        inside = synthesise(coefficients(x), 0.3)
    assert torch.equal(inside, synthesise(coefficients(x), 0.3))


def test_functional_gradients_of_large_batches_are_those_of_backward():
    x, p = torch.randn(1500, 256, dtype=torch.float64), torch.tensor(0.3, dtype=torch.float64)

    def loss(x, p):
        return dfrft(x, p).real.pow(2).sum()

    given = x.clone().requires_grad_(), p.clone().requires_grad_()
    wanted = torch.autograd.grad(loss(*given), given)
    found = torch.func.grad(loss, argnums=(0, 1))(x, p)
    assert all(torch.allclose(a, b, rtol=1e-12) for a, b in zip(found, wanted, strict=True))
    only_x = torch.func.grad(loss)(x, p)  # p is plain inside, x is wrapped
    assert torch.allclose(only_x, wanted[0], rtol=1e-12)


@pytest.mark.skipif(sys.platform != "linux", reason="forks")
def test_a_forked_child_has_workers_of_its_own():
    wanted = side_by_side([lambda: 1, lambda: 2])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # forking with threads, from 3.12 on
        child = os.fork()
    if not child:
        os._exit(0 if side_by_side([lambda: 1, lambda: 2]) == wanted else 1)
    assert os.waitpid(child, 0)[1] == 0
