"""A set too large for the page: it is sampled at random, and the page shows that."""

from dataclasses import replace

import pytest

from app.shared.resources import Resources

from .conftest import served


@pytest.fixture
def part(small_places):
    resources = Resources(replace(small_places, drawn=12))
    yield resources
    resources.shared.close()


def test_the_page_works_on_the_part_and_says_of_how_many_it_is(part):
    assert "12 of" in part.embeddings().header.origin  # which the frames repeat
    client = served(part)
    assert client.get("/omnivat/about").json()["embeddings"]["pairs"] == 12
    assert client.post("/omnivat/pair", json={"vis": "row:11"}).status_code == 200
    assert client.post("/omnivat/pair", json={"vis": "row:12"}).status_code == 400
    assert client.get("/omnivat/thumbnails.json").status_code == 404
