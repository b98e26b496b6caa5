"""Domains without their own means: laws of the centring, and the maps of it."""

from dataclasses import replace

import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st

from omnivat.data.store import load_embeddings
from omnivat.head.heads import EXAMPLES
from omnivat.maps.frames import read_frames, write_frames
from omnivat.maps.frames.centred import centred, centred_file, centred_reply, kept_reply, write_centred

from .small_head import pairs


@given(st.integers(0, 2**16))
def test_centred_domains_share_one_mean_and_keep_their_shape(seed):
    random = torch.Generator().manual_seed(seed)
    rows = torch.randn(30, 5, generator=random, dtype=torch.float64)
    domain = torch.randint(3, (30,), generator=random)
    moved = centred(rows, domain)
    for name in domain.unique():
        own = domain == name
        torch.testing.assert_close(moved[own].mean(0), rows.mean(0))
        torch.testing.assert_close(torch.cdist(moved[own], moved[own]), torch.cdist(rows[own], rows[own]))


def test_rows_of_one_domain_stay():
    rows = torch.randn(8, 4)
    torch.testing.assert_close(centred(rows, torch.zeros(8, dtype=torch.long)), rows)


@pytest.mark.parametrize("trust", [(), (0.9, None, 1.0)])
def test_the_trust_of_a_map_survives_the_file(tmp_path, trust, frames):
    name, first = next((n, m) for n, m in frames.maps.items() if len(m.orders) == 3 or not trust)
    made = replace(frames, maps={**frames.maps, name: replace(first, trust=trust)})
    write_frames(tmp_path / "x.bin", made)
    assert read_frames(tmp_path / "x.bin").maps[name].trust == trust


def test_a_file_next_to_the_embeddings_holds_their_maps_and_no_others(tmp_path):
    path, small = tmp_path / "set.safetensors", pairs()
    assert kept_reply(path, small, "pca") is None
    write_centred(path, small)
    assert kept_reply(path, small, "pca") == centred_reply(small, "pca")
    assert kept_reply(path, replace(small, tac=small.tac[::-1].copy()), "pca") is None
    centred_file(path).write_text("{")
    assert kept_reply(path, small, "pca") is None


def test_the_shipped_maps_belong_to_the_shipped_set():
    embeddings = load_embeddings(EXAMPLES / "simulated.safetensors")
    for method in ("pca", "umap"):
        found = kept_reply(EXAMPLES / "simulated.safetensors", embeddings, method)
        before, after = found["curves"]["domain_gap/raw"]
        assert after < 0.2 * before
        assert min(found["trust"]) > 0.6
