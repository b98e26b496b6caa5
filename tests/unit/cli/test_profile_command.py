"""`omnivat profile`, and the commands that take a profile."""

import json
import shutil

import numpy as np
import pytest

from omnivat.data.profile import profile_of
from omnivat.data.profile_file import load_profile, save_profile
from omnivat.data.store import load_embeddings, save_embeddings
from omnivat.head.checkpoint import load_head
from omnivat.measure.known import measured
from omnivat.measure.rungs import labels, pairs


@pytest.fixture(scope="module")
def two(make_embeddings, tmp_path_factory):
    """A set of the head's encoder with three domains and a split, and a profile of one."""
    folder = tmp_path_factory.mktemp("profiles")
    three = make_embeddings(domains=("TAG-sim", "OF Real-sim", "TQ-DIGIT-sim"), split=True)
    save_embeddings(folder / "set.safetensors", three)
    profile = profile_of(three, three.rows_of("OF Real-sim", split="train"), domain="OF Real-sim")
    save_profile(folder / "p.safetensors", profile)
    return folder


@pytest.fixture
def evaluated(run, head_folder):
    """Return a function of a set's folder and more options: the printed record."""

    def of(folder, *more):
        known = "--head", head_folder, "--embeddings", folder / "set.safetensors", "--json"
        return json.loads(run("evaluate", *known, *more).out)

    return of


@pytest.mark.parametrize(("option", "known"), [("--unlabelled", pairs), ("--labels", labels)])
def test_it_prints_what_is_measured_with_its_draws_and_its_seed(
    option, known, evaluated, two, head_folder
):
    some = evaluated(two, option, 3, "--draws", 2, "--seed", 4)
    head, embeddings = load_head(head_folder), load_embeddings(two / "set.safetensors")
    wanted = measured(head, embeddings, known(3), draws=2, seed=4)
    assert some == wanted and len(wanted["domains"][1]["draws"]) == 2


def test_a_profile_file_serves_the_domain_that_it_names(evaluated, two):
    plain, some = (
        {one["domain"]: one for one in evaluated(two, *more)["domains"]}
        for more in ((), ("--profile", two / "p.safetensors"))
    )
    assert some["OF Real-sim"]["known_pairs"] == 20
    assert some["TQ-DIGIT-sim"] == plain["TQ-DIGIT-sim"]


def test_the_table_says_what_was_known(run, two, head_folder):
    known = "--head", head_folder, "--embeddings", two / "set.safetensors", "--unlabelled", 5
    said = run("evaluate", *known, "--draws", 2).out
    assert "5 pictures without labels" in said and "Mean of 2 draws" in said
    taught = run("evaluate", *known[:-2], "--labels", 2, "--draws", 2).out
    assert "10 labelled pairs" in taught
    both = run("evaluate", *known, "--labels", 2, code=1).err
    assert "Give one of --profile, --unlabelled and --labels" in both


def test_features_follow_the_profile(run, two, head_folder):
    known = "gaps", "--embeddings", two / "set.safetensors", "--head", head_folder, "--json"
    assert run(*known).out != run(*known, "--profile", two / "p.safetensors").out


def test_a_head_without_its_sources_profile_is_named(run, tmp_path, two, head_folder):
    shutil.copytree(head_folder, tmp_path / "head")
    (tmp_path / "head" / "profile.safetensors").unlink()
    known = "--head", tmp_path / "head", "--embeddings", two / "set.safetensors"
    assert "has no profile of its source" in run("evaluate", *known, "--unlabelled", 2, code=1).err


def test_a_set_gives_the_profile_of_one_domain(run, tmp_path, two):
    words = "profile", two / "set.safetensors", "--out", tmp_path / "q.safetensors"
    assert "has 3 domains; name one" in run(*words, code=1).err
    run(*words, "--domain", "TAG-sim")
    three = load_embeddings(two / "set.safetensors")
    wanted = profile_of(three, three.rows_of("TAG-sim")).channels["tac"].mean
    found = load_profile(tmp_path / "q.safetensors").channels["tac"].mean
    np.testing.assert_allclose(found, wanted, rtol=1e-6)


def test_pictures_are_profiled_without_labels_and_a_broken_one_is_named(run, tmp_path, paint):
    for k in range(3):
        paint(tmp_path / "new" / f"press{k}_tac.png")
        paint(tmp_path / "new" / "vis" / f"{k}.png")
    (tmp_path / "new" / "broken_tac.png").write_bytes(b"no picture")
    out = tmp_path / "p.safetensors"
    said = run("profile", tmp_path / "new", "--out", out, "--domain", "my DIGIT")
    assert "3 photos and 3 tactile images, no labels read" in said.out
    assert "skipped" in said.err and "broken_tac.png" in said.err
    assert load_profile(out).counts == {"vis": 3, "tac": 3}


def test_a_folder_of_touches_alone_makes_a_profile_of_touch(run, tmp_path, paint):
    paint(tmp_path / "presses" / "a.png")
    out = tmp_path / "p.safetensors"
    run("profile", "--tac", tmp_path / "presses", "--out", out)
    assert load_profile(out).counts == {"tac": 1}


def test_a_folder_without_pictures_ends_in_one_sentence(run, tmp_path):
    (tmp_path / "empty").mkdir()
    out = tmp_path / "p.safetensors"
    said = run("profile", tmp_path / "empty", "--out", out, code=1).err
    assert "Name them *_vis.png and *_tac.png" in said and not out.exists()
