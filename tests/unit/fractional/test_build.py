"""Splits of the eigenbasis, which are kept between calls."""

import threading
from fractions import Fraction

import numpy as np
import pytest
import torch

from omnivat.fractional import build, dfrft
from omnivat.fractional.build import build_split
from omnivat.fractional.commuting import doubled_cosines, parity_blocks
from omnivat.fractional.double_double import SQRT2
from omnivat.fractional.eigenvectors import _to_small


@pytest.mark.parametrize("size", [1, 2, 3, 8, 14, 100])
def test_both_maps_of_a_split_are_one_orthogonal_matrix(size):
    split = build_split(size, torch.empty(0, dtype=torch.float64))
    for rows in (size, size + 40):  # few rows and many
        identity = torch.eye(rows, size, dtype=torch.float64)
        v, back = torch.empty_like(identity), torch.empty_like(identity)
        split.analyse(identity.clone(), v)
        split.restore(identity.clone(), back)
        v, back = v[:size], back[:size]
        assert (v - back.T).abs().max() < 1e-15
        assert (v.T @ v - torch.eye(size, dtype=torch.float64)).abs().max() < 1e-15


def test_a_split_is_built_once_however_many_threads_ask(monkeypatch):
    built, start = [], threading.Barrier(8)

    def counted(size, like):
        built.append(size)
        return build_split(size, like)

    monkeypatch.setattr(build, "build_split", counted)
    build._built.cache_clear()

    def ask():
        start.wait()
        dfrft(torch.ones(5), 0.3)

    threads = [threading.Thread(target=ask) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert built == [5]


def test_a_split_built_without_a_graph_can_be_used_with_one():
    build._built.cache_clear()
    with torch.inference_mode():
        dfrft(torch.ones(2, 20), 0.3)
    x = torch.ones(2, 20, requires_grad=True)
    (slope,) = torch.autograd.grad(dfrft(x, 0.3).abs().pow(4).sum(), x, create_graph=True)
    slope.sum().backward()


def test_cosines_are_known_beyond_float64():
    cosines = doubled_cosines(101)
    exact = 2 * np.cos(4 * np.arcsin(np.longdouble(1)) * np.arange(51).astype(np.longdouble) / 101)
    found = cosines.high.astype(np.longdouble) + cosines.low
    assert np.abs(found - exact).max() < 1e-18


def test_the_residual_of_the_large_side_is_exact_in_its_low_digits_too():
    """Only the last row gets √2 times the middle sample; all other digits stay."""
    block = parity_blocks(16)[1]
    large = np.random.default_rng(0).normal(size=(len(block) + 1, 3))
    plain, found = block.times(large[:-1]), _to_small(block, large)
    for part, whole in zip(plain, found, strict=True):
        np.testing.assert_array_equal(part[:-1], whole[:-1])
    root = Fraction(float(SQRT2.high)) + Fraction(float(SQRT2.low))
    for column in range(3):
        exact = sum(Fraction(float(part[-1, column])) for part in plain)
        exact += root * Fraction(float(large[-1, column]))
        two = sum(Fraction(float(part[-1, column])) for part in found)
        assert abs(float(two - exact)) < 1e-30
