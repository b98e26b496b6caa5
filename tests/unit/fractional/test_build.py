"""Splits of the eigenbasis, which are kept between calls."""

import threading

import pytest
import torch

from omnivat.fractional import build, dfrft
from omnivat.fractional.build import build_split


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
