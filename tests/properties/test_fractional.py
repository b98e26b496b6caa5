"""Laws of the fractional transform, over lengths, orders and precisions."""

import torch
from hypothesis import given
from hypothesis import strategies as st

from omnivat.fractional import dfrft

SIZES = st.integers(1, 40) | st.sampled_from([63, 64, 65, 100, 128])
# Multiples of 2**-20: their sums are exact, so laws in the order hold to the last digits.
ORDERS = st.integers(-(2**22), 2**22).map(lambda n: n / 2**20) | st.integers(-(10**6), 10**6)
KINDS = st.sampled_from([torch.float32, torch.float64, torch.complex64, torch.complex128])
SEEDS = st.integers(0, 2**16)


def draw(seed, size, kind, rows=3):
    generator = torch.Generator().manual_seed(seed)
    return torch.randn(rows, size, dtype=kind, generator=generator)


def close(a, b, kind, scale):
    bound = 1.6e-14 if kind in (torch.float64, torch.complex128) else 3e-6
    return bool((a - b).norm() <= bound * scale.norm())


@given(SEEDS, SIZES, ORDERS, KINDS)
def test_length_is_kept(seed, size, order, kind):
    x = draw(seed, size, kind)
    y = dfrft(x, order)
    assert close(y.norm(dim=-1), x.norm(dim=-1), kind, x)
    assert close(dfrft(y, -order), x.to(y.dtype), kind, x)


@given(SEEDS, SIZES, ORDERS, ORDERS, KINDS)
def test_orders_add(seed, size, a, b, kind):
    x = draw(seed, size, kind)
    assert close(dfrft(dfrft(x, a), b), dfrft(x, a + b), kind, x)


@given(SEEDS, SIZES, ORDERS, KINDS)
def test_sums_go_to_sums(seed, size, order, kind):
    x, y = draw(seed, size, kind), draw(seed + 1, size, kind)
    assert close(dfrft(2 * x - y, order), 2 * dfrft(x, order) - dfrft(y, order), kind, x)


@given(SEEDS, SIZES, ORDERS, st.floats(1e-30, 1e30))
def test_scale_is_kept_from_tiny_to_huge(seed, size, order, by):
    x = draw(seed, size, torch.float64)
    assert close(dfrft(by * x, order) / by, dfrft(x, order), torch.float64, x)
