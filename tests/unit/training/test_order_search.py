"""The search for p: it finds the order of chirps from any start, and uses the source only."""

from dataclasses import replace

import numpy as np
import pytest
import torch

from omnivat.fractional import dfrft
from omnivat.head.predict_set import predicted_probabilities
from omnivat.training import TrainSettings, Watch, order_search, train
from omnivat.training.order_search import (
    Scored,
    _grams,
    _note,
    folded,
    lowest_point,
    lowest_valleys,
    neighbours,
    search_order,
    search_steps,
    tied,
)
from omnivat.training.watch import UNWATCHED
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


def searched(chirps, *, epochs=20, watch=UNWATCHED, **changes):
    source = chirps.in_domain(DOMAINS[0], split="train")
    settings = TrainSettings(epochs=epochs, lang=False, order_search=True)
    return train(source, head(theta_init="signed", **changes), settings, watch=watch)


@pytest.fixture(scope="module")
def trained(chirps):
    return searched(chirps, order=-1.3)


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


@pytest.fixture(scope="module")
def search_of(make_embeddings):
    """Return a function: the record of a search on chirps at `order`, beside interference near
    others, of VIS and of TAC. It shares no line with `simulator.chirps`.
    """
    pairs = make_embeddings(domains=("a",), per_class=20)
    rows, random = np.arange(len(pairs)), np.random.default_rng(0)

    def spikes(places, order, width):
        """Return rows of unit length that are spikes of random phase at an order."""
        spectrum = np.zeros((len(rows), width), complex)
        for place in places:
            spectrum[rows, place] += np.exp(2j * np.pi * random.random(len(rows)))
        signal = dfrft(torch.from_numpy(spectrum), -order).real.numpy()
        return signal / np.linalg.norm(signal, axis=1, keepdims=True)

    def search(order, near, *, width=64, strength=2.0):
        of_class = random.permutation(np.arange(1, width // 2))[pairs.label]
        halves = {
            name: spikes([of_class], order, width)
            + strength * spikes(random.integers(0, width, (3, len(rows))), other, width)
            + 0.05 * random.normal(size=(len(rows), width))
            for name, other in zip(("vis", "tac"), near, strict=True)
        }
        source = replace(pairs, vis_flip=None, tac_flip=None, **halves)
        classes = pairs.header.classes
        settings = head(input_width=width, width=width, classes=classes, standardize=False)
        return search_order(source, settings, TrainSettings(), seed=0, watch=Watch())

    return search


@pytest.mark.parametrize(
    ("order", "near", "width"),
    [(0.0, (0.5, 0.6), 32), (1.0, (0.5, 0.6), 32), (0.4, (0.28, 0.55), 64), (0.05, (0.0, 0.0), 64)],
)
def test_orders_between_at_both_ends_and_beside_interference_are_found(
    search_of, order, near, width
):
    """0.05 from interference is closer than a valley is wide: tokens alone find 0 there."""
    search = search_of(order, near, width=width)
    coarse = [
        p for p, kind in zip(search["orders"], search["round"], strict=True) if kind == "coarse"
    ]
    assert search["start"] == pytest.approx(order, abs=0.015)
    assert (coarse[0], coarse[-1]) == (0.0, 1.0)


def test_a_set_without_classes_in_its_signals_has_orders_that_tie(search_of):
    search = search_of(0.4, (0.0, 1.0), strength=200.0)
    assert len(search["ties"]) >= 3 and "does not tell them apart" in search["note"]
    assert all(abs(p - search["start"]) > 3 / 64 for p in search["ties"])


def test_steps_of_search_and_training_are_counted_as_one_work(chirps):
    steps = []
    searched(chirps, epochs=1, watch=Watch(on_step=steps.append))
    assert [step.done for step in steps] == list(range(1, steps[-1].total + 1))
    assert len({step.total for step in steps}) == 1


def test_a_curve_without_a_valley_gives_its_best_order():
    assert lowest_point([(0.1, 1.0), (0.2, 2.0), (0.3, 1.5)]) == 0.1
    assert lowest_point([(0.1, 1.0), (0.2, 0.5), (0.3, 1.0)]) == pytest.approx(0.2)


@pytest.mark.parametrize("bottom", [0.17, 0.23])
def test_a_valleys_bottom_between_two_orders_is_found(bottom):
    orders = np.linspace(0.1, 0.3, 5)
    points = [(p, 1 + (p - bottom) ** 2) for p in orders]
    assert lowest_point(points) == pytest.approx(bottom)


def test_orders_outside_a_valley_hardly_move_its_bottom():
    orders = np.linspace(0, 0.6, 17)
    scores = 1 - np.exp(-(((orders - 0.27) / 0.08) ** 2)) + 0.5 * (orders > 0.5)
    found, shifted = (lowest_point([*zip(orders, scores + by, strict=True)]) for by in (0, 5))
    assert found == pytest.approx(0.27, abs=0.01) and shifted == pytest.approx(found)


@pytest.mark.parametrize(("ties", "end"), [(3, "0.600:"), (4, "0.600 and others:")])
def test_a_note_names_three_orders_that_tie_and_tells_of_more(ties, end):
    assert f"ties with 0.400, 0.500, {end}" in _note(0.1, (0.0, 0.2), [0.4, 0.5, 0.6, 0.7][:ties])


def test_orders_fold_into_the_first_quarter_turn():
    assert [folded(p) for p in (-0.1, 0.4, 1.2, 2.3)] == pytest.approx([0.1, 0.4, 0.8, 0.3])


def test_inner_products_of_each_modality_and_their_mean_do_not_depend_on_the_tokens_length():
    tokens = torch.from_numpy(np.random.default_rng(0).normal(size=(2, 6, 4)))
    vis, tac, both = _grams(1e-4 * tokens)
    torch.testing.assert_close([vis, tac, (vis + tac) / 2], _grams(3.0 * tokens))
    assert float(both.trace()) / 6 == pytest.approx(1.0)
    assert len(_grams(tokens[:1])) == 1


def test_the_spread_of_a_score_is_the_standard_error_of_its_mean():
    assert scored(0.5, 1.0, 2.0, 3.0, 6.0).spread == pytest.approx(np.sqrt(14 / 3 / 4))


def scored(order, *losses):
    return Scored(order=order, losses=np.array([losses]), round="coarse")


def test_a_tie_is_judged_by_paired_differences_and_outside_the_best_valley():
    best = scored(0.5, 0.1, 0.9, 0.1, 0.9)
    same, worse = scored(0.1, 0.9, 0.1, 0.2, 0.9), scored(0.9, 0.2, 1.01, 0.2, 1.01)
    beside = scored(0.52, 0.1, 0.9, 0.1, 0.9)
    assert tied([best, beside, worse, same], best, 0.06) == [0.1]


def test_the_orders_around_the_best_that_tie_with_it_are_named():
    best = scored(0.5, 0.1, 0.9, 0.1, 0.9)
    same = [scored(p, 0.9, 0.1, 0.2, 0.9) for p in (0.48, 0.51, 0.52, 0.6)]
    worse = [scored(p, 0.2, 1.01, 0.2, 1.01) for p in (0.45, 0.55)]
    assert neighbours([best, *same, *worse], best) == (0.48, 0.52)
    assert neighbours([best, *worse], best) == (0.5, 0.5)
    assert (
        neighbours([scored(-0.01, 0.1, 0.9), scored(0.0, 0.1, 0.9)], scored(0.0, 0.1, 0.9))[0] == 0
    )


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


@pytest.mark.parametrize("sizes", [(1,) * 8, (2, 2, 1, 3)])
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
