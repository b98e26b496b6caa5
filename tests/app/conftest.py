"""A small learnable set and head for the page's tests."""

import json
import time
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from app.shared.places import Places
from app.shared.resources import Resources
from app.shared.state import Ref

LESSONS = [
    {"vis": f"row:{row}", "tac": f"row:{row}", "label": label}
    for row, label in ((40, "cork"), (41, "cork"), (72, "glass"), (73, "glass"))
]


@pytest.fixture(scope="session")
def small_places(head_folder, tmp_path_factory, paint):
    """Return the locations of a small head, its set and two example pairs; there are no frames
    yet.
    """
    pairs = tmp_path_factory.mktemp("pairs")
    for name in ("TAG-sim/wood/0", "OF Real-sim/steel/new"):
        for modality in ("vis", "tac"):
            paint(pairs / f"{name}_{modality}.png")
    return Places(
        head=head_folder,
        embeddings=head_folder.parent / "set.safetensors",
        frames=None,
        pairs=pairs,
    )


@pytest.fixture(scope="session")
def framed(small_places, tmp_path_factory):
    """Return the small places with their frames, computed once."""
    from app.shared import frames_job
    from app.site.export import frames_file

    found = replace(small_places, computed=tmp_path_factory.mktemp("frames"))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(frames_job, "STOPS", (0.0, 0.5, 1.0))
        return replace(found, frames=frames_file(found))


def until(condition):
    """Wait until a condition holds; return what it gives."""
    for _ in range(6000):
        if found := condition():
            return found
        time.sleep(0.02)
    raise AssertionError("it did not happen within two minutes")


def own_image(resources, row):
    """Return a visitor's image by its embedding, as a reply has it."""
    return str(Ref.of_numbers(resources.encoder_key(), np.float32(row).tobytes()))


class PixelMeans:
    """An encoder for tests: colours of an image on a grid, with the width of the small head."""

    name, weights_hash, preprocessing, precision = "test-encoder", "0" * 16, "none", "fp32"
    width = 24
    calls = 0

    def preprocess(self, image):
        import torch

        return torch.from_numpy(np.array(image.resize((4, 2)), dtype=np.float32)).permute(2, 0, 1)

    def embed(self, images):
        self.calls += 1
        return images.flatten(1) / 255


@pytest.fixture
def encoder():
    return PixelMeans()


@pytest.fixture
def resources(small_places, encoder, monkeypatch):
    """Return new resources for the small set, with an encoder without weights."""
    monkeypatch.setattr("omnivat.encoders.base.load_encoder", lambda name, **_: encoder)
    return Resources(small_places)


@pytest.fixture
def png():
    """Return a maker of PNG bytes."""

    def make(side=32, seed=0):
        from io import BytesIO

        random = np.random.default_rng(seed)
        with BytesIO() as handle:
            Image.fromarray(random.integers(0, 255, (side, side, 3), dtype=np.uint8)).save(
                handle, "PNG"
            )
            return handle.getvalue()

    return make


def served(resources, *, api=False, **more):
    """Return a client of the page's routes."""
    from starlette.applications import Starlette
    from starlette.testclient import TestClient

    from app.serving.routes import routes
    from app.shared.visitor_sets import VisitorSets

    return TestClient(Starlette(routes=routes(VisitorSets(resources), api=api)), **more)


def posted(client, route, question, *files):
    """Return the response to a question with pictures after it."""
    parts = [json.dumps(question).encode(), *files]
    sizes = ",".join(str(len(part)) for part in parts)
    return client.post(f"/omnivat/{route}?sizes={sizes}", content=b"".join(parts))


@pytest.fixture
def client(resources):
    """Return a client of the small set's page."""
    with served(resources) as client:
        yield client


def loaded(client, files, **more):
    """Upload files of a head or set and load them; return the reply."""
    parts = {
        name: client.post(f"/omnivat/part?name={name}", content=file.read_bytes()).json()["part"]
        for name, file in files.items()
    }
    return client.post("/omnivat/load", json={"parts": parts, **more})


def sentence(response, status=400):
    """Return the sentence of an error."""
    assert response.status_code == status, response.text
    assert set(response.json()) == {"error"}
    text = response.json()["error"]
    assert text.endswith(".") and "Traceback" not in text and "\n" not in text
    return text
