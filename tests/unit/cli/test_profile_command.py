"""`omnivat profile`, and the commands that take a profile."""

import json
import shutil

import numpy as np
import pytest
from PIL import Image

from omnivat.cli import main
from omnivat.data.profile import drawn_profiles, load_profile, profile_of, save_profile
from omnivat.data.store import load_embeddings, save_embeddings


@pytest.fixture(scope="module")
def two(make_embeddings, head_folder, tmp_path_factory):
    """A set of the head's encoder with three domains and a split, and a profile of one."""
    folder = tmp_path_factory.mktemp("profiles")
    pairs = make_embeddings(domains=("TAG-sim", "OF Real-sim", "TQ-DIGIT-sim"), split=True)
    save_embeddings(folder / "set.safetensors", pairs)
    profile = profile_of(pairs, pairs.rows_of("OF Real-sim", split="train"), domain="OF Real-sim")
    save_profile(folder / "p.safetensors", profile)
    return folder


def evaluated(capsys, folder, head, *more):
    code = main(
        [
            "evaluate",
            "--head",
            str(head),
            "--embeddings",
            str(folder / "set.safetensors"),
            "--json",
            *list(more),
        ]
    )
    out = capsys.readouterr()
    assert code == 0, out.err
    return {r["domain"]: r for r in json.loads(out.out)}


def test_no_unlabelled_pair_predicts_as_without_the_argument(capsys, two, head_folder):
    plain = evaluated(capsys, two, head_folder)
    none = evaluated(capsys, two, head_folder, "--unlabelled", "0")
    assert plain == none and {r["unlabelled"] for r in none.values()} == {0}


def test_unlabelled_pairs_are_counted_and_the_source_stays(capsys, two, head_folder):
    plain = evaluated(capsys, two, head_folder)
    some = evaluated(capsys, two, head_folder, "--unlabelled", "5", "--seed", "1")
    assert [some[d]["unlabelled"] for d in some] == [0, 5, 5]
    assert some["TAG-sim"] == plain["TAG-sim"]
    assert some["OF Real-sim"]["pairs"] == plain["OF Real-sim"]["pairs"]  # test objects


def test_the_scores_of_unlabelled_pairs_are_means_over_draws(capsys, monkeypatch, two, head_folder):
    seeds = []

    def drawn(*arguments, seed):
        seeds.append(seed)
        return drawn_profiles(*arguments, seed=seed)

    monkeypatch.setattr("omnivat.measure.known.drawn_profiles", drawn)
    some = evaluated(capsys, two, head_folder, "--unlabelled", "3", "--draws", "2", "--seed", "4")
    single = [
        evaluated(capsys, two, head_folder, "--unlabelled", "3", "--draws", "1", "--seed", seed)
        for seed in ("4", "5")
    ]
    assert seeds == [4, 5, 4, 5]
    for domain in ("OF Real-sim", "TQ-DIGIT-sim"):
        each = [one[domain]["scores"]["fused"]["accuracy"] for one in single]
        assert some[domain]["draws"] == each
        assert some[domain]["scores"]["fused"]["accuracy"] == pytest.approx(np.mean(each))
        assert "draws" not in single[0][domain]
    assert "draws" not in some["TAG-sim"]


def test_without_a_split_the_drawn_pairs_are_not_predicted(
    capsys, tmp_path, make_embeddings, head_folder
):
    save_embeddings(tmp_path / "set.safetensors", make_embeddings())
    plain = evaluated(capsys, tmp_path, head_folder)
    some = evaluated(capsys, tmp_path, head_folder, "--unlabelled", "7")
    assert some["OF Real-sim"]["pairs"] == plain["OF Real-sim"]["pairs"] - 7


def test_a_profile_file_serves_the_domain_that_it_names(capsys, two, head_folder):
    plain = evaluated(capsys, two, head_folder)
    some = evaluated(capsys, two, head_folder, "--profile", str(two / "p.safetensors"))
    assert some["OF Real-sim"]["unlabelled"] == 20
    assert some["TQ-DIGIT-sim"] == plain["TQ-DIGIT-sim"]


def test_the_table_says_what_was_known(capsys, two, head_folder):
    set_ = str(two / "set.safetensors")
    assert (
        main(["evaluate", "--head", str(head_folder), "--embeddings", set_, "--unlabelled", "5"])
        == 0
    )
    said = capsys.readouterr().out
    assert "5 pictures without labels" in said and "Mean of 10 draws" in said


@pytest.mark.parametrize("command", ["gaps", "project", "sweep"])
def test_features_follow_the_profile(command, capsys, tmp_path, two, head_folder):
    out = {"gaps": ["--json"], "project": ["--method", "pca"], "sweep": ["--stops", "3"]}[command]

    def run(*more):
        file = tmp_path / ("m.csv" if command == "project" else "c.json")
        to = {"gaps": [], "project": ["--out", str(file)], "sweep": ["--json", str(file)]}[command]
        set_ = ["--embeddings", str(two / "set.safetensors"), "--head", str(head_folder)]
        assert main([command, *set_, *out, *to, *more]) == 0, capsys.readouterr().err
        printed = capsys.readouterr().out
        return printed if command == "gaps" else file.read_text()

    assert run() != run("--profile", str(two / "p.safetensors"))
    assert run() == run()


def test_a_head_without_its_sources_profile_is_named(capsys, tmp_path, two, head_folder):
    shutil.copytree(head_folder, tmp_path / "head")
    (tmp_path / "head" / "profile.safetensors").unlink()
    set_ = str(two / "set.safetensors")
    code = main(
        ["evaluate", "--head", str(tmp_path / "head"), "--embeddings", set_, "--unlabelled", "2"]
    )
    assert code == 1 and "has no profile of its source" in capsys.readouterr().err


def test_a_set_gives_the_profile_of_one_domain(capsys, tmp_path, two):
    out = tmp_path / "q.safetensors"
    set_ = str(two / "set.safetensors")
    assert main(["profile", set_, "--out", str(out)]) == 1
    assert "has 3 domains; name one" in capsys.readouterr().err
    assert main(["profile", set_, "--out", str(out), "--domain", "TAG-sim"]) == 0
    pairs = load_embeddings(set_)
    wanted = profile_of(pairs, pairs.rows_of("TAG-sim")).channels["tac"].mean
    np.testing.assert_allclose(load_profile(out).channels["tac"].mean, wanted, rtol=1e-6)


def picture(path, value):
    path.parent.mkdir(parents=True, exist_ok=True)
    pixels = np.random.default_rng(value).integers(0, 255, (32, 32, 3), np.uint8)
    Image.fromarray(pixels).save(path)


def test_pictures_are_profiled_without_labels_and_a_broken_one_is_named(capsys, tmp_path):
    for k in range(3):
        picture(tmp_path / "new" / f"press{k}_tac.png", k)
        picture(tmp_path / "new" / "vis" / f"{k}.png", 9 + k)
    (tmp_path / "new" / "broken_tac.png").write_bytes(b"no picture")
    out = tmp_path / "p.safetensors"
    code = main(["profile", str(tmp_path / "new"), "--out", str(out), "--domain", "my DIGIT"])
    said = capsys.readouterr()
    assert code == 0, said.err
    assert "3 photos and 3 tactile images, no labels read" in said.out
    assert "skipped" in said.err and "broken_tac.png" in said.err
    assert load_profile(out).counts == {"vis": 3, "tac": 3}


def test_a_folder_of_touches_alone_makes_a_profile_of_touch(capsys, tmp_path):
    picture(tmp_path / "presses" / "a.png", 1)
    out = tmp_path / "p.safetensors"
    assert main(["profile", "--tac", str(tmp_path / "presses"), "--out", str(out)]) == 0
    assert load_profile(out).counts == {"tac": 1}


def test_a_folder_without_pictures_ends_in_one_sentence(capsys, tmp_path):
    (tmp_path / "empty").mkdir()
    code = main(["profile", str(tmp_path / "empty"), "--out", str(tmp_path / "p.safetensors")])
    assert code == 1 and "Name them *_vis.png and *_tac.png" in capsys.readouterr().err
    assert not (tmp_path / "p.safetensors").exists()
