"""Large sets: the same maps by blocks, samples that say so, estimates with intervals that hold."""

import pytest
import torch

from omnivat.maps.projection import pca, quality, torch_umap
from omnivat.maps.projection.neighbours import nearest, place

from .points import clusters, noise


def test_pca_by_blocks_is_pca_of_all_rows(monkeypatch):
    points = noise(500, 20) * torch.linspace(3, 1, 20)
    whole = pca.project(points)
    monkeypatch.setattr(pca, "BLOCK", 64)
    assert torch.allclose(pca.project(points), whole, atol=1e-4)


def test_recall_of_all_rows_is_the_share_of_near_rows_that_are_near_on_the_map():
    points, flat = noise(300, 12), noise(300, 2, seed=1)
    found = quality.quality(points, flat, k=10)
    truth, near = nearest(points, 10).index, nearest(flat, 10).index
    recall = float((truth[:, :, None] == near[:, None, :]).any(2).double().mean())
    assert abs(found.recall - recall) < 1e-6
    assert (found.trustworthiness_error, found.recall_error, found.rows) == (0, 0, 300)


def test_umap_of_many_rows_lays_out_a_sample_and_places_the_rest_near_their_own(monkeypatch):
    points, group = clusters(each=100, groups=4, width=10)
    monkeypatch.setattr(torch_umap, "MOST_ROWS", 150)
    flat = torch_umap.project(points, seed=3)
    chosen = torch_umap.sample_of(400, 3)
    alone = torch_umap.project(points[chosen], seed=3)
    assert flat.shape == (400, 2)
    assert torch.equal(flat[chosen], alone)
    centres = torch.stack([flat[group == k].mean(0) for k in range(4)])
    assert bool((torch.cdist(flat, centres).argmin(1) == group).float().mean() > 0.95)


@pytest.mark.parametrize("edge", [0, 1])
def test_rows_beyond_the_bound_are_placed_among_the_cells_next_to_their_own(monkeypatch, edge):
    points = noise(300, 3)
    chosen = torch.arange(0, 300, 2)
    flat = noise(150, 2, seed=1)
    whole = place(points, points[chosen], flat)
    whole[chosen] = flat
    monkeypatch.setattr(torch_umap, "CELLS_FROM", 300 - edge)
    monkeypatch.setattr(torch_umap, "CELLS", 10)
    monkeypatch.setattr(torch_umap, "RING", 10)
    # every cell is next to each
    torch.testing.assert_close(torch_umap._spread(points, chosen, flat), whole)
    monkeypatch.setattr(torch_umap, "RING", 3)
    near = torch_umap._spread(points, chosen, flat)
    same = (near - whole).norm(dim=1) < 1e-5
    assert bool(same.all()) if not edge else 0.2 < float(same.double().mean()) < 1


def test_the_error_of_a_draw_is_1_96_standard_errors():
    points, flat = noise(400, 6), noise(400, 2, seed=1)
    parts = [quality.quality(points, flat, k=5, rows=100, seed=seed) for seed in range(30)]
    spread = torch.tensor([one.trustworthiness for one in parts]).std()
    mean = torch.tensor([one.trustworthiness_error for one in parts]).mean()
    assert float(mean / spread) == pytest.approx(1.96 / (1 - 100 / 400) ** 0.5, rel=0.3)
