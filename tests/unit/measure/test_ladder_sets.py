"""Records of further sets hold what heads predict, and the table's intervals take sources and sets as random."""

import json

import numpy as np
import pytest

from benchmarks import _ladder_methods, _recompute_sets, ladder_sets, ladder_sets_table
from omnivat.data.packing import unodds
from omnivat.measure.ladder import letters


@pytest.fixture
def written(make_embeddings, monkeypatch, tmp_path):
    """Return a set, the lines of its records and their file; two members of two epochs."""
    monkeypatch.setattr(_ladder_methods, "HEADS", tmp_path / "heads")
    monkeypatch.setattr(_ladder_methods, "PAGE", {**_ladder_methods.PAGE, "epochs": 2})
    monkeypatch.setattr(ladder_sets, "MEMBERS", 2)
    made, out = make_embeddings(per_class=24, split=True), tmp_path / "sets.jsonl"
    ladder_sets.append(out, ladder_sets.facts(made, "7"))
    methods = ("logistic_recipe", "omnivat")
    ladder_sets.of_source(made, "7", made.header.domains[0], methods, (0, 1), out)
    return made, out, methods


def test_each_member_and_their_ensemble_have_one_line_and_a_second_run_adds_none(written):
    made, out, methods = written
    _, *runs = map(json.loads, out.read_text().splitlines())
    assert [(r["method"], r["member"]) for r in runs] == [
        ("logistic_recipe", 0),
        ("logistic_recipe", 1),
        ("logistic_recipe", "mean"),
        ("omnivat", 0),
        ("omnivat", 1),
        ("omnivat", "mean"),
        ("distilled", 0),
    ]
    before = out.read_text()
    ladder_sets.of_source(made, "7", made.header.domains[0], methods, (0, 1), out)
    assert out.read_text() == before


def test_the_odds_of_the_members_give_the_ensembles_classes(written):
    _, out, _ = written
    first, *runs = map(json.loads, out.read_text().splitlines())
    tested = np.array(list(first["split"])) == "e"
    for method in ("logistic_recipe", "omnivat"):
        own = {r["member"]: r for r in runs if r["method"] == method}
        shares = [unodds(own[member]["odds"], len(first["classes"])) for member in (0, 1)]
        said = letters(own["mean"]["all"])[tested]
        assert np.mean(np.mean(shares, axis=0).argmax(1) == said) > 0.99  # half precision may break a tie
        home = letters(first["domain"])[tested] == 0
        assert (letters(own["mean"]["n5"])[home] == -1).all() and (letters(own["mean"]["n5"])[~home] >= 0).all()


def test_both_computations_of_an_interval_agree_and_it_widens_when_sets_differ():
    random = np.random.default_rng(0)
    cells = random.normal(size=(8, 1)) + random.normal(scale=0.2, size=(8, 3))  # sources, sets
    apart = cells + 2 * np.array([-1.0, 0.0, 1.0])
    for one in (cells, apart, random.normal(size=(8, 3)), cells[:, :2]):
        np.testing.assert_allclose(ladder_sets_table.crossed(one), _recompute_sets.interval(one.T.tolist()))
    near, wide = ladder_sets_table.crossed(cells), ladder_sets_table.crossed(apart)
    assert near.mean == pytest.approx(wide.mean) and wide.high - wide.low > 3 * (near.high - near.low)


def test_an_interval_holds_the_truth_as_often_as_it_says():
    random, held = np.random.default_rng(1), 0
    for _ in range(400):
        cells = random.normal(size=(8, 1)) + 0.5 * random.normal(size=(1, 3)) + random.normal(size=(8, 3))
        found = ladder_sets_table.crossed(cells)
        held += found.low < 0 < found.high
    assert held >= 0.93 * 400
