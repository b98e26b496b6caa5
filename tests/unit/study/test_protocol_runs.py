"""Runs: records, resuming, processes, and methods that cannot run."""

import json
from base64 import b64decode

import numpy as np
import pytest
from scipy.special import softmax

from omnivat.cli import main
from omnivat.data.packing import unpacked
from omnivat.data.store import load_embeddings, save_embeddings
from omnivat.encoders.lang.bank import DEFAULT_BANK, load_bank
from omnivat.kit.errors import MissingNameError
from omnivat.study.protocol import records
from omnivat.study.protocol.engine import planned, run_all
from omnivat.study.protocol.methods import Method, methods_named
from omnivat.study.protocol.run import Run, execute
from omnivat.study.reports.reading import by_run

QUICK = {"head": {"width": 16}, "train": {"epochs": 1}}
NAMES = ("omnivat", "nearest_mean")


@pytest.fixture(scope="module")
def file(make_embeddings, tmp_path_factory):
    path = tmp_path_factory.mktemp("protocol") / "set.safetensors"
    pairs = make_embeddings(domains=("TAG-sim", "OF Real-sim", "OF 2.0 A-sim"), split=True)
    save_embeddings(path, pairs)
    return path


@pytest.fixture(scope="module")
def runs():
    methods = methods_named(NAMES, QUICK["head"], QUICK["train"])
    return planned(methods, ("TAG", "OF Real"), (0, 1))


def done(file, runs, out, **changes):
    return run_all(runs, out, embeddings=file, bank=DEFAULT_BANK, **changes)


def without_times(lines):
    return sorted(
        (json.dumps({k: v for k, v in r.items() if k != "seconds"}) for r in lines), key=str
    )


def test_a_record_tells_what_was_resolved_and_every_target(file, runs, tmp_path):
    assert done(file, runs[:1], tmp_path / "runs.jsonl") == 1
    (record,) = records.read(tmp_path / "runs.jsonl")
    assert record["source"] == "TAG-sim"
    assert set(record["targets"]) == {"OF Real-sim", "OF 2.0 A-sim"}
    scores = record["targets"]["OF Real-sim"]["scores"]["fused"]
    measures = {"ece", "nll", "aurc"}
    assert set(scores) == {"accuracy", "macro_f1", "macro_f1_union"} | measures
    readings = {"fused", "vis", "tac", "vis_branch", "tac_branch"}
    assert set(record["targets"]["OF Real-sim"]["scores"]) == readings
    assert record["settings"]["head"]["width"] == 16
    assert record["settings"]["train"]["lr"] == 0.05
    assert record["versions"]["torch"] and record["versions"]["instructions"]
    assert record["data"]["simulated"] is True
    assert record["lang"]["hash"] == load_bank().hash
    accuracies = [t["scores"]["fused"]["accuracy"] for t in record["targets"].values()]
    assert by_run([record], "accuracy") == {("TAG-sim", 0): pytest.approx(sum(accuracies) / 2)}


def executed(name, pairs):
    (method,) = methods_named([name], QUICK["head"], QUICK["train"])
    return execute(Run(method=method, source="TAG", seed=0), pairs, load_bank())


def test_photo_only_in_a_record_is_the_method_given_the_photo_alone(file):
    """Other touches do not change "vis" but change "fused": no branch is used as "alone"."""
    pairs = load_embeddings(file)
    before = executed("omnivat", pairs)["targets"]["OF Real-sim"]
    pairs.tac[pairs.domain == 1] = pairs.tac[pairs.domain == 1][::-1] * 3
    after = executed("omnivat", pairs)["targets"]["OF Real-sim"]
    assert before["scores"]["vis"] == after["scores"]["vis"]
    assert before["margins"]["vis"] == after["margins"]["vis"]
    assert before["odds"] != after["odds"]


def test_the_first_seed_of_a_baseline_chooses_for_all_seeds_of_a_source(file, tmp_path):
    runs_ = planned(methods_named(["erm_mlp"], {}, {}), ("TAG",), (0, 1))
    assert done(file, runs_, tmp_path / "runs.jsonl") == 2
    first, second = records.read(tmp_path / "runs.jsonl")
    assert first["chosen"] == second["chosen"] and first["targets"] != second["targets"]


@pytest.mark.parametrize("name", ["omnivat", "nearest_mean"])
def test_figures_can_be_recomputed_from_the_predictions_in_the_record(file, name):
    for target in executed(name, load_embeddings(file))["targets"].values():
        assert len(unpacked(target["objects"])) == target["pairs"] == len(target["truth"])
        assert set(target["margins"]) == {"vis", "tac", "pair"}
        for reading, scores in target["scores"].items():
            right = [
                a == b for a, b in zip(target["answers"][reading], target["truth"], strict=True)
            ]
            assert np.mean(right) == pytest.approx(scores["accuracy"])
        truth = np.array([int(d) for d in target["truth"]])
        logs = np.frombuffer(b64decode(target["odds"]), "<f2").reshape(len(truth), -1)
        shares = softmax(np.pad(logs.astype(float), ((0, 0), (0, 1))), axis=1)
        nll = -np.log(shares)[np.arange(len(truth)), truth].mean()
        assert nll == pytest.approx(target["scores"]["fused"]["nll"], abs=2e-3)
        assert "".join(map(str, shares.argmax(1))) == target["answers"]["fused"]


def test_the_command_without_lang_runs_on_classes_that_no_bank_has(make_embeddings, tmp_path):
    pairs = make_embeddings(domains=("A", "B"), classes=("felt", "cork"), split=True)
    save_embeddings(tmp_path / "own.safetensors", pairs)
    given = ["--embeddings", str(tmp_path / "own.safetensors"), "--out", str(tmp_path / "out")]
    names = "omnivat,nearest_mean,baseline,zero_shot"
    asked = ["protocol", *given, "--methods", names, "--seeds", "0"]
    for lang in ("true", "false"):
        sets = ["--set", f"lang={lang}", "--set", "width=16", "--set", "epochs=1"]
        assert main([*asked, *sets]) == 0
    lines = records.read(tmp_path / "out" / "runs.jsonl")
    first, last = ({r["method"]: r for r in part} for part in (lines[:4], lines[4:]))
    assert "targets" in first["nearest_mean"]
    for name in ("omnivat", "zero_shot"):
        assert "no text for felt, cork" in first[name]["skipped"] and "targets" not in first[name]
    assert "targets" in last["omnivat"]
    assert last["zero_shot"]["skipped"].endswith("No LANG bank is used.")


def test_what_is_done_is_not_done_again_and_a_torn_line_is_mended(file, runs, tmp_path):
    out = tmp_path / "runs.jsonl"
    assert done(file, runs[:3], out) == 3
    assert done(file, runs, out) == len(runs) - 3
    whole = out.read_text()
    out.write_text(whole[:-40])  # stopped while the last line was written
    assert len(records.read(out)) == len(runs) - 1
    assert done(file, runs, out) == 1
    assert without_times(records.read(out)) == without_times(map(json.loads, whole.splitlines()))


def test_another_setting_another_seed_or_other_data_is_another_question(file, runs, tmp_path):
    out = tmp_path / "runs.jsonl"
    run = runs[0]
    done(file, [run], out)
    changed = Method(name="omnivat", head=QUICK["head"], train={"epochs": 1, "lr": 0.01})
    assert done(file, [Run(method=changed, source="TAG", seed=0)], out) == 1
    assert done(file, [Run(method=run.method, source="TAG", seed=7)], out) == 1
    pairs = load_embeddings(file)
    pairs.vis[0, 0] += 1
    save_embeddings(tmp_path / "other.safetensors", pairs)
    assert done(tmp_path / "other.safetensors", [run], out) == 1
    assert done(file, [run], out) == 0


@pytest.mark.slow
@pytest.mark.long
def test_processes_side_by_side_give_the_same_records(file, runs, tmp_path):
    done(file, runs, tmp_path / "one.jsonl")
    done(file, runs, tmp_path / "two.jsonl", jobs=2)
    one, two = (records.read(tmp_path / f"{name}.jsonl") for name in ("one", "two"))
    assert without_times(one) == without_times(two)


def test_an_unknown_method_is_refused_with_the_nearest():
    with pytest.raises(MissingNameError, match="Did you mean 'linear_maps'"):
        methods_named(["linear_map"], {}, {})
