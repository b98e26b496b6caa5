"""`omnivat try`: from pairs of any kind to a folder, figures and the page."""

import json
from dataclasses import replace
from unittest.mock import MagicMock

import numpy as np
import pytest

from app.serving.server import parser
from omnivat.cli import try_pairs
from omnivat.data.profile_file import load_profile
from omnivat.data.store import load_embeddings, save_embeddings
from omnivat.head import linear_maps
from omnivat.head.checkpoint import load_head
from omnivat.measure.readers import Reader
from omnivat.measure.shares import wilson
from omnivat.study import advice, trial
from omnivat.study.shift import read_features
from omnivat.study.shift.reading import features_of


@pytest.fixture(autouse=True)
def short(monkeypatch):
    monkeypatch.setattr(trial, "EPOCHS", 2)
    monkeypatch.setattr(linear_maps, "PLAIN_STEPS", 30)


@pytest.fixture
def tried(run):
    return lambda place: run("try", place, "--no-page").out


def vectors(file, count=24, **columns):
    random = np.random.default_rng(0)
    labels = np.arange(count) % 3
    rows = random.normal(size=(3, 16))[labels] + 0.1 * random.normal(size=(count, 16))
    np.savez(
        file, **{"vis": rows, "tac": rows + 1, "material": np.array(list("abc"))[labels]} | columns
    )
    return file


def test_features_of_two_domains_become_a_folder_with_head_profiles_and_figures(
    make_embeddings, tmp_path, tried
):
    save_embeddings(tmp_path / "mine.safetensors", make_embeddings(split=True))
    said = tried(tmp_path / "mine.safetensors")
    out = tmp_path / "mine-try"
    head, data = load_head(out / "head"), load_embeddings(out / "set.safetensors")
    assert (head.settings.width, head.source, set(data.rows["split"])) == (64, "TAG-sim", {""})
    assert head.provenance["train"]["noise"] == 4 and head.provenance["train"]["shift"] == 1
    home, away = json.loads((out / "figures.json").read_text())
    assert (home["domain"], home["pairs"], home["objects"]) == ("TAG-sim", 40, 20)
    assert (away["domain"], away["profile"]["pictures"]) == ("OF Real-sim", 20)
    assert {p.channels["vis"].count for p in map(load_profile, (out / "profiles").iterdir())} == {
        40
    }
    assert "of which nothing was known" in said and "split is not used" in said
    assert all(line in said for line in (out / "summary.txt").read_text().splitlines())


def test_no_head_sees_an_object_that_it_is_tested_on(make_embeddings, tmp_path, monkeypatch):
    save_embeddings(tmp_path / "mine.safetensors", make_embeddings())
    found = read_features(tmp_path / "mine.safetensors")
    learned, tested = [], []
    trained, answers = trial.trained_head, Reader.answers

    def training(plan, *, calibrate=True, **more):
        if not calibrate:  # the head of a fold
            learned.append(set(plan.pairs.rows["object"]))
        return trained(plan, calibrate=calibrate, **more)

    def answering(reader, data, rows, classes):
        tested.append({data.rows["object"][row] for row in rows})
        return answers(reader, data, rows, classes)

    monkeypatch.setattr(trial, "trained_head", training)
    monkeypatch.setattr(Reader, "answers", answering)
    trial.try_pairs(found)
    folds = list(zip(learned, tested[::2], strict=False))
    assert len(folds) == 5 and tested[:10:2] == tested[1:10:2]  # of the head, of linear maps
    assert all(not a & b for a, b in folds)
    assert set().union(*(b for _, b in folds)) == {
        name for name in found.embeddings.rows["object"] if name.startswith("TAG-sim")
    }


def test_both_figures_of_a_target_count_objects_and_both_readers_have_a_profile(make_embeddings):
    data = make_embeddings()
    names = [f"{domain}/{k // 4}" for k, domain in enumerate(data.domain)]
    found = features_of(replace(data, rows=data.rows | {"object": names}))
    away = trial.try_pairs(found, seed=3).records[-1]
    assert (away["pairs"], away["objects"], away["profile"]["pictures"]) == (40, 10, 20)
    for share, one in (
        (away["both"]["share"], away["both"]),
        (away["profile"]["accuracy"], away["profile"]),
        (away["profile"][advice.PROBE]["share"], away["profile"][advice.PROBE]),
    ):
        assert (one["low"], one["high"]) == pytest.approx(wilson(share * 10, 10), abs=0.02)


def reading(share):
    return {"share": share, "low": share - 0.1, "high": share + 0.1}


def figures(head, maps, photo=0.4, domain="TAG", always=0.2):
    names = {"both": (head, maps), "vis": (photo, 0.3), "tac": (0.3, 0.3)}
    shares = {k: v for n, (a, b) in names.items() for k, v in ((n, a), (advice.probe_of(n), b))}
    known = {"domain": domain, "pairs": 50, "objects": 10, "always the largest class": always}
    known |= {"uneven": always > 0.5, "balanced": {"both": 0.5}}
    return known | {name: reading(share) for name, share in shares.items()}


@pytest.mark.parametrize(
    ("head", "maps", "always", "words"),
    [
        (0.8, 0.5, 0.2, "take the head."),
        (0.5, 0.8, 0.2, "take the linear maps."),
        (0.5, 0.52, 0.2, "level"),
        (0.9, 0.84, 0.85, "neither is above always naming the largest class (85 %)"),
        (0.84, 0.99, 0.85, "take the linear maps: alone above"),
    ],
)
def test_the_last_sentence_tells_what_to_take_and_nothing_not_above_the_largest_class(
    head, maps, always, words
):
    away = figures(head, maps, domain="DIGIT", always=always)
    said = advice.conclusion([figures(0.9, 0.1), away], "TAG")
    assert said.startswith("In short: on another sensor") and words in said


def test_one_image_that_beats_both_is_remarked():
    assert "Photo only beats both images" in advice.sentence(figures(0.5, 0.5, photo=0.65))
    assert "beats" not in advice.sentence(figures(0.5, 0.5, photo=0.55)), "within the interval"


def test_balanced_accuracy_stands_beside_accuracy_where_classes_are_uneven(
    make_embeddings, tmp_path, tried
):
    data = make_embeddings()
    rare = np.where(np.arange(len(data)) % 10, 0, 1)  # nine of ten pairs are of one class
    random = np.random.default_rng(0)
    noise = {name: random.normal(size=data.vis.shape).astype(np.float32) for name in ("vis", "tac")}
    data = replace(data, label=rare, vis_flip=None, tac_flip=None, **noise)
    save_embeddings(tmp_path / "mine.safetensors", data)
    said = tried(tmp_path / "mine.safetensors")
    home, away = json.loads((tmp_path / "mine-try" / "figures.json").read_text())
    assert home["uneven"] and away["uneven"] and away["always the largest class"] == 0.9
    assert abs(away["balanced"]["both"] - 0.5) < 0.2 < away["both"]["share"]
    assert said.count("balanced over classes") == 2
    assert "neither is above always naming the largest class (90 %)" in said


def test_one_domain_says_what_is_not_known(tmp_path, tried):
    said = tried(vectors(tmp_path / "one.npz"))
    assert "In short: on objects that it did not see" in said
    assert "another sensor is not known" in said and "each pair counts as an object" in said


def test_two_pairs_give_a_head_and_no_figure(tmp_path, tried):
    said = tried(vectors(tmp_path / "two.npz", 2))
    assert "no honest figure" in said
    assert json.loads((tmp_path / "two-try" / "figures.json").read_text()) == []


def test_a_class_of_one_object_is_named_and_not_tested(tmp_path, tried):
    objects = np.array([f"o{k}" if k % 3 else "same" for k in range(24)])
    said = tried(vectors(tmp_path / "x.npz", object=objects))
    assert "1 class has one object only" in said
    (home,) = json.loads((tmp_path / "x-try" / "figures.json").read_text())
    assert (home["pairs"], home["classes"]) == (16, 2)


@pytest.fixture
def opened(run, monkeypatch):
    """Return a function that tries pairs, and returns what is said and what the page opens on."""
    started = []
    monkeypatch.setattr(
        try_pairs.subprocess, "Popen", lambda command: started.append(command) or MagicMock()
    )

    def of(*words):
        said = run("try", *words).out
        chosen = parser({}).parse_args(started.pop()[3:])
        return said, chosen.head, chosen.embeddings

    return of


def test_without_classes_there_is_no_head_and_the_page_opens_on_the_features(tmp_path, opened):
    rows = np.random.default_rng(0).normal(size=(6, 16))
    np.savez(tmp_path / "bare.npz", vis=rows, tac=rows + 1)
    said, head, embeddings = opened(tmp_path / "bare.npz")
    assert "No head was trained" in said and "omnivat report" in said
    assert not (tmp_path / "bare-try" / "head").exists() and head is None
    assert embeddings == tmp_path / "bare-try" / "set.safetensors"


def test_the_page_opens_on_the_new_head_and_set(tmp_path, opened):
    out = tmp_path / "out"
    _, *places = opened(vectors(tmp_path / "x.npz"), "--out", out)
    assert places == [out / "head", out / "set.safetensors"]


def test_pairs_without_a_class_among_others_are_neither_learned_nor_tested(
    make_embeddings, without_classes, tmp_path, tried
):
    save_embeddings(tmp_path / "mine.safetensors", without_classes(make_embeddings(), 2))
    said = tried(tmp_path / "mine.safetensors")
    assert (
        "24 pairs, 3 classes (16 pairs without a class left out)" in said and "with texts" in said
    )
    assert load_head(tmp_path / "mine-try" / "head").settings.classes == (
        "wood",
        "steel",
        "plastic",
    )
    home, away = json.loads((tmp_path / "mine-try" / "figures.json").read_text())
    assert (home["pairs"], home["classes"], away["pairs"]) == (24, 3, 24)


def test_touches_may_have_an_encoder_and_a_layer_of_their_own(tmp_path, run, paint):
    for name in ("0_vis", "0_tac", "1_vis", "1_tac"):
        paint(tmp_path / "mine" / f"bench/wood/{name}.png")
    own = ["--encoder", "strip", "--tac-encoder", "efficientnet-lite0", "--layer", "2"]
    run("try", tmp_path / "mine", "--no-page", *own)
    made = load_embeddings(tmp_path / "mine-try" / "set.safetensors")
    assert made.header.encoder == "strip | efficientnet-lite0#2"
    said = run("try", tmp_path / "mine", "--tac-weights", "x.pt", code=1).err
    assert "--tac-weights needs --tac-encoder" in said


@pytest.mark.parametrize(
    ("name", "words"), [("none.npz", "no folder or file"), ("x.txt", "ends in '.txt'")]
)
def test_what_cannot_be_read_ends_in_one_sentence(tmp_path, run, name, words):
    (tmp_path / "x.txt").write_text("x")
    assert words in run("try", tmp_path / name, "--no-page", code=1).err


def test_a_source_of_one_class_is_refused(tmp_path, run):
    file = vectors(tmp_path / "x.npz")
    said = run("try", file, "--no-page", "--source", "mini", code=1).err
    assert "needs pairs of two classes" in said
