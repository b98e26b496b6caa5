"""The command line: sentences instead of tracebacks, and results as promised."""

import json
import os
import re
from dataclasses import replace

import numpy as np
import pytest

from omnivat.cli import main, parser
from omnivat.data.store import save_embeddings


def test_a_misspelt_command_gets_the_nearest_one(run):
    said = run("trian", code=2).err
    assert "There is no command 'trian'. Did you mean 'train'?" in said


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["predict", "--fly"], "unrecognized arguments: --fly"),
        (["predict", "a", "b", "--order", "nan"], "order is nan; give a number of quarter turns"),
        (["gaps", "--order", "7"], "from -4 to 4. The transform has period 4, so use 3."),
        (["protocol", "--out", "x", "--seeds", ","], "','; give whole numbers such as 0,1,2"),
        (["train", "--repeat", "a"], "'a'; give whole numbers such as 0,1,2"),
        (["train", "--set", "width"], "'width'; write it as key=value"),
        (["sweep", "--csv", "c", "--stops", "1"], "'1'; give a whole number, 2 to 1001"),
        (["gaps", "--measure", "centrod"], "'centrod'; give one of centroid, mmd_linear,"),
        (["embed", "x", "--reader", "tacquadd"], "Did you mean 'tacquad'?"),
        (["sweep", "--orders", "1", "--stops", "3"], "not allowed with argument --orders"),
    ],
)
def test_an_argument_out_of_range_is_refused_with_the_range(arguments, sentence, capsys):
    with pytest.raises(SystemExit) as stop:
        main(arguments)
    assert stop.value.code == 2
    assert sentence in " ".join(capsys.readouterr().err.split())


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["predict"], "Got 0 images; give VIS and TAC for each pair"),
        (["predict", "one.png"], "Got 1 image; give VIS and TAC"),
        (["predict", "a", "b", "--pairs", "c"], "Give either images or --pairs, not both"),
        (["prompts", "--out", "x", "--method", "promptstyler"], "add --encoder clip-vit-b16"),
        (["predict", "a", "b", "--head", "nowhere"], "No head at 'nowhere'. Train one with"),
        (["train", "--embeddings", "none", "--source", "x", "--out", "y"], "No embeddings file at"),
        (["embed", "nowhere", "--out", "x.safetensors"], "There is no folder or file at 'nowhere'"),
    ],
)
def test_what_a_person_can_put_right_is_one_sentence_and_exit_1(
    arguments, sentence, run, tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    said = run(*arguments, code=1).err
    assert sentence in said and said.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


def test_a_file_in_the_place_of_an_output_folder_is_refused_before_any_work(
    run, tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    os.mkfifo(tmp_path / "file")
    said = run("protocol", "--out", "file", "--methods", "nearest_mean", code=1).err
    assert f"'{tmp_path / 'file'}' is a file; choose a folder." in said
    assert [path.name for path in tmp_path.iterdir()] == ["file"]


@pytest.mark.parametrize(
    ("changed", "sentence"),
    [
        ("--set widht=16", "There is no setting 'widht'. Did you mean 'width'?"),
        ("--set levels=9", "levels is 9; choose 1 to 6."),
        ("--set fusion=meen", "feature. Did you mean 'mean'?"),
        ("--source TAGG", "there are TAG-sim, OF Real-sim"),
    ],
)
def test_a_wrong_setting_is_refused_before_anything_is_written(
    changed, sentence, head_folder, tmp_path, run
):
    known = "--embeddings", head_folder.parent / "set.safetensors", "--source", "TAG-sim"
    out = tmp_path / "head"
    said = run("train", *known, "--out", out, *changed.split(), code=1).err
    assert sentence in said and not out.exists()


def test_evaluate_prints_and_draws_every_domain(head_folder, tmp_path, run):
    known = "--head", head_folder, "--embeddings", head_folder.parent / "set.safetensors"
    said = run("evaluate", *known, "--figure", tmp_path / "f.svg").out
    assert "TAG-sim (source)" in said and "mean of targets" in said and "balanced" not in said
    assert "measured on the head's training pairs" in said
    assert "OF Real-sim" in (tmp_path / "f.svg").read_text()


def test_evaluate_gives_the_mean_over_classes_and_the_largest_class_where_classes_are_uneven(
    head_folder, make_embeddings, tmp_path, run
):
    full, file = make_embeddings(split=True), tmp_path / "set.safetensors"
    kept = (full.label == 0) | (np.arange(len(full)) % 6 == 0)
    save_embeddings(file, full.select(np.flatnonzero(kept)))
    known = "evaluate", "--head", head_folder, "--embeddings", file
    said = run(*known).out
    assert "the head's training pairs" not in said  # they are stated, and left out
    _, *lines = said.splitlines()
    for line, record in zip(lines, json.loads(run(*known, "--json").out)["domains"], strict=False):
        counts = np.array(record["confusion"], float)
        there = counts.sum(1)
        balanced = (np.diag(counts)[there > 0] / there[there > 0]).mean()
        shares = balanced, there.max() / there.sum()
        assert line.split()[-2:] == [f"{100 * share:.1f}" for share in shares]


def test_a_head_refuses_embeddings_of_another_encoder(head_folder, make_embeddings, tmp_path, run):
    other, file = make_embeddings(), tmp_path / "other.safetensors"
    save_embeddings(file, replace(other, header=replace(other.header, encoder="clip-vit-b16")))
    said = run("evaluate", "--head", head_folder, "--embeddings", file, code=1).err
    assert "clip-vit-b16" in said and "test-encoder" in said


def test_the_parser_knows_its_version(capsys):
    with pytest.raises(SystemExit):
        parser().parse_args(["--version"])
    assert capsys.readouterr().out.startswith("omnivat ")


def test_a_link_to_itself_is_refused_in_a_sentence(tmp_path, run):
    (tmp_path / "loop").symlink_to("loop")
    said = run("embed", tmp_path / "loop", "--out", tmp_path / "q.safetensors", code=1).err
    assert re.search(r"^omnivat embed: .*\.$", said.strip())


def test_a_file_that_takes_more_memory_than_there_is_ends_in_a_sentence(tmp_path, run):
    out = tmp_path / "set.safetensors"

    def full(*_, **__):
        raise MemoryError

    with pytest.MonkeyPatch.context() as patched:
        patched.setattr("omnivat.data.foreign.import_embeddings", full)
        said = run("import", "large.npz", "--encoder", "e", "--out", out, code=1).err
    assert said.endswith("take more memory than there is; give smaller ones.\n")
    assert not out.exists()


def test_no_command_prints_the_help(run):
    assert "predict" in run().out
