"""The ladder's ensembles are what their members predict, and its records hold what they predicted."""

import numpy as np
import pytest

from benchmarks import _ladder_methods as methods
from benchmarks.ladder import Climb
from omnivat.data.packing import unodds
from omnivat.measure.ladder import letters


@pytest.fixture
def two_members(monkeypatch, tmp_path):
    monkeypatch.setattr(methods, "HEADS", tmp_path / "heads")
    monkeypatch.setattr(methods, "MEMBERS", 2)
    monkeypatch.setattr(methods, "PAGE", {**methods.PAGE, "epochs": 2})
    return tmp_path / "heads"


@pytest.mark.parametrize("one", ["omnivat", "erm_recipe"])
def test_an_ensemble_predicts_the_mean_of_heads_that_are_trained_once(make_embeddings, two_members, one):
    made = make_embeddings(per_class=24, split=True)
    soft = Climb(made, {"omnivat": "omnivat_soft", "erm_recipe": "erm_soft"}[one], 0, 0)
    members = [Climb(made, one, 0, seed).method for seed in range(2)]
    pair = (made.vis[::7], made.tac[::7])
    wanted = np.mean([member.probabilities(pair) for member in members], axis=0)
    np.testing.assert_allclose(soft.method.probabilities(pair), wanted, rtol=1e-6)
    assert len(list(two_members.glob("*.pt"))) == 2


def test_the_odds_of_a_record_give_the_predictions_of_pairs_as_they_come(make_embeddings, two_members):
    made = make_embeddings(per_class=24, split=True)
    climb = Climb(made, "distilled", 0, 0)
    answers = climb.rungs()
    shares = unodds(climb.odds(), len(made.header.classes))
    tested = np.flatnonzero(climb.split == "test")
    for rung, own in (("none", False), ("home", True)):
        here = (made.domain[tested] == 0) == own
        np.testing.assert_array_equal(shares[here].argmax(1), letters(answers[rung])[here])
    assert sorted(f.name.split("-")[0] for f in two_members.glob("*.pt")) == ["distilled", "omnivat", "omnivat"]
