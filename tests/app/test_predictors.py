"""What predicts the set: heads, and a method fitted on the source."""

from dataclasses import replace

import numpy as np
import pytest

from app.explore import predictors
from app.shared.resources import Resources


@pytest.fixture
def two_heads(resources, small_places):
    """Return resources with the same head twice: once as the first, once to compare."""
    return Resources(replace(small_places, compare=(small_places.head,)))


def test_a_compared_head_is_listed_by_the_name_of_the_folder_that_it_is_in(two_heads):
    first, other = predictors.heads(two_heads)
    assert (first["name"], other["name"]) == ("", two_heads.where.head.parent.name)
    assert other["generation"] == "tree"
    assert other["source"] == "TAG-sim"


def test_two_compared_heads_of_one_name_are_told_apart(small_places):
    twice = replace(small_places, compare=(small_places.head, small_places.head))
    assert len(Resources(twice).heads) == 3


def test_a_folder_that_is_no_head_is_listed_with_the_reason(resources, small_places, tmp_path):
    other = Resources(replace(small_places, compare=(tmp_path,)))
    assert "is not a head" in predictors.heads(other)[1]["problem"]


def test_a_method_is_fitted_on_the_source_and_answers_every_pair(resources):
    got = predictors.predictions(resources, {"method": "nearest_mean"})
    embeddings = resources.embeddings()
    right = np.array(got["prediction"]) == embeddings.label
    assert right[embeddings.domain == 0].mean() > 0.9


def test_a_class_that_a_method_lacks_is_left_out_of_its_score(make_embeddings):
    """As for a head; otherwise a class that both lack would count against one of them."""
    embeddings = make_embeddings()
    known = embeddings.header.classes[:3]
    said = np.where(embeddings.label < 3, embeddings.label, 0)
    found = predictors.scores_of(embeddings, known, "TAG-sim", said)
    assert found == {"TAG-sim": 1.0, "OF Real-sim": 1.0, "unseen": 1.0}
    everything = predictors.scores_of(embeddings, embeddings.header.classes, "TAG-sim", said)
    assert everything["unseen"] == pytest.approx(3 / 5)
