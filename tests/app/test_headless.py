"""Sets that no head fits: maps, gaps and neighbours of their features, and what a head would
need.
"""

from dataclasses import replace

import numpy as np
import pytest

from app.shared.resources import Resources
from omnivat.data.store import save_embeddings
from omnivat.maps.frames import read_frames

from .conftest import loaded, served


@pytest.fixture
def foreign(resources, make_embeddings, tmp_path, monkeypatch):
    """Return a maker of resources whose set is of another encoder than their head."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))

    def make(**options):
        made = make_embeddings(width=12, **options)
        other = replace(made, header=replace(made.header, encoder="other-encoder"))
        save_embeddings(tmp_path / "my set.safetensors", other)
        return Resources(replace(resources.where, embeddings=tmp_path / "my set.safetensors"))

    return make


def test_a_set_that_the_head_does_not_fit_has_maps_and_both_gaps_of_its_features(foreign):
    resources = foreign()
    frames = read_frames(resources.frames.wait().file)
    assert frames.head == {"kind": "features"}
    assert set(frames.maps) == {"pca/raw", "umap/raw"}
    for name in ("modality_gap/raw", "domain_gap/raw", "margin/raw"):
        assert np.isfinite(frames.curves[name]).all()
    assert not any(name.startswith("accuracy") for name in frames.curves)


def test_raw_neighbours_need_no_head_and_other_steps_name_both_encoders(foreign):
    with served(foreign()) as client:
        near = client.post("/omnivat/neighbours", json={"point": 0, "stage": "raw"}).json()
        assert len(near["neighbours"]) == 6
        for path, question in (
            ("neighbours", {"point": 0, "stage": "f_hat"}),
            ("pair", {"vis": "row:0"}),
        ):
            text = client.post(f"/omnivat/{path}", json=question).json()["error"]
            assert "other-encoder" in text and "test-encoder" in text


def test_the_page_names_the_command_that_trains_a_head(foreign):
    with served(foreign()) as client:
        found = client.get("/omnivat/fit").json()
    assert "other-encoder" in found["problem"] and "/" not in found["command"]
    assert found["command"] == "python -m omnivat try 'my set.safetensors'"


def test_a_visitor_may_load_a_set_of_another_encoder_but_no_head_beside_it(foreign, resources):
    other = foreign().where.embeddings
    files = {"embeddings.safetensors": other}
    head = {name: resources.where.head / name for name in ("weights.safetensors", "settings.json")}
    with served(resources) as client:
        name = loaded(client, files).json()["set"]
        assert client.get(f"/omnivat/fit?set={name}").json()["command"]
        assert "other-encoder" in loaded(client, files | head).json()["error"]
