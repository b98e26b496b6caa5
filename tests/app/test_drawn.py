"""A set too large for the page: it is sampled at random, and the page shows that."""

from dataclasses import replace

import pytest

from app.resources import Resources

from .conftest import served


@pytest.fixture
def client(small_places):
    resources = Resources(replace(small_places, drawn=12))
    yield served(resources)
    resources.shared.close()


def test_the_page_works_on_the_part_and_says_of_how_many_it_is(client):
    said = client.get("/omnivat/about").json()["embeddings"]
    assert said["pairs"] == 12
    assert "12 of" in said["origin"]
    assert "drawn at random" in said["origin"]
    assert client.post("/omnivat/pair", json={"vis": "row:11"}).status_code == 200
    assert client.post("/omnivat/pair", json={"vis": "row:12"}).status_code == 400


def test_thumbnails_of_the_whole_set_are_not_shown_for_the_part(client):
    assert client.get("/omnivat/thumbnails.json").status_code == 404
