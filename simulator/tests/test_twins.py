"""Twins: all images of an object come from one press, and two of them differ in one thing only."""

from collections import defaultdict
from dataclasses import replace
from hashlib import sha256

import pytest

from omnivat.cli import main
from omnivat.data.readers import read_pairs
from omnivat.data.rest import with_rest
from omnivat.kit.errors import DataError, MissingPackageError
from omnivat.study.shift import read_features
from simulator import build
from simulator.domains import NUMBERS, SIMULATED
from simulator.drawing import drawn
from simulator.photograph import plain
from simulator.twins import simulate_twins, twin, unmet_objects

SMALL = {"seed": 0, "size": 48, "renderer": plain}
FIRST, SECOND = SIMULATED["TAG"], SIMULATED["TQ-DIGIT"]


def images(unmet, domain):
    pair = twin(unmet, domain)
    return {kind: drawn(pair, kind, **SMALL).tobytes() for kind in ("tac", "vis")}


def test_the_plan_has_sixty_objects_of_each_class_and_stays_as_it_was_shipped():
    plan = unmet_objects()
    text = "\n".join(f"{p.object} {p.number} {p.looks_like} {p.feels_like} test" for p in plan)

    assert len({p.object for p in plan}) == len(plan) == 300
    assert (
        sha256(text.encode()).hexdigest()
        == "3dc5e1b055d9e02e31cccd654843b1223c8c0ce2e92ee4274a13726a107f97ab"
    )


def test_no_domain_has_an_object_of_the_twins():
    numbers = {p.number for p in unmet_objects()}
    taken = {
        number for d in SIMULATED.values() for number in range(d.seed_base, d.seed_base + NUMBERS)
    }

    assert not numbers & taken


@pytest.mark.parametrize(("part", "changed"), [("sensor", "tac"), ("scene", "vis")])
def test_another_sensor_changes_the_touch_alone_and_another_scene_the_photograph(part, changed):
    unmet = unmet_objects(1)[4]
    before = images(unmet, FIRST)
    after = images(unmet, replace(FIRST, **{part: getattr(SECOND, part)}))

    assert [kind for kind in before if after[kind] != before[kind]] == [changed]


@pytest.mark.slow  # draws pairs
def test_touches_of_five_gels_need_no_package_and_are_embedded_as_touches_alone(
    tmp_path, monkeypatch
):
    monkeypatch.setattr(build, "find_spec", lambda name: None)
    with pytest.raises(MissingPackageError, match="mitsuba, taxim, jax are not installed"):
        simulate_twins(tmp_path / "set", each=2, workers=1)
    assert not (tmp_path / "set").exists()
    simulate_twins(tmp_path / "set", each=2, gels=True, size=48, workers=1)

    found = with_rest(read_pairs(tmp_path / "set"), "all")
    assert {pair.tac_rest.parent.name for pair in found.pairs} == set(found.domains())
    assert len(found.pairs) == 50 and len(found.domains()) == 5
    splits = {(pair.object, pair.split) for pair in found.pairs}
    assert len(splits) == 10 and sum(split == "test" for _, split in splits) == 5

    out = tmp_path / "set.safetensors"
    command = ["embed", tmp_path / "set", "--encoder", "strip", "--out", out]
    assert main(list(map(str, command))) == 0
    read = read_features(out)
    assert read.modalities == ("tac",) and read.embeddings.header.simulated


@pytest.mark.slow  # draws pairs
def test_a_set_on_disk_says_whose_twin_a_pair_is_and_is_not_drawn_twice(tmp_path, monkeypatch):
    few = {name: SIMULATED[name] for name in ("TAG", "TQ-DIGIT", "TQ-T3D")}
    monkeypatch.setattr("simulator.twins.SIMULATED", few)
    simulate_twins(tmp_path, each=1, size=48, renderer=plain, workers=1)
    steps = []
    made = simulate_twins(
        tmp_path, each=1, size=48, renderer=plain, workers=1, on_step=steps.append
    )

    domains = defaultdict(set)
    for pair in read_pairs(tmp_path).pairs:
        assert pair.split == "test"
        domains[pair.object].add(pair.domain)
    assert len(domains) == 5
    assert set(map(frozenset, domains.values())) == {frozenset(f"{name}-sim" for name in few)}
    assert len(made.pairs) == 15
    assert [(step.done, step.total) for step in steps] == [(30, 30)]


def test_less_than_one_object_of_a_class_is_refused(tmp_path):
    with pytest.raises(DataError, match="0 objects of a class were requested; choose 1 or more"):
        simulate_twins(tmp_path, each=0)
    assert not list(tmp_path.iterdir())
