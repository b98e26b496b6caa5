"""Touch-and-Go: labels, halves, balancing and the two ways to split."""

from collections import Counter

import pytest

from omnivat.data.readers import read_pairs
from omnivat.kit.errors import DataError

WOOD, METAL, TILE, GLASS, PLASTIC, GRASS = 3, 4, 6, 2, 1, 13


@pytest.fixture
def lists(clip):
    """Three clips of twelve frames, and the official lists: rows of clip, frame and label."""
    for k in (1, 2, 3):
        root = clip(f"{k}", range(12))

    def write(train, test=()):
        for name, rows in (("train", train), ("test", test)):
            text = "".join(f"{k}/{n:010d}.jpg,{label}\n" for k, n, label in rows)
            (root / f"{name}.txt").write_text(text)
        return root

    return write


def whys(pairs):
    return {skipped.what: (skipped.why, skipped.count) for skipped in pairs.skipped}


def test_labels_become_the_five_materials_with_the_official_split(lists):
    labels = (WOOD, METAL, TILE, GLASS, PLASTIC)
    root = lists([(1, i, label) for i, label in enumerate(labels)], [(1, 6, WOOD)])
    found = read_pairs(root)
    assert [p.material for p in found.pairs[:5]] == ["wood", "steel", "ceramic", "glass", "plastic"]
    assert [p.split for p in found.pairs] == ["train"] * 5 + ["test"]
    assert {p.domain for p in found.pairs} == {"TAG"}
    assert found.pairs[0].vis == root / "dataset/1/video_frame/0000000000.jpg"
    assert found.pairs[0].tac == root / "dataset/1/gelsight_frame/0000000000.jpg"
    assert found.origin == "Touch-and-Go, official lists"


def test_inconclusive_foreign_and_broken_lines_are_counted(lists):
    root = lists([(1, 0, WOOD), (1, 1, -1), (1, 2, -1), (1, 3, GRASS), (1, 0, WOOD)])
    with (root / "train.txt").open("a") as handle:
        handle.write("nonsense\n../../etc/0000000001.jpg,3\n1/x.jpg,3\n")
    found = whys(read_pairs(root))
    assert found["label 13"] == ("labels of other materials: none of the five materials", 1)
    assert found["1"] == ("listed twice", 1)
    counts = {s.why: s.count for s in read_pairs(root).skipped}
    assert counts["label -1, inconclusive"] == 2
    assert counts["lines that are not <clip>/<number>.jpg,<label>"] == 3


def test_classes_are_balanced_to_the_smallest_in_each_split(lists):
    train = [(1, i, WOOD) for i in range(8)] + [(2, i, GLASS) for i in range(3)]
    test = [(1, i, WOOD) for i in range(8, 12)] + [(3, 0, GLASS)]
    root = lists(train, test)
    found = read_pairs(root, seed=1)
    counts = Counter((p.split, p.material) for p in found.pairs)
    assert set(counts.values()) == {3, 1}
    assert sum(s.count for s in found.skipped) == 5 + 3
    assert found == read_pairs(root, seed=1)
    assert found != read_pairs(root, seed=2)
    assert len(read_pairs(root, balanced=False).pairs) == 16


def test_split_by_folder_keeps_clips_whole(lists):
    clips = ((1, WOOD), (2, WOOD), (3, GLASS))
    train, test = (
        [(c, i, label) for c, label in clips for i in k] for k in (range(8), range(8, 12))
    )
    root = lists(train, test)
    found = read_pairs(root, by_folder=True, balanced=False)
    assert len(found.pairs) == 36 and len({(p.object, p.split) for p in found.pairs}) == 3
    assert found.origin == "Touch-and-Go, split by clip"


def test_without_the_official_lists_label_txt_is_split_by_clip(lists):
    root = lists([(c, i, WOOD) for c in (1, 2, 3) for i in range(3)])
    (root / "train.txt").rename(root / "label.txt")
    (root / "test.txt").unlink()
    found = read_pairs(root, balanced=False)
    assert found.origin == "Touch-and-Go, split by clip"
    assert {p.split for p in found.pairs} == {"train", "test"}


def test_the_lists_may_lie_in_another_folder(lists, tmp_path):
    root = lists([(1, 0, WOOD)])
    elsewhere = tmp_path / "repository"
    elsewhere.mkdir()
    for name in ("train.txt", "test.txt"):
        (root / name).rename(elsewhere / name)
    assert len(read_pairs(root, lists=elsewhere).pairs) == 1


def test_other_materials_keep_their_names_on_request(lists):
    root = lists([(1, 0, WOOD), (1, 1, GRASS), (1, 2, 17)])
    (root / "category_reference.txt").write_text("Wood: 3\nGrass: 13\n")
    found = read_pairs(root, keep_labels=True)
    assert found.materials() == ("wood", "grass", "label 17")


def test_another_numbering_is_refused(lists):
    root = lists([(1, 0, WOOD)])
    (root / "category_reference.txt").write_text("Brick: 3\n")
    with pytest.raises(DataError, match="calls label 3 'brick', expected 'wood'"):
        read_pairs(root)


def test_clips_without_any_list_ask_for_one(tree, tmp_path):
    """The layout of copies that carry frames alone, under other names than the release's."""
    tree(*(f"grass/video_frame/rgb_image_{n:03d}.png" for n in range(3)))
    tree(*(f"grass/gelsight_frame/touch_image_{n:03d}.png" for n in (0, 1, 2, 7)))
    with pytest.raises(
        DataError, match=r"neither train.txt and test.txt nor label.txt .* keep_labels"
    ):
        read_pairs(tmp_path)
    found = read_pairs(tmp_path, keep_labels=True)
    assert [(p.vis.name, p.tac.name) for p in found.pairs] == [
        (f"rgb_image_{n:03d}.png", f"touch_image_{n:03d}.png") for n in range(3)
    ]
    assert found.materials() == ("grass",)
    assert whys(found)["grass"] == ("no image in video_frame", 1)


def test_lists_without_a_single_frame_say_what_was_left_out(lists):
    with pytest.raises(
        DataError, match=r"No pairs of Touch-and-Go .* none of the five materials \(1\)"
    ):
        read_pairs(lists([(1, 0, GRASS)]))
