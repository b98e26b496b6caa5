"""The head for a visitor's own pictures, beside the project's head."""

import json
from dataclasses import replace
from pathlib import Path

import pytest

from app.explore.predictors import heads
from app.pair.tab import predicted
from app.serving.about import own
from app.shared.familiar import familiar
from app.shared.places import places, shipped_places
from app.shared.resources import Resources
from omnivat.head.heads import default_head, own_head


@pytest.fixture
def with_own(resources):
    """Return resources whose head for own pictures is a second copy of the small head."""
    found = Resources(replace(resources.where, own=resources.where.head))
    found.encoder = resources.encoder
    return found


def test_own_pictures_are_read_by_the_head_that_a_request_names(with_own, png):
    ref = str(with_own.take_image(png(), "a.png")[0])
    assert "own" in with_own.heads
    assert with_own.head_named("own") is not with_own.head()
    assert [one["name"] for one in heads(with_own)] == [""]  # it is no head to compare or to draw
    for asked in ({"vis": ref}, {"vis": ref, "head": "own"}):
        assert predicted(with_own, asked)["linear"] is False
    assert set(familiar(with_own, {"vis": ref, "head": "own"})["images"]) == {"vis"}


def test_only_the_projects_head_has_one_beside_it(head_folder):
    assert shipped_places("sensors").own == places().own == own_head()
    assert shipped_places("chirps").own is None
    assert places(head=head_folder).own is None
    assert own_head() != default_head()


def test_what_it_reads_right_is_told_from_its_record(resources):
    assert own(resources) == {}
    found = own(Resources(places()))
    assert found["left_out"]["20"]["fused"] > found["left_out"]["0"]["fused"]
    record = json.loads(Path("docs/benchmarks/own.json").read_text())
    assert found["real"] == record["real"]
    told = [of["as they come"] for kinds in record["odd"].values() for of in kinds.values()]
    assert len(told) == 24 and sum(told) >= 0.95 * 240
