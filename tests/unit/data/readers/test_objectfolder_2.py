"""ObjectFolder 2.0: what the numbers mean, and the paper's counts."""

import json
from collections import Counter

import numpy as np
import pytest

from omnivat.data.readers import read_pairs
from omnivat.kit.errors import DataError

SMALL = {1: "Wood", 2: "Steel", 3: "Polycarbonate", 101: "Wood", 102: "Iron", 103: "Plastic"}


def test_the_draw_reproduces_the_papers_counts(release):
    """With the objects of each material that objects.csv has, merged, and 100 instances as 1."""
    names = ("Wood", "Steel", "Plastic", "Ceramic", "Glass", "Iron", "Polycarbonate")
    objects, a, b = {}, (21, 17, 11, 19, 2, 6, 24), (30, 21, 9, 30, 24, 20, 25)
    for start, many in ((1, a), (101, b)):
        objects |= dict(enumerate(np.repeat(names, many).tolist(), start))
    found = read_pairs(release(objects, instances=1))
    assert found.simulated  # by the data set's makers
    assert {p.tac_crop for p in found.pairs} == {320}
    counts = Counter((p.domain, p.split, p.material) for p in found.pairs)
    assert {name: counts["OF 2.0 A", "train", name] for name in found.materials()} == dict.fromkeys(
        found.materials(), 2
    )  # 1,000 pairs = 5 classes * 2 objects * 100 instances
    tests = {name: counts["OF 2.0 A", "test", name] for name in found.materials()}
    assert tests == {"wood": 5, "steel": 5, "plastic": 5, "ceramic": 5, "glass": 2}  # 2,200
    assert {counts["OF 2.0 B", "train", name] for name in found.materials()} == {19}  # 9,500
    assert {counts["OF 2.0 B", "test", name] for name in found.materials()} == {5}  # 2,500
    sides = Counter(p.object for p in found.pairs if p.domain == "OF 2.0 B")
    assert set(sides.values()) == {1}, "no object is in both"


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"102": 2}, "gives wood the label 2 and iron the label 2 .object 102"),
        ({"101": 9}, "gives wood the label 2 and wood the label 9 .object 101"),
    ],
)
def test_a_label_of_two_materials_and_a_material_of_two_labels_are_refused(
    release, change, message
):
    root = release(SMALL)
    labels = json.loads((root / "label.json").read_text())
    (root / "label.json").write_text(json.dumps(labels | change))
    with pytest.raises(DataError, match=message):
        read_pairs(root)


def test_the_releases_own_split_can_be_read(release):
    root = release(SMALL)
    split = {"train": [[1, 0], [1, 1]], "val": [["2", 0]], "test": [["101", 1]]}
    (root / "split.json").write_text(json.dumps(split))
    found = read_pairs(root, split="release")
    assert Counter(p.split for p in found.pairs) == {"train": 2, "val": 1, "test": 1}
    assert sum(s.count for s in found.skipped) == 8


@pytest.mark.parametrize("text", ["{", '{"train": 3}', '{"test": [["a", 1]]}'])
def test_a_broken_split_is_refused(release, text):
    root = release(SMALL)
    (root / "split.json").write_text(text)
    with pytest.raises(DataError, match=r"split\.json"):
        read_pairs(root, split="release")


def test_a_missing_table_of_objects_is_asked_for(release):
    root = release(SMALL)
    (root / "objects.csv").unlink()
    with pytest.raises(DataError, match=r"copy objects\.csv of the ObjectFolder repository"):
        read_pairs(root)


def test_missing_halves_and_unnamed_objects_are_counted(release, tree, reasons):
    root = release(SMALL)
    (root / "touch/1/0.png").unlink()
    whys = reasons(read_pairs(tree("touch/999/0.png")))
    assert whys["object 1"] == "no image in touch"
    assert whys["touch/999"] == "label.json does not name it"
