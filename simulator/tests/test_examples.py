"""Example pairs: of test objects, in the layout that the page and the readers find."""

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from app.shared.places import find_examples
from omnivat.data.domains import DOMAINS, simulated
from omnivat.data.pairs import Pair
from omnivat.data.readers import read_pairs
from omnivat.data.store import load_embeddings
from omnivat.kit.errors import DataError
from simulator.build import chosen, simulate, spread, write_examples
from simulator.photograph import plain
from simulator.plan import classes

pytestmark = pytest.mark.slow  # draws pairs

SHIPPED = Path(__file__).parents[2] / "examples"
SMALL = {"domains": ["TQ-T3D"], "size": 48, "renderer": plain, "workers": 1}


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    return simulate(tmp_path_factory.mktemp("set"), **SMALL, pairs_per_class=4)


def test_examples_are_images_of_test_objects_where_the_page_and_the_readers_find_them(
    made, tmp_path
):
    files = write_examples(made, tmp_path, each=1)

    names = {file.name.rsplit("_", 1)[0] for file in files}
    testing = {p.object.split("/")[1] for p in made.pairs if p.split == "test"}
    assert names == testing  # one of each class, and these are all there are
    assert len(files) == 2 * len(names) == 8
    assert len(find_examples(tmp_path)) == len(read_pairs(tmp_path).pairs) == 4
    there = next(p.tac for p in made.pairs if p.tac.stem == files[1].stem)
    with Image.open(files[1]) as lossy, Image.open(there) as whole:
        difference = np.abs(np.asarray(lossy, float) - np.asarray(whole, float))
    assert difference.mean() < 3.0  # what JPEG loses


def test_examples_are_taken_evenly_and_no_more_than_there_are():
    assert spread(list("abcdef"), 2) == ["b", "e"]
    assert spread(list("ab"), 5) == ["a", "b"]


def pair_like(name, looks_like):
    file = Path(name)
    return Pair(vis=file, tac=file, domain="TAG-sim", material="wood", looks_like=looks_like)


def test_half_of_the_examples_look_like_another_class_where_there_are_such_objects():
    plain = [pair_like(f"p{n}", "") for n in range(6)]
    alike = [pair_like(f"a{n}", "steel") for n in range(3)]

    assert [bool(pair.looks_like) for pair in chosen(plain + alike, 2)] == [False, True]
    assert not any(pair.looks_like for pair in chosen(plain, 2))
    assert len(chosen(alike, 2)) == 2


def test_a_set_without_test_objects_has_no_examples(tmp_path):
    only_train = simulate(tmp_path / "set", **SMALL, pairs_per_class=1)
    with pytest.raises(DataError, match="ask for 4 pairs per class"):
        write_examples(only_train, tmp_path / "examples")


def test_shipped_examples_cover_every_class_and_are_test_pairs_of_the_shipped_features():
    found = find_examples(SHIPPED / "pairs")
    wanted = {(simulated(d.name), name) for d in DOMAINS.values() for name in classes(d)}
    features = load_embeddings(SHIPPED / "simulated.safetensors")
    testing = {
        file.removesuffix("_vis.png")
        for file, split in zip(features.rows["vis"], features.rows["split"], strict=True)
        if split == "test"
    }

    assert len(found) >= 40
    assert {tuple(name.split("/")[:2]) for name in found} == wanted
    assert set(found) <= testing
    assert sum(f.stat().st_size for f in (SHIPPED / "pairs").rglob("*.*")) < 6e6
