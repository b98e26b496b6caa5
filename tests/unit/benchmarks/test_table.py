"""The one table of results: what a run holds, how labels teach, and how records become figures."""

import json
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from benchmarks import table
from benchmarks.relief import Reliefs, Wide
from omnivat.data.store import load_embeddings
from omnivat.head.heads import LADDERS, RELIEF, default_embeddings
from omnivat.kit.lines import lines as all_lines
from omnivat.measure.ladder import FORMAT


@pytest.fixture(scope="module")
def embeddings(make_embeddings):
    return make_embeddings(
        domains=("TAG-sim", "OF Real-sim", "TQ-DIGIT-sim"), per_class=24, split=True
    )


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


def test_one_vector_holds_colours_beside_relief_and_the_photo_once(embeddings):
    lit = replace(embeddings, tac=embeddings.tac[::-1].copy())
    relief = SimpleNamespace(colours=embeddings, source=lit, alone=lit, target=lambda *_: lit)
    wide = Wide(relief)
    for one in (wide.source, wide.alone, wide.target(None, 0)):
        colours, bent = np.hsplit(one.tac, 2)
        assert np.array_equal(colours, embeddings.tac) and np.array_equal(bent, lit.tac)
        photo, rest = np.hsplit(one.vis, 2)
        assert np.array_equal(photo, embeddings.vis) and not rest.any()


@pytest.mark.slow
def test_the_record_by_relief_holds_what_the_shipped_folder_gives():
    whole, (_, *lines) = load_embeddings(default_embeddings()), all_lines(RELIEF, FORMAT)
    run = {"method": "nearest_mean", "source": "TAG-sim", "seed": 0}
    kept = next(one for one in lines if run.items() <= one.items())["answers"]
    relief = Reliefs(whole)
    shares = table.Measured(relief.source, *run.values(), relief=relief).shares()
    assert {rung: table.letters_of(values) for rung, values in shares.items()} == kept


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
