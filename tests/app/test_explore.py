"""Explore's neighbours: exact, in the full width."""

from base64 import b64decode

import numpy as np
import pytest

from app.explore.tab import known, nearest, neighbours

from .conftest import served


def test_the_nearest_row_by_cosine_comes_first_and_never_the_point_itself():
    rows = np.array([[1, 0], [0, 1], [0.8, 0.6], [-1, 0]], dtype=np.float32)
    assert [one["point"] for one in nearest(rows, 0)][:2] == [2, 1]


@pytest.mark.parametrize(("stage", "moves"), [("raw", False), ("frft", False), ("relu", True)])
def test_neighbours_depend_on_the_order_from_the_relu_on(resources, stage, moves):
    first, last = (
        neighbours(resources, {"point": 4, "stage": stage, "order": order})["neighbours"]
        for order in (0.1, 0.9)
    )
    assert ([n["point"] for n in first] != [n["point"] for n in last]) is moves


def test_as_many_pictures_are_known_as_half_of_the_smallest_unseen_domain(resources):
    embeddings = resources.embeddings()
    assert known(resources, {"known": "k3"})["known"] == "3 labelled pairs of each class"
    home, away = (np.flatnonzero(embeddings.domain == k) for k in (0, 1))
    resources.embeddings._made[:] = [embeddings.select(np.concatenate([home, away[::4]]))]
    assert known(resources, {"known": "n20"})["known"] == "5 pairs without labels"


def test_the_twins_and_their_sheets_are_served_and_no_other_file_of_their_folder(resources):
    with served(resources) as client:
        shown = client.get("/omnivat/twins").json()
        places = client.get("/omnivat/twins/map").json()
        sheets = [client.get(f"/omnivat/twins/{one['sheet']}") for one in shown["shown"]]
        assert {sheet.headers["content-type"] for sheet in sheets} == {"image/webp"}
        for name in ("none.webp", "..%2Ftwins.json", "00.webp.webp"):
            assert client.get(f"/omnivat/twins/{name}").status_code == 404
    count = len(shown["domains"]) * places["presses"]
    for method in ("pca", "umap"):
        assert [len(b64decode(one)) for one in places[method]] == [4 * count] * 3
