"""The search for p: it finds the order of chirps from any start, and uses the source only."""

import numpy as np
import pytest
import torch

from omnivat.fractional import dfrft
from omnivat.head.predict_set import predicted_probabilities
from omnivat.training import TrainSettings, Watch, order_search, train
from omnivat.training.order_search import (
    Scored,
    _grams,
    lowest_point,
    lowest_valleys,
    neighbours,
    search_order,
    search_steps,
    tied,
)
from simulator.chirps import CLASSES, DOMAINS, ChirpSettings
from simulator.tests.chirp_sets import chirp_embeddings
from tests.builders import head_settings

CHIRPS = ChirpSettings(order=0.62, seed=3)


@pytest.fixture(scope="module")
def chirps():
    return chirp_embeddings(CHIRPS)


def head(**changes):
    values = {"classes": CLASSES, "input_width": 64, "lang_width": 1, "width": 64}
    return head_settings(**(values | changes))


@pytest.fixture(scope="module")
def trained(chirps):
    source = chirps.in_domain(DOMAINS[0], split="train")
    settings = TrainSettings(epochs=20, lang=False, order_search=True)
    return train(source, head(theta_init="signed", order=-1.3), settings)


@pytest.mark.slow
def test_the_order_of_chirps_is_found_from_a_far_start(chirps, trained):
    unseen = chirps.in_domain(DOMAINS[1])
    answers = predicted_probabilities(trained.model, unseen)["fused"].argmax(1).numpy()
    assert trained.model.order == pytest.approx(CHIRPS.order, abs=0.01)
    assert (answers == unseen.label).mean() >= 0.97


@pytest.mark.slow
def test_the_record_of_a_search_holds_its_curve_and_what_it_cost(trained):
    search = trained.search
    coarse = [
        score
        for score, kind in zip(search["score"], search["round"], strict=True)
        if kind == "coarse"
    ]
    assert search["orders"][:65] == [k / 64 for k in range(65)] and len(coarse) == 65
    assert len(search["orders"]) == len(search["spread"]) == len(search["score"])
    assert search["orders"][int(np.argmin(coarse))] == pytest.approx(CHIRPS.order, abs=0.02)
    assert search["steps"] == search_steps(head())
    assert search["found"] == trained.model.order
    assert search["ties"] == [] and "are worse by three standard errors" in search["note"]
    low, high = search["between"]
    assert low <= search["start"] <= high < low + 4 / 64


def test_an_order_at_the_end_is_found():
    settings = ChirpSettings(order=1.0, pairs_per_class=20)
    source = chirp_embeddings(settings).in_domain(DOMAINS[0])
    search = search_order(source, head(), TrainSettings(), seed=0, watch=Watch())
    assert search["start"] == pytest.approx(1.0, abs=0.015)


def test_a_curve_without_a_valley_gives_its_best_order():
    assert lowest_point([(0.1, 1.0), (0.2, 2.0), (0.3, 1.5)]) == 0.1
    assert lowest_point([(0.1, 1.0), (0.2, 0.5), (0.3, 1.0)]) == pytest.approx(0.2)


def test_a_valleys_bottom_between_two_orders_is_found():
    bottom = 0.17
    orders = np.linspace(0.1, 0.3, 5)
    points = [(p, 1 + (p - bottom) ** 2) for p in orders]
    assert lowest_point(points) == pytest.approx(bottom)


def scored(order, *losses):
    return Scored(order=order, losses=np.array([losses]), round="coarse")


def test_a_tie_is_judged_by_paired_differences_and_outside_the_best_valley():
    best = scored(0.5, 0.1, 0.9, 0.1, 0.9)
    same, worse = scored(0.1, 0.9, 0.1, 0.2, 0.9), scored(0.9, 0.2, 1.01, 0.2, 1.01)
    beside = scored(0.52, 0.1, 0.9, 0.1, 0.9)
    assert tied([best, beside, worse, same], best, 0.06) == [0.1]


def test_a_classifier_that_is_worse_than_chance_counts_as_chance():
    losses = np.array([[0.2, 0.4], [1.5, 3.5]])
    assert Scored(order=0.1, losses=losses, round="fine").score == pytest.approx((0.3 + 1) / 2)


def test_valleys_are_apart_and_as_many_as_are_refined():
    orders = [
        scored(p, loss, loss)
        for p, loss in ((0, 0.3), (0.1, 0.1), (0.12, 0.15), (0.5, 0.2), (1, 0.9))
    ]
    assert [one.order for one in lowest_valleys(orders, 0.2)] == [0.1, 0.5, 1]
    assert [one.order for one in lowest_valleys(orders, 2.0)] == [0.1, 0.12, 0.5]


def test_three_standard_errors_of_the_paired_difference_are_the_limit_of_a_tie():
    """The difference has the mean 0.3 over 9 pairs; its standard error is 0.3 / doubt."""
    base = np.array([0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0])
    for doubt, ties in ((2.95, True), (3.05, False)):
        wave = np.array([-1, 1, -1, 1, 0, 1, -1, 1, -1]) * 0.3 / doubt * 3
        wave = wave / wave.std(ddof=1) * 0.3 / doubt * 3
        best, other = scored(0.5, *base), scored(0.51, *(base + 0.3 + wave))
        assert (neighbours([best, other], best) == (0.5, 0.51)) is ties


def test_an_order_is_scored_by_tokens_and_energies_of_photo_touch_and_both(chirps):
    source = chirps.in_domain(DOMAINS[0], split="train")
    scores = order_search._Scores(source, head(), TrainSettings(), 0, Watch())
    images = {name: torch.from_numpy(np.array(getattr(source, name))) for name in ("vis", "tac")}
    turned = dfrft(scores.model.embedded(images).detach(), 0.3)
    parts = [part.relu() for x in (turned.real, turned.imag) for part in (x, -x)]
    rows = torch.cat(parts, -1), turned.abs().square()
    grams = [gram for some in rows for gram in _grams(some)]
    wanted = [order_search._left_out(gram, scores.targets, scores.groups) for gram in grams]
    found = scores.at(0.3, "coarse").losses * (scores.targets**2).sum(1).mean()
    np.testing.assert_allclose(found, wanted, rtol=1e-3, atol=1e-4)
    assert found.shape == (6, len(source))


def test_the_grid_is_as_fine_as_the_width_and_bounded():
    counts = [search_steps(head(width=width)) - 3 * 17 for width in (8, 64, 4096)]
    assert counts == [21, 65, 2001]


def test_pairs_are_left_out_with_their_object_if_each_class_has_two():
    labels = np.array([0, 0, 0, 1, 1])
    for objects, wanted in (
        (["a", "a", "b", "c", "d"], [[0, 1], [2], [3], [4]]),
        (["a", "a", "b", "c", "c"], [[0], [1], [2], [3], [4]]),
        (["a", "a", "b", "c", ""], [[0], [1], [2], [3], [4]]),
    ):
        assert [group.tolist() for group in order_search._groups(objects, labels)] == wanted


@pytest.mark.parametrize("sizes", [(2, 2, 1, 3)])
def test_errors_left_out_are_those_of_a_ridge_fitted_to_the_rest(sizes):
    random = np.random.default_rng(0)
    rows = random.standard_normal((8, 3))
    rows -= rows.mean(0)
    targets = random.standard_normal((8, 2))
    targets -= targets.mean(0)
    groups = np.split(np.arange(8), np.cumsum(sizes)[:-1])
    found = order_search._left_out(torch.from_numpy(rows @ rows.T), targets, groups)
    wide = np.hstack([rows, np.ones((8, 1))])  # the mean has no penalty
    for group in groups:
        rest = np.setdiff1d(np.arange(8), group)
        weights = np.linalg.solve(
            wide[rest].T @ wide[rest] + np.diag([1, 1, 1, 0]), wide[rest].T @ targets[rest]
        )
        wanted = ((targets[group] - wide[group] @ weights) ** 2).sum(1)
        np.testing.assert_allclose(found[group], wanted)
