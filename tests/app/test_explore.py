"""Explore's neighbours: exact, in the full width."""

import numpy as np
import pytest

from app.views.explore import nearest, neighbours
from omnivat.kit.errors import DataError


def test_the_nearest_row_by_cosine_comes_first_and_never_the_point_itself():
    rows = np.array([[1, 0], [0, 1], [0.8, 0.6], [-1, 0]], dtype=np.float32)
    assert [one["point"] for one in nearest(rows, 0)][:2] == [2, 1]


def test_raw_neighbours_do_not_depend_on_the_order(resources):
    at = [neighbours(resources, {"point": 4, "stage": "raw", "order": order}) for order in (0.1, 0.9)]
    assert at[0] == at[1]


def test_the_map_of_the_transform_has_the_neighbours_of_its_input_when_nothing_is_projected(resources):
    """The head of this test projects, so the two differ; the transform itself keeps distances."""
    at = [neighbours(resources, {"point": 4, "stage": "frft", "order": order}) for order in (0.1, 0.9)]
    assert [n["point"] for n in at[0]["neighbours"]] == [n["point"] for n in at[1]["neighbours"]]


def test_neighbours_after_the_relu_depend_on_the_order(resources):
    at = [neighbours(resources, {"point": 4, "stage": "relu", "order": order}) for order in (0.1, 0.9)]
    assert at[0] != at[1]


@pytest.mark.parametrize(
    ("question", "sentence"),
    [
        ({"point": 4, "stage": "nowhere"}, "No stage is called 'nowhere'"),
        ({"point": 4000, "stage": "raw"}, "No point has the number 4000"),
        ({"point": "4", "stage": "raw"}, "No point has the number '4'"),
        ({"stage": "raw"}, "No point has the number None"),
    ],
)
def test_what_is_not_there_is_refused(resources, question, sentence):
    with pytest.raises(DataError, match=sentence):
        neighbours(resources, question)


def test_centring_brings_the_means_of_domains_together_on_the_map(resources):
    from app.views.explore import centred

    found = centred(resources, "pca")
    before, after = found["curves"]["domain_gap/raw"]
    assert after < 0.2 * before
    assert len(found["bounds"]) == 2


def test_a_ladder_of_an_unknown_domain_is_refused(resources):
    from app.views.explore import ladder

    with pytest.raises(DataError, match="The set has no domain 'nowhere'"):
        ladder(resources, {"source": "nowhere"})
    found = ladder(resources, {"source": ""})
    assert {"rung", "accuracy", "low", "high", "from"} <= set(found["rungs"][0])
    assert found["sources"][0] == resources.head().source
