"""The sweep over orders: its curves equal the library's results, without needless work."""

from functools import partial
from importlib import import_module

import numpy as np
import pytest
import torch

from omnivat.kit.errors import SettingsError, ShapeError
from omnivat.maps.sweep import STAGES, sweep, walk
from omnivat.measure.gaps.centroid import modality_gap
from omnivat.measure.gaps.confusion import accuracy, macro_f1
from omnivat.measure.gaps.sums import cosine_margin
from omnivat.measure.gaps.unit import unit

from .frames import small_head
from .frames.small_head import head

ORDERS = (0.0, 0.3, 0.5, 1.0)
pairs = partial(small_head.pairs, domains=3)


class Counting:
    """A head that counts its predicted pairs and orders."""

    def __init__(self, model, monkeypatch):
        self.pairs, self.prepared = 0, 0
        inner, prepare = model.from_coefficients, model.coefficients

        def from_coefficients(kept, order, **options):
            self.pairs += len(kept)
            return inner(kept, order, **options)

        def coefficients(vis, tac):
            self.prepared += 1
            return prepare(vis, tac)

        monkeypatch.setattr(model, "from_coefficients", from_coefficients)
        monkeypatch.setattr(model, "coefficients", coefficients)


@torch.no_grad()
def test_every_curve_is_what_the_head_and_the_measure_return():
    model, data = head(), pairs()
    found = sweep(model, data, ORDERS, stages=("relu", "f_bar", "f_hat"))
    labels = torch.from_numpy(data.label)
    for place, order in enumerate(ORDERS):
        out = model(torch.from_numpy(data.vis), torch.from_numpy(data.tac), order=order)
        np.testing.assert_allclose(found.probabilities[place], out.probabilities, atol=1e-6)
        answers = out.probabilities.argmax(1)
        wanted = {
            "modality_gap/f_hat": modality_gap(out.f_hat["vis"], out.f_hat["tac"]),
            "modality_gap/relu": modality_gap(
                *(out.relu[name].movedim(1, 0).flatten(1) for name in ("vis", "tac"))
            ),
            "modality_gap/f_bar/D1": modality_gap(out.f_bar["vis"][1::3], out.f_bar["tac"][1::3]),
            "margin:tac/f_bar": cosine_margin(out.f_bar["tac"], labels),
            "margin/f_hat": cosine_margin(unit(out.f_hat["vis"]) + unit(out.f_hat["tac"]), labels),
            "accuracy/all": accuracy(labels, answers),
            "accuracy/D2": accuracy(labels[2::3], answers[2::3]),
            "macro_f1/all": macro_f1(labels, answers),
            "accuracy:vis/all": accuracy(labels, out.alone["vis"].argmax(1)),
            "accuracy:vis_branch/all": accuracy(labels, out.logits["vis"].argmax(1)),
        }
        for name, value in wanted.items():
            assert found.curves[name][place] == pytest.approx(value.item(), abs=1e-6), name


def test_coefficients_are_made_once_and_each_pair_passes_once_an_order_in_chunks_of_any_size(
    monkeypatch,
):
    model, data = head(), pairs()
    whole = sweep(model, data, ORDERS, stages=STAGES)
    count = Counting(model, monkeypatch)
    monkeypatch.setattr(import_module("omnivat.maps.sweep.walk"), "CHUNK", 7)
    cut = sweep(model, data, ORDERS, stages=STAGES)
    assert count.prepared == 1
    assert count.pairs == len(data) * len(ORDERS)
    np.testing.assert_allclose(whole.probabilities, cut.probabilities, atol=1e-6)
    for name, curve in whole.curves.items():
        np.testing.assert_allclose(cut.curves[name], curve, atol=1e-6)


def test_a_class_that_the_head_does_not_know_counts_in_gaps_and_not_in_scores():
    data = pairs(classes=("steel", "felt", "wood"))
    found = sweep(head(), data, (0.5,))
    assert found.classes == ("wood", "steel", "glass", "felt")
    assert [found.classes[i] for i in found.label] == [data.header.classes[i] for i in data.label]
    known = np.isin(found.label, [0, 1, 2])
    right = found.probabilities[0].argmax(1)[known] == found.label[known]
    assert found.curves["accuracy/all"][0] == pytest.approx(right.mean())


def test_a_domain_too_small_for_a_measure_is_named():
    with pytest.raises(ShapeError, match="proxy_a: .* needs 5 or more.* D0 3, D1 3, D2 2"):
        sweep(head(), pairs(count=8), (0.5,), measures=("proxy_a",))


def test_a_projecting_head_measures_its_own_transform():
    found = sweep(head(width=8), pairs(), ORDERS, stages=("raw", "frft"))
    assert found.curves["modality_gap/frft"][0] != found.curves["modality_gap/raw"][0]


def test_an_order_that_is_no_number_is_refused():
    with pytest.raises(SettingsError, match="Every order must be a finite number"):
        sweep(head(), pairs(), (float("nan"),))


def test_what_stays_still_comes_with_the_first_order_visited_and_never_again():
    first, *later = walk(head(), pairs(), ORDERS, stages=("raw", "frft", "f_hat"))
    assert set(first.features) == {"raw", "frft", "f_hat"}
    assert [set(found.features) for found in later] == [{"f_hat"}] * 3
    alone = list(walk(head(), pairs(), ORDERS, stages=("raw", "frft"), predictions=False))
    assert [found.index for found in alone] == [0]
    assert alone[0].probabilities == {}
