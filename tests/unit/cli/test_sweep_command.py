"""`omnivat sweep`: every measure as a function of p, in files with named columns."""

import csv
import json

import pytest

from omnivat.cli import main
from omnivat.cli.sweep import orders_of
from omnivat.data.store import load_embeddings
from omnivat.head.checkpoint import load_head
from omnivat.kit.errors import SettingsError
from omnivat.maps.frames import read_frames
from omnivat.maps.sweep import STAGES, sweep
from omnivat.measure.gaps import GAPS
from omnivat.measure.gaps.measures import PREDICTION_MEASURES, STAGE_MEASURES


def command(head_folder, *more):
    embeddings = str(head_folder.parent / "set.safetensors")
    return ["sweep", "--head", str(head_folder), "--embeddings", embeddings, *map(str, more)]


def columns(path):
    with path.open(newline="", encoding="utf-8") as handle:
        rows = list(csv.reader(handle))
    return {name: values for name, *values in zip(*rows, strict=True)}


def test_every_measure_at_every_stage_is_a_named_column_of_the_table(head_folder, tmp_path):
    out = tmp_path / "curves.csv"
    every = ("--stages", "all", "--measures", "all", "--orders", "0,0.3,1")
    assert main(command(head_folder, "--csv", out, *every)) == 0
    found = columns(out)
    assert [float(order) for order in found.pop("order")] == [0, 0.3, 1]
    assert set(GAPS) - {"centroid"} < set(STAGE_MEASURES)  # its two ways have names of their own
    for measure in STAGE_MEASURES:
        assert {f"{measure}/{stage}" for stage in STAGES} <= set(found)
    for measure in set(PREDICTION_MEASURES) - {"confusion"}:
        assert {f"{measure}/all", f"{measure}/TAG-sim", f"{measure}/OF Real-sim"} <= set(found)
    assert {"margin:cross_domain/f_hat", "margin:cross_modal/f_bar"} <= set(found)
    assert "confusion/wood>steel" in found
    assert all(all(float(value) == float(value) for value in values) for values in found.values())


def test_the_files_hold_what_the_library_answers(head_folder, tmp_path):
    asked = ("--stages", "f_hat", "--measures", "mmd_rbf,ece", "--orders", "0,0.5")
    files = ("--json", tmp_path / "c.json", "--csv", tmp_path / "c.csv")
    assert main(command(head_folder, *asked, *files)) == 0
    wanted = sweep(
        load_head(head_folder).model,
        load_embeddings(head_folder.parent / "set.safetensors"),
        [0.0, 0.5],
        stages=("f_hat",),
        measures=("mmd_rbf", "ece"),
    ).curves
    written = json.loads((tmp_path / "c.json").read_text(encoding="utf-8"))
    table = columns(tmp_path / "c.csv")
    assert written["orders"] == [0, 0.5] and written["head"]["source"] == "TAG-sim"
    assert set(written["curves"]) == set(table) - {"order"} == set(wanted)
    for name, values in wanted.items():
        assert written["curves"][name] == pytest.approx(values.tolist())
        assert [float(text) for text in table[name]] == pytest.approx(values.tolist())


def test_a_value_that_does_not_exist_is_null_and_an_empty_cell(
    head_folder, make_embeddings, tmp_path
):
    from omnivat.data.store import save_embeddings

    one_domain = tmp_path / "one.safetensors"
    save_embeddings(one_domain, make_embeddings(domains=("TAG-sim",)))
    files = ("--json", tmp_path / "c.json", "--csv", tmp_path / "c.csv")
    asked = ["--embeddings", str(one_domain), "--measures", "domain_gap", "--stages", "raw"]
    assert main([*command(head_folder, *files), *asked, "--stops", "2"]) == 0
    written = json.loads((tmp_path / "c.json").read_text(encoding="utf-8"))
    assert written["curves"]["domain_gap/raw"] == [None, None]
    assert columns(tmp_path / "c.csv")["domain_gap/raw"] == ["", ""]


def test_frames_are_made_for_the_orders_stages_and_measures_asked_for(head_folder, tmp_path, run):
    out = tmp_path / "frames.bin"
    asked = ("--orders", "0,0.5,2.5", "--stages", "raw,relu", "--measures", "margin")
    said = run(*command(head_folder, "--out", out, *asked)).out
    frames = read_frames(out)
    assert frames.orders == (0, 0.5, 2.5)
    assert {name.split("/")[1] for name in frames.maps} == {"raw", "relu"}
    assert {name.split("/")[0].split(":")[0] for name in frames.curves} == {"margin"}
    assert "p = 2.5" in said and "margin:cross_modal/relu" in said and str(out) in said


@pytest.mark.parametrize(
    ("asked", "sentence"),
    [
        ((), "There is no output; give --out, --json, --csv or --figure."),
        (("--csv", "c", "--json", "./c"), "--csv and --figure name the same file; give each its"),
        (("--csv", "c", "--stages", "f_hut"), "Did you mean 'f_hat'?"),
        (("--csv", "c", "--measures", "mmd"), "No measure is called 'mmd'"),
        (("--csv", "c", "--orders", "0,x"), "--orders is '0,x'; write numbers"),
        (("--csv", "c", "--orders", "1,0"), "each above the last"),
        (("--csv", "c", "--seeds", "1"), "--seeds applies to --retrained N only"),
        (("--csv", "c", "--retrained", "3"), "--retrained needs --out"),
    ],
)
def test_what_cannot_be_swept_is_one_sentence_and_no_file(
    asked, sentence, head_folder, tmp_path, monkeypatch, run
):
    monkeypatch.chdir(tmp_path)
    said = run(*command(head_folder, *asked), code=1).err
    assert sentence in said and said.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


def test_orders_are_those_listed_or_stops_from_0_to_1_and_no_more_than_stated(monkeypatch):
    monkeypatch.setattr("omnivat.cli.sweep.MOST_STOPS", 2)
    assert orders_of(None, 3) == [0, 0.5, 1] and orders_of("0,1", 101) == [0, 1]
    with pytest.raises(SettingsError, match="write 1 to 2 numbers"):
        orders_of("0,1,2", 101)
