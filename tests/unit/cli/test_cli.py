"""The command line: sentences instead of tracebacks, and results as promised."""

import json
import os
import re

import pytest

from omnivat.cli import COMMANDS, main, parser


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_explains_itself(command, capsys):
    with pytest.raises(SystemExit) as stop:
        main([command, "--help"])
    assert stop.value.code == 0
    assert len(capsys.readouterr().out) > 200


def test_wrong_usage_exits_with_2():
    with pytest.raises(SystemExit) as stop:
        main(["predict", "--fly"])
    assert stop.value.code == 2


def test_no_command_prints_the_help(capsys):
    assert main([]) == 0
    assert "predict" in capsys.readouterr().out


def test_a_misspelt_command_gets_the_nearest_one(capsys):
    assert main(["trian"]) == 2
    assert "There is no command 'trian'. Did you mean 'train'?" in capsys.readouterr().err


@pytest.mark.parametrize("command", COMMANDS)
def test_every_argument_has_a_help_text(command):
    options = parser()._subparsers._group_actions[0].choices[command]._actions
    assert [action.dest for action in options if not action.help] == []


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["predict", "a", "b", "--order", "nan"], "order is nan; give a number of quarter turns"),
        (["gaps", "--order", "7"], "from -4 to 4. The transform has period 4, so use 3."),
        (["simulate", "--out", "x", "--workers", "-1"], "-1; give a whole number, 1 or more"),
        (["simulate", "--out", "x", "--examples-per-class", "0"], "0; give a whole number, 1 or"),
        (["protocol", "--out", "x", "--jobs", "two"], "'two'; give a whole number, 1 or more"),
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
        (["predict", "a", "b", "--head", "nowhere"], "No head at 'nowhere'. Train one with"),
        (["evaluate", "--head", "nowhere"], "No head at 'nowhere'"),
        (["train", "--embeddings", "none", "--source", "x", "--out", "y"], "No embeddings file at"),
        (["embed", "nowhere", "--out", "x.safetensors"], "There is no folder or file at 'nowhere'"),
    ],
)
def test_what_a_person_can_put_right_is_one_sentence_and_exit_1(
    arguments, sentence, capsys, tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    assert main(arguments) == 1
    captured = capsys.readouterr()
    assert sentence in captured.err
    assert "Traceback" not in captured.err
    assert captured.err.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    "arguments",
    [
        ["protocol", "--out", "file", "--methods", "nearest_mean"],
        ["ablate", "--out", "file", "--only", "order"],
        ["simulate", "--set", "chirps", "--out", "new", "--examples", "file"],
    ],
    ids=lambda arguments: arguments[0],
)
def test_a_file_in_the_place_of_an_output_folder_is_refused_before_any_work(
    arguments, capsys, tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "file").write_text("mine")
    assert main(arguments) == 1
    assert f"'{tmp_path / 'file'}' is a file; choose a folder." in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["file"]


@pytest.mark.parametrize(
    ("texts", "sentence"),
    [
        (["widht=16"], "There is no setting 'widht'. Did you mean 'width'?"),
        (["width"], "--set got 'width'; write it as key=value."),
        (["width=wide"], "Setting 'width' is 'wide'; it must be int."),
        (["levels=9"], "levels is 9; choose 1 to 6."),
        (["selection=target"], "selection is 'target'; choose one of last, source-val."),
    ],
)
def test_a_wrong_setting_is_refused_before_anything_is_written(
    texts, sentence, head_folder, tmp_path, capsys
):
    embeddings = head_folder.parent / "set.safetensors"
    settings = [part for text in texts for part in ("--set", text)]
    out = tmp_path / "head"
    code = main(
        [
            "train",
            "--embeddings",
            str(embeddings),
            "--source",
            "TAG-sim",
            "--out",
            str(out),
            *settings,
        ]
    )
    assert code == 1
    assert sentence in capsys.readouterr().err
    assert not out.exists()


def test_an_unknown_source_lists_the_domains_there_are(head_folder, tmp_path, capsys):
    embeddings = head_folder.parent / "set.safetensors"
    code = main(
        ["train", "--embeddings", str(embeddings), "--source", "TAGG", "--out", str(tmp_path / "h")]
    )
    assert code == 1
    assert "there are TAG-sim, OF Real-sim" in capsys.readouterr().err


def test_evaluate_prints_every_domain_and_json_for_programs(head_folder, capsys):
    embeddings = str(head_folder.parent / "set.safetensors")
    assert main(["evaluate", "--head", str(head_folder), "--embeddings", embeddings]) == 0
    text = capsys.readouterr().out
    assert "TAG-sim (source)" in text and "OF Real-sim" in text and "mean of targets" in text
    assert main(["evaluate", "--head", str(head_folder), "--embeddings", embeddings, "--json"]) == 0
    records = json.loads(capsys.readouterr().out)
    assert [record["domain"] for record in records] == ["TAG-sim", "OF Real-sim"]
    assert all(0 <= r["scores"]["fused"]["accuracy"] <= 1 for r in records)


@pytest.mark.parametrize("stated", [True, False])
def test_evaluate_says_so_where_the_source_was_trained_on(
    stated, head_folder, make_embeddings, tmp_path, capsys
):
    from dataclasses import replace

    from omnivat.data.store import save_embeddings

    made = make_embeddings()
    splits = ["train" if stated and n % 2 else "test" if stated else "" for n in range(len(made))]
    save_embeddings(
        tmp_path / "set.safetensors", replace(made, rows={**made.rows, "split": splits})
    )
    given = ["--head", str(head_folder), "--embeddings", str(tmp_path / "set.safetensors")]
    assert main(["evaluate", *given]) == 0
    assert ("measured on the head's training pairs" in capsys.readouterr().out) is not stated


def test_a_head_refuses_embeddings_of_another_encoder(
    head_folder, make_embeddings, tmp_path, capsys
):
    from dataclasses import replace

    from omnivat.data.store import save_embeddings

    other = make_embeddings()
    other = replace(other, header=replace(other.header, encoder="clip-vit-b16"))
    save_embeddings(tmp_path / "other.safetensors", other)
    code = main(
        [
            "evaluate",
            "--head",
            str(head_folder),
            "--embeddings",
            str(tmp_path / "other.safetensors"),
        ]
    )
    assert code == 1
    error = capsys.readouterr().err
    assert "clip-vit-b16" in error and "test-encoder" in error


def test_the_parser_knows_its_version(capsys):
    with pytest.raises(SystemExit):
        parser().parse_args(["--version"])
    assert capsys.readouterr().out.startswith("omnivat ")


@pytest.mark.parametrize(
    "words", ["embed loop --out q.safetensors", "sweep --csv loop --json loop"]
)
def test_a_link_to_itself_is_refused_in_a_sentence(words, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "loop").symlink_to("loop")
    assert main(words.split()) == 1
    assert re.search(r"omnivat (embed|sweep): .*\.$", capsys.readouterr().err.strip())


def test_simulate_refuses_a_file_in_place_of_its_folder_at_once(tmp_path, capsys):
    os.mkfifo(tmp_path / "pipe")
    assert main(["simulate", "--out", str(tmp_path / "pipe"), "--workers", "1"]) == 1
    assert "is a file; choose a folder." in capsys.readouterr().err
