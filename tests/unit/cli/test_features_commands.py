"""`omnivat gaps` and `omnivat project`: what they print is what the library measures."""

import csv
import json

import numpy as np
import pytest
import torch

from omnivat.cli import main
from omnivat.data.store import load_embeddings
from omnivat.measure.gaps.centroid import centroid_gap, modality_gap


@pytest.fixture
def names(head_folder):
    return ["--head", str(head_folder), "--embeddings", str(head_folder.parent / "set.safetensors")]


def test_gaps_at_raw_are_those_of_the_embeddings_and_need_no_head(head_folder, capsys):
    file = head_folder.parent / "set.safetensors"
    arguments = ["gaps", "--embeddings", str(file), "--head", "nowhere", "--stage", "raw", "--json"]
    assert main(arguments) == 0
    found = json.loads(capsys.readouterr().out)
    embeddings = load_embeddings(file)
    vis, tac = torch.tensor(np.array(embeddings.vis)), torch.tensor(np.array(embeddings.tac))
    first = torch.from_numpy(embeddings.domain.copy()) == 0
    assert found["order"] is None and found["simulated"] is True
    assert found["modality_gap"]["all"] == pytest.approx(float(modality_gap(vis, tac)), rel=1e-5)
    a, b = embeddings.header.domains
    assert found["domain_gap"]["tac"][a][b] == found["domain_gap"]["tac"][b][a]
    assert found["domain_gap"]["tac"][a][b] == pytest.approx(
        float(centroid_gap(tac[first], tac[~first])), rel=1e-5
    )


def test_the_raw_transform_changes_no_gap(names, capsys):
    found = []
    for more in (["raw"], ["frft", "--order", "0.3"], ["frft", "--order", "1.9"]):
        assert main(["gaps", *names, "--json", "--stage", *more]) == 0
        found.append(json.loads(capsys.readouterr().out)["modality_gap"]["all"])
    # the head projects to its own width first, so only the two transforms are alike
    assert found[1] == pytest.approx(found[2], rel=1e-5)


def test_gaps_after_the_head_move_with_the_order(names, capsys):
    texts = []
    for order in ("0.2", "0.8"):
        assert main(["gaps", *names, "--order", order]) == 0
        texts.append(capsys.readouterr().out)
    assert texts[0] != texts[1]
    assert "p = 0.2, simulated data" in texts[0]
    assert "between domains, TAC" in texts[0]


def test_a_map_has_a_named_row_for_every_point(names, tmp_path, capsys):
    out = tmp_path / "map.csv"
    assert main(["project", *names, "--out", str(out), "--method", "pca"]) == 0
    assert "trustworthiness 0." in capsys.readouterr().out
    with out.open(newline="", encoding="utf-8") as handle:
        rows = list(csv.DictReader(handle))
    count = len(load_embeddings(names[3]))
    assert len(rows) == 2 * count
    assert [row["modality"] for row in rows] == ["vis"] * count + ["tac"] * count
    assert rows[0]["pair"] == rows[count]["pair"] == "0"
    assert rows[count]["name"].endswith("_tac.png")
    places = np.array([[float(row["x"]), float(row["y"])] for row in rows])
    assert np.abs(places.mean(0)).max() < 1e-4 and places.std(0).min() > 0


def test_a_map_that_is_no_csv_is_refused_before_anything_is_computed(names, tmp_path, capsys):
    assert main(["project", *names, "--out", str(tmp_path / "map.png")]) == 1
    assert "name a file that ends in .csv" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []
