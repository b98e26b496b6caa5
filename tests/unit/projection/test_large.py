"""Large sets: the same maps by blocks, samples that say so, estimates with intervals that hold."""

import torch

from omnivat.projection import pca, quality, torch_umap
from omnivat.projection.quality import recall, trustworthiness


def noise(*shape, seed=0):
    return torch.randn(*shape, generator=torch.Generator().manual_seed(seed))


def test_pca_by_blocks_is_pca_of_all_rows(monkeypatch):
    points = noise(500, 20) * torch.linspace(3, 1, 20)
    whole = pca.project(points)
    monkeypatch.setattr(pca, "BLOCK", 64)
    assert torch.allclose(pca.project(points), whole, atol=1e-4)


def test_quality_of_all_rows_equals_the_whole_measures_and_has_no_error():
    points, flat = noise(300, 12), noise(300, 2, seed=1)
    found = quality.quality(points, flat, k=10)
    assert abs(found.trustworthiness - trustworthiness(points, flat, k=10)) < 1e-6
    assert abs(found.recall - recall(points, flat, k=10)) < 1e-6
    assert (found.trustworthiness_error, found.recall_error, found.rows) == (0, 0, 300)


def test_quality_of_a_draw_has_an_interval_that_holds_the_truth_nineteen_times_in_twenty():
    points = noise(900, 12)
    flat = pca.project(points)
    truth, held = trustworthiness(points, flat, k=10), 0
    for seed in range(40):
        found = quality.quality(points, flat, k=10, rows=150, seed=seed)
        assert found.rows == 150
        held += abs(found.trustworthiness - truth) <= found.trustworthiness_error
    assert held >= 35


def test_umap_of_many_rows_lays_out_a_sample_and_places_the_rest_near_their_own(monkeypatch):
    group = torch.arange(4).repeat_interleave(100)
    points = 8 * noise(4, 10)[group] + noise(400, 10, seed=2)
    monkeypatch.setattr(torch_umap, "MOST_ROWS", 150)
    flat = torch_umap.project(points, seed=3)
    chosen = torch_umap.sample_of(400, 3)
    alone = torch_umap.project(points[chosen], seed=3)
    assert flat.shape == (400, 2)
    assert torch.equal(flat[chosen], alone)
    centres = torch.stack([flat[group == k].mean(0) for k in range(4)])
    assert bool((torch.cdist(flat, centres).argmin(1) == group).float().mean() > 0.95)


def test_the_same_seed_draws_the_same_sample_at_every_order():
    assert torch.equal(torch_umap.sample_of(20_000, 1), torch_umap.sample_of(20_000, 1))
    assert not torch.equal(torch_umap.sample_of(20_000, 1), torch_umap.sample_of(20_000, 2))
