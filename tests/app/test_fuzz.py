"""A small attack on every run: hostile images, heads, sets, requests and callers."""

import pytest
from starlette.applications import Starlette
from starlette.middleware import Middleware
from starlette.testclient import TestClient

from app.guard import Guard, rules
from app.routes import routes
from benchmarks.attack import attack


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, pytest.param(2, marks=pytest.mark.long)])
def test_a_small_attack_is_held_with_a_sentence_for_every_refusal(resources, seed):
    guarded = [Middleware(Guard, rules=rules("127.0.0.1"))]
    application = Starlette(routes=routes(resources, api=True), middleware=guarded)
    with TestClient(application, base_url="http://127.0.0.1") as client:
        found = attack(client, resources, seed, 16)
    resources.shared.close()
    fell = [line for counts in found.values() for line in counts.fell if " s" not in line[-3:]]
    assert fell == []
    assert all(counts.held >= 16 for counts in found.values())


@pytest.mark.slow
def test_no_visitor_finds_a_picture_profile_or_head_of_another(resources):
    from benchmarks._attack_names import apart

    cases = list(apart(lambda: Starlette(routes=routes(resources)), resources))
    assert len(cases) == 6
    assert [what for what, held in cases if not held] == []


@pytest.mark.slow
def test_hostile_names_stay_text_in_every_output(tmp_path):
    from benchmarks._attack_names import outputs

    cases = list(outputs(tmp_path))
    assert len(cases) > 20
    assert [what for what, held in cases if not held] == []


@pytest.mark.slow
def test_recordings_numbers_and_lessons_of_an_attacker_are_held(resources, tmp_path, monkeypatch):
    import random

    from benchmarks import _attack_falls as falls

    monkeypatch.setattr(falls, "RECORDINGS", 40)
    monkeypatch.setattr(falls, "SLOW_S", 1e9)  # counts and errors alone
    (tmp_path / "recordings").mkdir()
    cases = [*falls.recordings(tmp_path / "recordings", random.Random(3)), *falls.numbers(tmp_path)]
    cases += falls.teaching(lambda: Starlette(routes=routes(resources)))
    assert len(cases) > 60
    assert [what for what, held in cases if not held] == []
