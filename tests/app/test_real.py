"""Fetched sets of real pairs on the shelf: their terms, their pictures by name, broken folders."""

import json
import os

import pytest

from app.shared.real import SHOWN, RealPairs
from omnivat.data.fetching import fetched_sets

from .conftest import served


@pytest.fixture
def shelf(fetched):
    return RealPairs(fetched.parent)


def rename(fetched, name):
    """Make the set another one of the table."""
    commit = fetched_sets()[name].commit
    (fetched / "fetched.json").write_text(json.dumps({"name": name, "commit": commit}))


def test_a_fetched_set_is_listed_with_its_terms_and_its_pictures_are_served_by_name(shelf, fetched):
    (found,) = shelf.listing(local=True)["sets"]
    row = fetched_sets()["touch-and-go"]
    assert [found[name] for name in ("title", "authors", "licence", "changes")] == [
        row.title,
        row.authors,
        row.licence,
        row.changes,
    ]
    assert [pair["class"] for pair in found["pairs"]] == ["brick", "tree"] and found["count"] == 2
    name = found["pairs"][1]["pictures"]["tac"]
    assert shelf.picture(name, local=False) == fetched / "tree_tac.png"


def test_a_set_of_touches_alone_has_no_photos_and_a_large_one_shows_a_few_pairs(shelf, fetched):
    rows = [f"t{k}.png,t{k}.png,Octopi,part {k % 3},{k}" for k in range(40)]
    (fetched / "pairs.csv").write_text("\n".join(["vis,tac,domain,material,object", *rows]))
    for k in range(40):
        (fetched / f"t{k}.png").write_bytes((fetched / "tree_tac.png").read_bytes())
    (found,) = shelf.listing(local=True)["sets"]
    assert found["count"] == 40 and len(found["pairs"]) == SHOWN
    assert {*map(tuple, (pair["pictures"] for pair in found["pairs"]))} == {("tac",)}


def test_a_set_that_may_not_be_passed_on_is_shown_on_this_machine_alone(shelf, fetched):
    rename(fetched, "vt60")
    name = shelf.listing(local=True)["sets"][0]["pairs"][0]["pictures"]["vis"]
    assert shelf.picture(name, local=True).is_file()
    assert shelf.listing(local=False)["sets"] == []
    with pytest.raises(ValueError, match="no such real picture"):
        shelf.picture(name, local=False)


def outside(fetched):
    (fetched.parent / "secret.png").write_bytes(b"secret")
    table = (fetched / "pairs.csv").read_text()
    (fetched / "pairs.csv").write_text(table.replace("tree_vis.png", "../secret.png"))


def link(fetched):
    (fetched.parent / "secret.png").write_bytes(b"secret")
    (fetched / "tree_vis.png").unlink()
    (fetched / "tree_vis.png").symlink_to(fetched.parent / "secret.png")


def pipe(fetched):
    (fetched / "pairs.csv").unlink()
    os.mkfifo(fetched / "pairs.csv")


def no_record(fetched):
    (fetched / "fetched.json").write_text("[" * 100_000)


def another_commit(fetched):
    (fetched / "fetched.json").write_text('{"name": "touch-and-go", "commit": "0"}')


BROKEN = (outside, link, pipe, no_record, another_commit)


@pytest.mark.parametrize("harm", BROKEN)
def test_a_broken_or_hostile_folder_is_left_out_with_one_sentence(shelf, fetched, harm):
    harm(fetched)
    found = shelf.listing(local=True)
    assert found["sets"] == [] and len(found["left_out"]) == 1
    (sentence,) = found["left_out"]
    assert sentence.startswith("'touch-and-go' is left out: ") and sentence.endswith(".")
    assert "\n" not in sentence and str(fetched.parent) not in sentence


def test_the_routes_serve_the_listing_and_no_path_of_a_request(resources, shelf, fetched):
    resources.shared.real = shelf
    with served(resources, client=("127.0.0.1", 1)) as client:
        (found,) = client.get("/omnivat/real").json()["sets"]
        name = found["pairs"][0]["pictures"]["vis"]
        reply = client.get(f"/omnivat/real/{name}")
        assert reply.content == (fetched / "brick_vis.png").read_bytes()
        assert reply.headers["content-type"] == "image/png"
        for path in ("touch-and-go/brick_vis.png", "../fetched.json", "%2e%2e/fetched.json", "x"):
            reply = client.get(f"/omnivat/real/{path}")
            assert reply.status_code in (400, 404), path
