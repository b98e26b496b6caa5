"""The transform against independent computations."""

from pathlib import Path

import numpy as np
import pytest
import torch

from omnivat.fractional import basis, coefficients, dfrft, synthesise, transform
from tests.golden.make_fractional import ORDERS, transform_by_mpmath, vector

GOLDEN = Path(__file__).parents[2] / "golden"


@pytest.mark.parametrize("size", [1, 2, 3, 4, 7, 8, 14])
@pytest.mark.parametrize("order", [1000.3, -1.5])
def test_it_agrees_with_forty_digits(size, order):
    x = vector(size)
    wanted = np.array([complex(y) for y in transform_by_mpmath(x, order)])
    assert np.abs(dfrft(torch.from_numpy(x), order).numpy() - wanted).max() < 2e-15


@pytest.mark.parametrize("size", [63, 64, 513, 768, 1024])
@pytest.mark.parametrize(("dtype", "bound"), [(torch.float64, 4e-15), (torch.float32, 1.5e-6)])
def test_it_agrees_with_eighty_bits(size, dtype, bound):
    x = torch.from_numpy(vector(size))
    with np.load(GOLDEN / "fractional.npz") as arrays:
        wanted = torch.from_numpy(arrays[str(size)])
    for order, exact in zip(ORDERS, wanted, strict=True):
        for rows in (1, 40):  # few rows and many take different splits
            found = dfrft(x.to(dtype).expand(rows, size), order)[-1].to(torch.complex128)
            assert (found - exact).norm() / exact.norm() < bound, order


def test_a_displaced_gaussian_moves_on_a_circle():
    size, shift, order = 256, 3.0, 0.5
    grid = (np.arange(size) - size // 2) * np.sqrt(2 * np.pi / size)
    x = torch.from_numpy(np.exp(-((grid - shift) ** 2) / 2))
    found = dfrft(x, order, centered=True).abs().numpy()
    angle = order * np.pi / 2
    wanted = np.exp(-((grid - shift * np.cos(angle)) ** 2) / 2)
    assert np.abs(found - wanted).max() < 2e-2


@pytest.mark.parametrize("size", [7, 8, 12])
@pytest.mark.parametrize("centered", [False, True])
@pytest.mark.parametrize("order", [0, 1, 2.0, 3, -1, 401])
def test_whole_orders_are_the_same_on_both_paths(size, centered, order):
    x = torch.randn(3, size, dtype=torch.complex128)
    short = dfrft(x, order, centered=centered)
    assert (short - synthesise(coefficients(x, centered=centered), order)).abs().max() < 4e-15
    if order == 0:
        assert torch.equal(short, x)


def test_whole_orders_build_no_basis(monkeypatch):
    monkeypatch.setattr(transform, "split_for", None)
    assert dfrft(torch.ones(4, 10), 1).shape == (4, 10)
    with pytest.raises(TypeError):
        dfrft(torch.ones(4, 10), 1.5)


@pytest.mark.parametrize("size", [6, 8])
@pytest.mark.parametrize("kind", [torch.float64, torch.complex128])
def test_any_axis_gives_what_the_last_axis_gives(size, kind):
    x = torch.randn(2, size, 3, dtype=kind)
    moved = dfrft(x.movedim(1, -1), 0.3).movedim(-1, 1)
    assert torch.allclose(dfrft(x, 0.3, dim=1), moved, rtol=0, atol=1e-15)
    assert torch.allclose(dfrft(x, 0.3, dim=-2), moved, rtol=0, atol=1e-15)


@pytest.mark.parametrize("size", [9, 12, 64])
@pytest.mark.parametrize("count", [2, 20])
def test_orders_broadcast_against_the_leading_axes(size, count):
    x = torch.randn(count, size, dtype=torch.float64)
    kept = coefficients(x)
    orders = torch.linspace(-3, 5, 4, dtype=torch.float64)
    each = torch.stack([dfrft(x, p) for p in orders])
    assert torch.allclose(synthesise(kept, orders[:, None]), each, rtol=0, atol=4e-15)
    rows = torch.linspace(0.1, 2, count, dtype=torch.float64)
    by_row = torch.stack([dfrft(x[i], rows[i]) for i in range(count)])
    assert torch.allclose(dfrft(x, rows), by_row, rtol=0, atol=4e-15)
    assert synthesise(coefficients(x[0]), orders).shape == (4, size)


@pytest.mark.parametrize("kind", [torch.float32, torch.complex64])
def test_planar_is_complex_in_two_planes(kind):
    x = torch.randn(5, 16, dtype=kind)
    for order in (1, 0.4, torch.rand(5)):
        planar, whole = dfrft(x, order, planar=True), dfrft(x, order)
        assert torch.equal(planar, torch.stack([whole.real, whole.imag]))


@pytest.mark.filterwarnings("ignore:ComplexHalf support is experimental")
@pytest.mark.parametrize("order", [0.3, 1, 2.0])
@pytest.mark.parametrize(
    ("wanted", "kinds"),
    [
        (torch.float32, (torch.float16, torch.bfloat16, torch.int32, torch.bool, torch.float32)),
        (torch.complex64, (torch.complex32, torch.complex64)),
        (torch.float64, (torch.float64,)),
        (torch.complex128, (torch.complex128,)),
    ],
)
def test_a_precision_is_kept_and_a_lower_one_is_computed_in_single(order, wanted, kinds):
    for kind in kinds:
        x = torch.randn(3, 12, dtype=wanted).to(kind)
        found = dfrft(x, order)
        assert found.dtype == wanted.to_complex()
        assert torch.equal(found, dfrft(x.to(wanted), order))


def test_autocast_changes_nothing():
    x = torch.randn(40, 64)
    plain = dfrft(x, 0.3)
    with torch.autocast("cpu", dtype=torch.bfloat16):
        assert torch.equal(dfrft(x, 0.3), plain)


@pytest.mark.parametrize("shape", [(0, 12), (3, 0, 12), (0, 7)])
def test_an_empty_batch_stays_empty(shape):
    assert dfrft(torch.zeros(shape), 0.3).shape == shape


@pytest.mark.parametrize("rows", [4, 50])
@pytest.mark.parametrize("size", [9, 64])
@pytest.mark.parametrize("bad", [torch.nan, torch.inf])
def test_a_bad_number_stays_in_its_row(rows, size, bad):
    x = torch.randn(rows, size)
    clean = dfrft(x, 0.3)
    x[1, 2] = bad
    found = dfrft(x, 0.3)
    keep = torch.arange(rows) != 1
    assert torch.equal(found[keep], clean[keep])
    assert not torch.isfinite(found[1]).all()


def test_strided_input_gives_what_a_copy_gives_and_is_left_alone():
    base = torch.randn(24, 40, dtype=torch.float64)
    x = base[::2, ::2].T[:, 1:]
    before = x.clone()
    for order in (0.3, 2):
        assert torch.equal(dfrft(x, order), dfrft(x.contiguous(), order))
    assert torch.equal(x, before)


@pytest.mark.parametrize("size", [1, 2, 7, 12])
def test_the_basis_diagonalises_the_dft(size):
    vectors, indices = basis(size)
    found = (vectors * torch.exp(-0.5j * torch.pi * indices)) @ vectors.T.to(torch.complex128)
    assert np.abs(found.numpy() - np.fft.fft(np.eye(size), norm="ortho")).max() < 2e-15
    last = size if size % 2 == 0 else size - 1
    assert indices.tolist() == [*range(size - 1), last]


@pytest.mark.skipif(not torch.cuda.is_available(), reason="needs a CUDA device")
def test_an_accelerator_gives_what_the_cpu_gives():
    x = torch.randn(64, 512, dtype=torch.float64)
    order = torch.tensor(0.3, dtype=torch.float64)
    found = dfrft(x.cuda(), order.cuda()).cpu()
    assert torch.allclose(found, dfrft(x, order), rtol=0, atol=1e-13)


@pytest.mark.parametrize(("size", "exact"), [(1, True), (2002, True), (13, True), (34, False)])
def test_lengths_of_primes_up_to_thirteen_take_the_fft(size, exact):
    assert transform.fft_is_exact(size) is exact  # 2002 = 2 · 7 · 11 · 13
