"""The one table of results: what a run holds, how labels teach, and how records become figures."""

import json
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import torch

from benchmarks import _table_methods, table, table_text
from benchmarks.relief import Reliefs, Wide, read, write
from omnivat.data.store import load_embeddings
from omnivat.head.heads import LADDERS, RELIEF, default_embeddings
from omnivat.kit.lines import lines as all_lines
from omnivat.measure.ladder import FORMAT, letters


@pytest.fixture(scope="module")
def embeddings(make_embeddings):
    return make_embeddings(
        domains=("TAG-sim", "OF Real-sim", "TQ-DIGIT-sim"), per_class=24, split=True
    )


def test_a_run_says_a_class_of_every_test_pair_and_home_stands_apart(embeddings):
    shares = table.Measured(embeddings, "nearest_mean", "OF Real-sim", 0).shares()
    tested = np.array(embeddings.rows["split"]) == "test"
    home = embeddings.domain[tested] == 1
    assert {"home", "none", "vis", "tac", "n5", "n20", "all", "k5", "m2", "m2+"} <= set(shares)
    for rung, values in shares.items():
        said = letters(table.letters_of(values)) >= 0
        assert (said == (home if rung == "home" else ~home)).all(), rung


def test_by_relief_lamps_are_known_of_targets_and_home_has_its_own(embeddings):
    other = replace(embeddings, tac=embeddings.tac[::-1].copy())
    relief = SimpleNamespace(source=embeddings, alone=other, target=lambda known, seed: embeddings)
    shares = table.Measured(embeddings, "nearest_mean", "OF Real-sim", 0, relief=relief).shares()
    colours = table.Measured(embeddings, "nearest_mean", "OF Real-sim", 0).shares()
    for rung, same in {
        "home": "home",
        "l5": "none",
        "l20": "none",
        "n20": "n20",
        "k5": "k5",
    }.items():
        assert np.array_equal(shares[rung], colours[same], equal_nan=True), rung
    assert np.array_equal(shares["l5, touch"], colours["tac"], equal_nan=True)
    assert not np.array_equal(shares["none"], colours["none"], equal_nan=True)


def test_a_head_of_colours_beside_one_of_reliefs_knows_as_much_and_both_decide(
    embeddings, tmp_path
):
    other = replace(embeddings, tac=embeddings.tac[::-1].copy())
    relief = SimpleNamespace(
        colours=embeddings, source=other, alone=other, target=lambda known, seed: other
    )
    run = "OF Real-sim", 0
    table.write_run(other, "nearest_mean+colours", *run, tmp_path / "a.jsonl", relief)
    both = np.load(table.kept(tmp_path / "a.jsonl", "nearest_mean+colours", *run))
    lit = table.Measured(other, "nearest_mean", *run, relief=relief).shares()
    plain = table.Measured(embeddings, "nearest_mean", *run).shares()
    known = {"none": "none", "l20": "none", "a20": "n20", "k5": "k5", "l5, touch": "tac"}
    for rung, same in known.items():
        mean = np.sqrt(lit[rung] * plain[same])
        mean /= mean.sum(1, keepdims=True)
        assert np.allclose(both[rung], mean, atol=2e-3, equal_nan=True), rung


def test_maps_of_three_inputs_read_every_rung_without_labels_and_take_the_photo_once(
    embeddings, tmp_path
):
    no_photo = replace(embeddings, vis=np.zeros_like(embeddings.vis))
    shares = []
    for near in (embeddings, no_photo):  # the photo beside the relief is not read
        relief = SimpleNamespace(colours=embeddings, alone=near, target=lambda *_, own=near: own)
        table.write_run(embeddings, "three_maps", "OF Real-sim", 0, tmp_path / "a.jsonl", relief)
        shares.append(np.load(table.kept(tmp_path / "a.jsonl", "three_maps", "OF Real-sim", 0)))
    assert "n20" in shares[0] and "k5" not in shares[0]
    home = embeddings.domain[np.array(embeddings.rows["split"]) == "test"] == 1
    for rung, values in shares[0].items():
        made = ~np.isnan(values).any(1)
        assert (made == (home if rung == "home" else ~home)).all(), rung
        assert np.array_equal(values, shares[1][rung], equal_nan=True), rung


def test_one_vector_of_colours_beside_relief_is_read_on_every_rung(embeddings, tmp_path):
    lit = replace(embeddings, tac=embeddings.tac[::-1].copy())
    relief = SimpleNamespace(colours=embeddings, source=lit, alone=lit, target=lambda *_: lit)
    wide = Wide(relief)
    for one in (wide.source, wide.alone, wide.target(None, 0)):
        colours, bent = np.hsplit(one.tac, 2)
        assert np.array_equal(colours, embeddings.tac) and np.array_equal(bent, lit.tac)
        photo, rest = np.hsplit(one.vis, 2)
        assert np.array_equal(photo, embeddings.vis) and not rest.any()
    table.write_run(lit, "wide_maps", "OF Real-sim", 0, tmp_path / "a.jsonl", relief)
    shares = np.load(table.kept(tmp_path / "a.jsonl", "wide_maps", "OF Real-sim", 0))
    assert {"home", "none", "l5", "l20", "n5", "n20", "k5", "tac", "l20, touch"} <= set(shares)
    assert not np.array_equal(shares["none"], shares["tac"], equal_nan=True)


@pytest.mark.slow
def test_the_record_by_relief_holds_what_the_shipped_folder_gives():
    whole, (_, *lines) = load_embeddings(default_embeddings()), all_lines(RELIEF, FORMAT)
    run = {"method": "nearest_mean", "source": "TAG-sim", "seed": 0}
    kept = next(one for one in lines if run.items() <= one.items())["answers"]
    relief = Reliefs(whole)
    shares = table.Measured(relief.source, *run.values(), relief=relief).shares()
    assert {rung: table.letters_of(values) for rung, values in shares.items()} == kept


def test_features_are_written_as_bytes_that_turn_a_row_by_less_than_a_degree(tmp_path):
    rows = np.random.default_rng(0).random((4, 1280)).astype(np.float32) ** 12
    write(tmp_path / "some.npz", {"rows": np.arange(4), "tac": rows})
    held = read(tmp_path / "some.npz")
    cosines = (held["tac"] * rows).sum(1) / np.linalg.norm(held["tac"], axis=1)
    assert (cosines / np.linalg.norm(rows, axis=1) > np.cos(np.radians(1))).all()
    assert held["rows"].tolist() == [0, 1, 2, 3]


def test_the_perceptron_of_the_table_learns_its_source(embeddings):
    rows = embeddings.rows_of("TAG-sim", split="train")
    learned = _table_methods.erm_mlp(embeddings, "TAG-sim", 0, {"epochs": 10})
    shares = learned.readings(_table_methods.raw_of(embeddings, rows))["fused"]
    assert (shares.argmax(1).numpy() == embeddings.label[rows]).mean() > 0.9


@pytest.mark.slow
def test_the_records_hold_what_the_table_measures_today():
    """On every rung of the method that needs no training: all kinds of knowledge are drawn so."""
    whole, (_, *lines) = load_embeddings(default_embeddings()), all_lines(LADDERS, FORMAT)
    run = {"method": "nearest_mean", "source": "TAG-sim", "seed": 0}
    kept = next(one for one in lines if run.items() <= one.items())["answers"]
    shares = table.Measured(whole, *run.values()).shares()
    assert {rung: table.letters_of(values) for rung, values in shares.items()} == kept


def test_few_pairs_are_of_each_class_and_of_the_source_alone(embeddings):
    some = table.few(embeddings, "TAG-sim", 3, 0)
    train = some.rows_of("TAG-sim", split="train")
    assert np.bincount(some.label[train]).tolist() == [3] * 5
    assert len(some.rows_of("TAG-sim", split="test")) == len(
        embeddings.rows_of("TAG-sim", split="test")
    )
    assert len(some.rows_of("OF Real-sim")) == len(embeddings.rows_of("OF Real-sim"))


def test_the_ridge_regression_weighs_pairs_as_if_they_stood_there_more_often():
    random = torch.Generator().manual_seed(0)
    rows, asked = (torch.randn(n, 6, generator=random) for n in (20, 5))
    labels = torch.arange(20) % 3
    weights = torch.ones(20)
    weights[15:] = 3
    often = torch.cat((torch.arange(15), torch.arange(15, 20).repeat(3)))
    one = table.ridge(rows, labels, 4, weights, asked)
    other = table.ridge(rows[often], labels[often], 4, torch.ones(len(often)), asked)
    torch.testing.assert_close(one, other)
    assert (one[:, 3] == 0).all()


def test_lines_are_written_once_and_their_mean_is_that_of_the_probabilities(
    embeddings, tmp_path, monkeypatch
):
    def fixed(self: table.Measured) -> dict[str, np.ndarray]:
        first = {0: [0.9, 0.1], 1: [0.3, 0.7]}[self.seed]
        return {"none": np.array([first, [0.2, 0.8]])}

    monkeypatch.setattr(table.Measured, "shares", fixed)
    out = tmp_path / "table.jsonl"
    for seed in (0, 1):
        table.write_run(embeddings, "nearest_mean", "TAG-sim", seed, out)
    for _ in range(2):
        table.average(out, ["nearest_mean"], ("TAG-sim",))
    lines = [json.loads(line) for line in out.read_text().splitlines()]
    answers = [(line["method"], line["heads"], line["answers"]["none"]) for line in lines]
    assert answers == [
        ("nearest_mean", 1, "ab"),
        ("nearest_mean", 1, "bb"),
        ("nearest_mean_mean", 2, "ab"),
    ]


def test_a_record_counts_pairs_of_learned_classes_and_each_target_once(tmp_path):
    first = {
        "domains": ["a", "b", "c"],
        "domain": [0, 1, 1, 1, 2, 2],
        "truth": "ababaa",
        "look_alike": "000010",
    }
    run = {
        "method": "omnivat",
        "source": "a",
        "seed": 0,
        "answers": {"none": ".aaabb", "home": "a....."},
    }
    file = tmp_path / "x.jsonl"
    file.write_text("".join(json.dumps({"format": FORMAT, **line}) + "\n" for line in (first, run)))
    record = table_text.Record(file)
    cells = record.cells("none")["omnivat"]
    # b is not learned in a
    assert cells[0, 1].tolist() == [100.0] and cells[0, 2].tolist() == [0.0]
    assert record.cells("home")["omnivat"][0, 0].tolist() == [100.0]
    assert np.isnan(record.cells("none", alike=True)["omnivat"][0, 1]).all()
