"""`omnivat train`: its files, and resuming."""

import json

import pytest
import torch

from omnivat.cli import main
from omnivat.data.store import save_embeddings
from omnivat.encoders.lang.bank import load_bank
from omnivat.head.checkpoint import load_head


@pytest.fixture(scope="module")
def file(make_embeddings, tmp_path_factory):
    path = tmp_path_factory.mktemp("set") / "set.safetensors"
    save_embeddings(path, make_embeddings())
    return path


def command(file, out, *more):
    fixed = ["train", "--embeddings", str(file), "--source", "TAG-sim", "--out", str(out)]
    return [*fixed, "--set", "width=16", "--set", "epochs=3", *more]


def stopped_in_the_second_epoch(monkeypatch):
    """Make the next training stop as if its process was interrupted."""
    from omnivat.training import training

    learn, calls = training.learn, []

    def learn_until_stopped(*arguments):
        calls.append(1)
        if len(calls) > 4:  # three batches an epoch
            raise KeyboardInterrupt
        return learn(*arguments)

    monkeypatch.setattr(training, "learn", learn_until_stopped)


def test_a_stopped_training_resumes_to_the_weights_it_would_have_given(file, tmp_path, monkeypatch):
    assert main(command(file, tmp_path / "whole")) == 0
    with monkeypatch.context() as patch:
        stopped_in_the_second_epoch(patch)
        assert main(command(file, tmp_path / "head")) == 130
    assert [path.name for path in (tmp_path / "head").iterdir()] == ["training.safetensors"]
    assert main(command(file, tmp_path / "head", "--resume")) == 0
    whole, resumed = (load_head(tmp_path / name).model.state_dict() for name in ("whole", "head"))
    assert all(torch.equal(whole[name], resumed[name]) for name in whole)
    assert not (tmp_path / "head" / "training.safetensors").exists()


def test_the_checkpoint_says_where_its_lang_came_from(file, tmp_path):
    assert main(command(file, tmp_path / "head")) == 0
    record = json.loads((tmp_path / "head" / "settings.json").read_text(encoding="utf-8"))
    bank = load_bank().for_classes(load_head(tmp_path / "head").settings.classes)
    assert record["provenance"]["lang"] == {"origin": bank.origin, "hash": bank.hash}


def test_a_head_of_vis_alone_is_evaluated_with_vis_alone(file, tmp_path):
    assert main(command(file, tmp_path / "head", "--set", "modalities=vis")) == 0
    domains = load_head(tmp_path / "head").metrics["domains"]
    assert all(set(record["scores"]) == {"fused", "vis"} for record in domains)
    assert load_head(tmp_path / "head").provenance["train"]["modalities"] == "vis"


def test_repeats_leave_their_scores_beside_those_of_the_head_that_is_kept(file, tmp_path):
    """The head is --seed's; the others are what training with their seeds gives."""
    assert main(command(file, tmp_path / "head", "--repeat", "1")) == 0
    assert main(command(file, tmp_path / "other", "--seed", "1")) == 0
    kept, other = (
        json.loads((tmp_path / name / "metrics.json").read_text()) for name in ("head", "other")
    )
    assert [one["seed"] for one in kept["seeds"]] == [0, 1]
    assert kept["seeds"][0]["target_accuracy"] == kept["target_accuracy"]
    assert kept["seeds"][1] == other["seeds"][0]
    assert set(kept["seeds"][1]["domains"]) == {d["domain"] for d in kept["domains"]}


def test_a_folder_that_holds_something_else_is_refused_before_the_first_step(
    file, tmp_path, monkeypatch, capsys
):
    from omnivat.training import training

    (tmp_path / "head").mkdir()
    (tmp_path / "head" / "thesis.txt").write_text("years of work")
    monkeypatch.setattr(training, "learn", None)  # any step would fail otherwise
    assert main(command(file, tmp_path / "head")) == 1
    assert "holds 'thesis.txt', which is not part of a head" in capsys.readouterr().err
    assert (tmp_path / "head" / "thesis.txt").read_text() == "years of work"


def test_the_search_for_an_order_is_kept_in_the_head_folder(file, tmp_path):
    more = ("--set", "order_search=true", "--set", "lang=false")
    assert main(command(file, tmp_path / "head", *more)) == 0
    search = load_head(tmp_path / "head").metrics["order_search"]
    assert len(search["orders"]) == len(search["score"]) == len(search["spread"])
    assert search["found"] == load_head(tmp_path / "head").model.order
