"""`omnivat gaps` and `omnivat project`: what they print is what the library measures."""

import csv
import json

import numpy as np
import pytest
import torch

from omnivat.data.store import load_embeddings
from omnivat.measure.gaps.centroid import centroid_gap, modality_gap


@pytest.fixture
def names(head_folder):
    return ["--head", str(head_folder), "--embeddings", str(head_folder.parent / "set.safetensors")]


def test_gaps_at_raw_are_those_of_the_embeddings_and_need_no_head(head_folder, run):
    file = head_folder.parent / "set.safetensors"
    raw = "--embeddings", file, "--head", "nowhere", "--stage", "raw", "--json"
    found = json.loads(run("gaps", *raw).out)
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


def test_gaps_after_the_head_move_with_the_order(names, run):
    texts = [run("gaps", *names, "--order", order).out for order in (0.2, 0.8)]
    assert texts[0] != texts[1]
    assert "p = 0.2, simulated data" in texts[0]
    assert "between domains, TAC" in texts[0]


def test_a_map_has_a_named_row_for_every_point(names, tmp_path, run):
    out = tmp_path / "map.csv"
    said = run("project", *names, "--out", out, "--method", "pca").out
    assert "trustworthiness 0." in said
    with out.open(newline="", encoding="utf-8") as handle:
        rows = list(csv.DictReader(handle))
    count = len(load_embeddings(names[3]))
    assert len(rows) == 2 * count
    assert [row["modality"] for row in rows] == ["vis"] * count + ["tac"] * count
    assert rows[0]["pair"] == rows[count]["pair"] == "0"
    assert rows[count]["name"].endswith("_tac.png")
    places = np.array([[float(row["x"]), float(row["y"])] for row in rows])
    assert np.abs(places.mean(0)).max() < 1e-4 and places.std(0).min() > 0


def test_a_map_that_is_no_csv_is_refused_before_anything_is_computed(names, tmp_path, run):
    said = run("project", *names, "--out", tmp_path / "map.png", code=1).err
    assert "name a file that ends in .csv" in said
    assert list(tmp_path.iterdir()) == []
