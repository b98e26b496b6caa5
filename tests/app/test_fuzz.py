"""A small attack on every run: hostile images, heads, sets, requests and callers."""

from io import BytesIO

import pytest
from PIL import Image
from starlette.applications import Starlette
from starlette.middleware import Middleware
from starlette.testclient import TestClient

from app.serving.guard import Guard, rules
from app.serving.routes import routes
from app.shared.visitor_sets import VisitorSets
from benchmarks.attack import attack


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, pytest.param(2, marks=pytest.mark.long)])
def test_a_small_attack_is_held_with_a_sentence_for_every_refusal(resources, seed):
    guarded = [Middleware(Guard, rules=rules("127.0.0.1"))]
    application = Starlette(routes=routes(VisitorSets(resources), api=True), middleware=guarded)
    with TestClient(application, base_url="http://127.0.0.1") as client:
        found = attack(client, resources, seed, 16)
    resources.shared.close()
    fell = [line for counts in found.values() for line in counts.fell if " s" not in line[-3:]]
    assert fell == []
    assert all(counts.held >= 16 for counts in found.values())


@pytest.mark.slow
def test_no_visitor_finds_a_profile_or_head_of_another(resources):
    app = Starlette(routes=routes(VisitorSets(resources)))
    own, other = (TestClient(app, "http://127.0.0.1", client=(f"10.0.1.{k}", 1)) for k in (1, 2))
    with BytesIO() as handle:
        Image.new("RGB", (64, 64), 120).save(handle, "PNG")
        picture = handle.getvalue()
    ref = own.post("/omnivat/image?name=x", content=picture).json()["ref"]
    profile = own.post("/omnivat/profile", json={"photos": [ref]}).json()["profile"]
    lessons = [{"vis": f"row:{k}", "tac": f"row:{k}", "label": "ab"[k % 2]} for k in range(4)]
    taught = own.post("/omnivat/taught", json={"lessons": lessons}).json()["taught"]
    for client, status in ((own, 200), (other, 410)):
        for path, asked in (
            ("save/sensor", {"json": {"profile": profile}}),
            ("tree", {"json": {"vis": "row:1", "taught": taught}}),
        ):
            assert client.post(f"/omnivat/{path}", **asked).status_code == status, path
