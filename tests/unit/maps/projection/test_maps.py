"""Maps in two dimensions: exactness, faithfulness, reproducibility, unusual sets."""

import sys
from itertools import pairwise

import numpy as np
import pytest
import torch
from scipy.optimize import curve_fit

from omnivat.kit.errors import MissingPackageError, SettingsError, ShapeError
from omnivat.kit.tables import load
from omnivat.maps.projection import PROJECTIONS, pca, torch_umap, umap
from omnivat.maps.projection.neighbours import affine, nearest, place, placed_by
from omnivat.maps.projection.quality import quality
from omnivat.maps.projection.torch_umap import aligned, spectral_map

from .points import clusters, noise

SCHEMES = ["pca", "umap"]


def trustworthiness(points, flat, k=15):
    return quality(points, flat, k=k, rows=len(points)).trustworthiness


@pytest.mark.parametrize("shape", [(40, 7), (6, 30)])
def test_neighbours_are_those_of_the_full_distance_matrix(shape):
    points = noise(*shape, dtype=torch.float64) + 100
    full = torch.cdist(points, points)
    full.fill_diagonal_(torch.inf)
    found = nearest(points, 4)
    torch.testing.assert_close(found.distance, full.sort(1).values[:, :4], atol=1e-7, rtol=0)
    assert torch.equal(found.index, full.sort(1).indices[:, :4])


@pytest.mark.parametrize("shape", [(50, 6), (6, 50), (2, 3)])
def test_pca_is_the_singular_value_decomposition(shape):
    points = noise(*shape, dtype=torch.float64)
    flat = pca.project(points)
    u, s, _ = torch.linalg.svd(points - points.mean(0), full_matrices=False)
    torch.testing.assert_close(flat.abs(), (u * s)[:, :2].abs(), atol=1e-9, rtol=0)


@pytest.mark.parametrize("shape", [(50, 6), (6, 50)])
def test_the_largest_entry_of_each_pca_axis_is_positive(shape):
    for seed in range(8):  # the solver's own sign would be wrong in some of them
        axes = pca.basis(noise(*shape, seed=seed, dtype=torch.float64)).axes
        assert (axes.gather(0, axes.abs().argmax(0, keepdim=True)) > 0).all()
        torch.testing.assert_close(axes.T @ axes, torch.eye(2, dtype=torch.float64))


def test_the_spectral_start_finds_the_slow_directions_of_the_graph():
    """On a ring they are its two coordinates; the dense Laplacian says the same."""
    angle = torch.arange(40, dtype=torch.float64) * (2 * torch.pi / 40)
    ring = torch.stack([angle.cos(), angle.sin(), torch.zeros(40, dtype=torch.float64)], 1)
    graph = torch_umap.fuzzy_graph(nearest(ring, 16))
    flat = spectral_map(graph)
    assert flat.abs().max() == pytest.approx(10)
    inside = torch.linalg.lstsq(ring[:, :2], flat).solution
    assert (ring[:, :2] @ inside - flat).norm() < 0.05 * flat.norm()


def test_pca_wants_two_columns():
    with pytest.raises(ShapeError, match=r"\(3, 1\); a map needs 2 columns"):
        pca.project(torch.ones(3, 1))


@pytest.mark.parametrize("total", [3.9, 12.0])  # narrower and far wider than the mean
def test_fuzzy_weights_of_a_row_add_up_to_what_is_asked(total):
    found = nearest(noise(60, 5, dtype=torch.float64), 14)
    beyond = found.distance - found.distance[:, :1]
    weights = (-beyond / torch_umap._widths(beyond, total)).exp().sum(1)
    torch.testing.assert_close(weights, torch.full_like(weights, total), atol=1e-6, rtol=0)
    beyond[0] = 0  # neighbours at one distance: a thousandth of the mean
    torch.testing.assert_close(torch_umap._widths(5 * beyond, total)[0, 0], 5e-3 * beyond.mean())


def test_forces_are_the_gradients_of_the_layouts_likelihood():
    """q = 1 / (1 + A d^2B): an edge is drawn along log q, a sampled row pushed along log(1 - q)."""
    gap = noise(2, 50, dtype=torch.float64).requires_grad_(True)
    power = torch_umap.A * gap.square().sum(0) ** torch_umap.B
    (drawn,) = torch.autograd.grad(-torch.log1p(power).sum(), gap, retain_graph=True)
    (pushed,) = torch.autograd.grad((power.log() - torch.log1p(power)).sum(), gap)
    far = gap.square().sum(0) > 0.5
    torch.testing.assert_close(torch_umap.attraction(gap), drawn)
    torch.testing.assert_close(torch_umap.repulsion(gap)[:, far], pushed[:, far], rtol=3e-3, atol=0)


def test_the_fuzzy_graph_is_the_union_of_both_directions():
    found = nearest(noise(30, 3), 5)
    graph = torch_umap.fuzzy_graph(found)
    beyond = found.distance - found.distance[:, :1]
    weight = (-beyond / torch_umap._widths(beyond, torch.tensor(6.0).log2().item())).exp()
    one_way = torch.zeros(30, 30).scatter_(1, found.index, weight)
    wanted = one_way + one_way.T - one_way * one_way.T
    got = torch.zeros(30, 30)
    got[graph.tail, graph.head] += graph.weight
    got[graph.head, graph.tail] += graph.weight
    torch.testing.assert_close(got, wanted)


def test_umap_is_more_trustworthy_than_pca_on_a_curved_sheet():
    along = torch.linspace(3, 12, 400)
    sheet = torch.stack([along * along.cos(), along * along.sin(), 9 * noise(400).sigmoid()], 1)
    flat = torch_umap.project(sheet)
    assert trustworthiness(sheet, flat) > max(0.97, trustworthiness(sheet, pca.project(sheet)))


def test_the_same_seed_gives_the_same_map():
    points, _ = clusters(each=10)
    assert torch.equal(torch_umap.project(points, seed=3), torch_umap.project(points, seed=3))


@pytest.mark.parametrize("name", SCHEMES)
@pytest.mark.parametrize(
    "points",
    [
        torch.zeros(20, 4),
        noise(1, 4),
        noise(3, 4),
        1e6 + noise(30, 4),
        1e-6 * noise(30, 4),
        torch.cat([noise(20, 4)] * 2),
    ],
    ids=["equal", "one", "three", "far", "tiny", "twice"],
)
def test_odd_sets_still_have_a_finite_map(name, points):
    flat = load(PROJECTIONS, name, kind="projection")(points)
    assert flat.shape == (len(points), 2)
    assert flat.isfinite().all()


def test_alignment_undoes_a_turn_and_a_mirror():
    flat = noise(30, 2, dtype=torch.float64)
    flat = flat - flat.mean(0)
    turn = torch.linalg.qr(noise(2, 2, seed=5, dtype=torch.float64)).Q
    for change in (turn, turn @ torch.diag(torch.tensor([1.0, -1.0], dtype=torch.float64))):
        torch.testing.assert_close(aligned(flat @ change, flat), flat)


def test_a_chain_of_maps_moves_less_than_maps_made_apart_and_shows_as_much():
    points, _ = clusters(each=30)
    turned = [points + 0.3 * step * noise(*points.shape, seed=9) for step in range(4)]
    warm = []
    for points in turned:
        warm.append(torch_umap.project(points, start=warm[-1] if warm else None))
    apart = [torch_umap.project(points, seed=step) for step, points in enumerate(turned)]
    moved, jumped = (
        [float((b - a).norm(dim=1).mean() / (a - a.mean(0)).norm()) for a, b in pairwise(maps)]
        for maps in (warm, apart)
    )
    assert 10 * max(moved) < min(jumped)
    for points, flat, alone in zip(turned, warm, apart, strict=True):
        assert trustworthiness(points, flat) > trustworthiness(points, alone) - 0.01


@pytest.mark.parametrize("rows", [80, 1100])  # more rows are not held at once
def test_quality_agrees_with_scikit_learn_and_is_perfect_for_the_points_themselves(rows):
    from sklearn.manifold import trustworthiness as reference

    points, flat = noise(rows, 6), noise(rows, 2, seed=1)
    wanted = reference(points.numpy(), flat.numpy(), n_neighbors=7)
    assert trustworthiness(points, flat, k=7) == pytest.approx(wanted)
    assert trustworthiness(flat, flat, k=7) == quality(flat, flat, k=7).recall == 1


def test_a_nearer_neighbour_draws_a_new_row_more():
    points = torch.tensor([[0.0, 0.0], [1.0, 0.0], [10.0, 0.0]], dtype=torch.float64)
    flat = torch.tensor([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]], dtype=torch.float64)
    beyond = torch.tensor([0.0, 0.8, 9.8], dtype=torch.float64)  # of the distances 0.1, 0.9, 9.9
    weight = (-beyond / beyond.mean()).exp()
    wanted = (weight / weight.sum()) @ flat
    query = torch.tensor([[0.1, 0.0]], dtype=torch.float64)
    torch.testing.assert_close(place(query, points, flat)[0], wanted)


def test_a_turned_linear_map_places_rows_that_it_never_saw():
    points, fresh, other = noise(73, 8, dtype=torch.float64).split((60, 5, 8))
    axes = torch.linalg.qr(other).Q[:, :2]
    flat = points @ axes + 3
    found = placed_by(affine(points, flat), fresh, points, flat)
    torch.testing.assert_close(found, fresh @ axes + 3, atol=1e-9, rtol=0)


def test_a_map_that_is_not_linear_is_not_taken_for_one():
    points = noise(60, 8)
    assert affine(points, points[:, :2] ** 2) is None
    found = placed_by(None, points[:1], points, points[:, :2] ** 2)
    torch.testing.assert_close(found, points[:1, :2] ** 2)


def test_too_few_points_cannot_show_that_a_map_is_linear():
    points = noise(10, 8, dtype=torch.float64)
    assert affine(points[:9], points[:9, :2]) is None
    assert affine(points, points[:, :2]) is not None


@pytest.mark.parametrize("gap", [3.0, 0.1])
def test_a_row_is_repelled_five_times_as_strongly_as_by_one_row_of_the_map(gap):
    """Rows at two places without edges: half of the sampled rows are the others. No push is above
    4, as in umap-learn.
    """
    start = torch.zeros(800, 2, dtype=torch.float64)
    start[400:, 0] = gap
    none = torch.zeros(0, dtype=torch.long)
    graph = torch_umap.Graph(tail=none, head=none, weight=start.new_zeros(0), rows=800)
    moved = torch_umap.descend(graph, start, steps=1, rate=1.0, seed=0) - start
    a, b = torch_umap.A, torch_umap.B  # the gradient of -log(1 - 1 / (1 + a d^2b))
    force = min(4, 2 * b * gap / ((1e-3 + gap**2) * (1 + a * gap ** (2 * b))))
    assert float(moved[:400, 0].mean()) == pytest.approx(-5 / 2 * force, rel=0.1)
    assert float(moved[400:, 0].mean()) == pytest.approx(5 / 2 * force, rel=0.1)


@pytest.mark.parametrize(("rows", "dimensions", "k"), [(4, 3, None), (5, 3, 4), (40, 2, 15)])
def test_umap_learn_maps_sets_from_two_rows_more_than_dimensions(monkeypatch, rows, dimensions, k):
    """A stand-in for umap-learn notes its settings: the real one compiles for ten seconds."""
    asked = []

    class Stand:
        def __init__(self, **settings):
            asked.append(settings)

        def fit_transform(self, points):
            return points[:, :dimensions]

    monkeypatch.setitem(sys.modules, "umap", type(sys)("umap"))
    monkeypatch.setattr(sys.modules["umap"], "UMAP", Stand, raising=False)
    points = noise(rows, 6)
    flat = umap.project(points, seed=2**32 + 7, dimensions=dimensions)
    if k is None:
        torch.testing.assert_close(flat, pca.project(points, dimensions=dimensions))
        assert asked == []
    else:
        settings = {"n_neighbors": k, "n_components": dimensions, "random_state": 7, "n_jobs": 1}
        assert asked == [settings]


def test_the_pull_of_an_edge_moves_both_ends_by_their_share_of_weight():
    """Two edges of one row: a step is rate · 2 weight / degree · attraction, at each end."""
    start = torch.tensor([[0.0, 0.0], [1.0, 0.0], [0.0, 2.0]], dtype=torch.float64)
    weight = torch.tensor([1.0, 0.5], dtype=torch.float64)
    graph = torch_umap.Graph(
        tail=torch.tensor([0, 0]), head=torch.tensor([1, 2]), weight=weight, rows=3
    )
    alone = torch_umap.Graph(tail=graph.tail, head=graph.head, weight=0 * weight, rows=3)
    by_edges, by_rows = (
        torch_umap.descend(g, start, steps=1, rate=0.1, seed=0) for g in (graph, alone)
    )
    pull = torch_umap.attraction((start[graph.tail] - start[graph.head]).T).T
    wanted = torch.stack([2 * (pull[0] / 1.5 + pull[1] * 0.5 / 1.5), -2 * pull[0], -2 * pull[1]])
    torch.testing.assert_close(by_edges - by_rows, 0.1 * wanted, atol=1e-3, rtol=1e-3)


def test_the_curve_of_attraction_is_umap_s_fit_to_a_flat_start_of_a_tenth_and_an_exponential():
    """A and B are fitted anew, as umap-learn does for min_dist = 0.1 and spread = 1."""
    distance = np.linspace(0, 3, 300)
    wanted = np.where(distance < 0.1, 1.0, np.exp(0.1 - distance))
    found, _ = curve_fit(lambda x, a, b: 1 / (1 + a * x ** (2 * b)), distance, wanted)
    assert found == pytest.approx((torch_umap.A, torch_umap.B), abs=1e-4)


def test_too_many_neighbours_are_refused():
    with pytest.raises(SettingsError, match="5 neighbours were requested among 4; choose 1 to 4"):
        nearest(noise(5, 3), 5)


def test_a_missing_umap_learn_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "umap", None)
    with pytest.raises(MissingPackageError, match="pip install umap-learn"):
        umap.project(noise(8, 4))
