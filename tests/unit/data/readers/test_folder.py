"""A plain folder of pairs: what is read, what is skipped, what is refused."""

import os
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from omnivat.data.materials import NO_CLASS
from omnivat.data.pairs import summary_table
from omnivat.data.readers import read_pairs
from omnivat.data.readers.folder import read
from omnivat.kit.errors import DataError

PAIR = "D/wood/a_*.png"


def test_a_simulated_domain_marks_the_set(tree):
    assert read_pairs(tree("TAG-sim/wood/a_*.png")).simulated


@pytest.mark.parametrize(
    ("files", "skipped"),
    [
        (["D/wood/b_vis.png"], {"D/wood/b": "no _tac image beside the other"}),
        (["D/wood/c_tac.png"], {"D/wood/c": "no _vis image beside the other"}),
        (
            ["D/wood/b_*.png", "D/wood/b_vis.jpg"],
            {"D/wood/b": "vis is there more than once: b_vis.jpg and b_vis.png"},
        ),
        (["D/wood/p.png"], {"D/wood/p.png": "its name ends neither in _vis nor in _tac"}),
        (["D/wood/a_vis.docx"], {"D/wood/a_vis.docx": "'.docx' is not a suffix of images"}),
        (["D/wood/._a_vis.png", ".git/wood/a_vis.png", "D/wood/notes.txt", "D/rest.png"], {}),
    ],
)
def test_what_is_no_pair_is_skipped_and_listed(tree, reasons, files, skipped):
    found = read(tree(PAIR, *files))
    assert (len(found.pairs), reasons(found)) == (1, skipped)


@pytest.mark.parametrize(
    ("files", "pairs"),
    [
        (["TAG/Wood/a_*.png", "TAG/felt/a_*.png"], [("TAG", "wood", ""), ("TAG", "felt", "")]),
        # an object in a class is another thing than that of the same name in another class
        (
            ["D/wood/1/a_*.png", "D/glass/1/a_*.png"],
            [("D", "glass", "glass/1"), ("D", "wood", "wood/1")],
        ),
        # halves may differ in format and case
        (["D/wood/a_VIS.JPG", "D/wood/a_tac.webp"], [("D", "wood", "")]),
        (["D/wood/1/2/a_*.png"], [("D", "wood", "wood/1/2")]),
        (["D/wood/vis/a.png", "D/wood/Tac/a.png"], [("D", "wood", "")]),
        (["D/a_vis.png", "D/b_vis.png"], [("D", NO_CLASS, "")] * 2),
    ],
)
def test_folders_name_what_they_can_and_pictures_alone_stand_for_both(tree, files, pairs):
    root = tree(*files)
    found = read(root)
    assert [(p.domain, p.material, p.object) for p in found.pairs] == [
        (domain or root.name, *more) for domain, *more in pairs
    ]
    alone = len(files) == len(pairs) and "*" not in files[0]
    assert all((p.vis == p.tac) is alone for p in found.pairs)
    ending = ", one picture of each pair" if alone else ""
    assert found.origin == f"folder '{root.name}'{ending}" and not found.skipped


@pytest.mark.parametrize(
    ("files", "pairs"),
    [
        (["train/wood/a_*.png", "Test/wood/a_*.png"], [("", "train"), ("", "test")]),
        (["val_set/D/wood/a_*.png"], [("D", "val")]),
        (["1_train_images/wood/a_*.png", "test data/wood/a_*.png"], [("", "train"), ("", "test")]),
        (["D/wood/train/a_*.png"], [("D", "train")]),
        (["wood_train/a_*.png", "wood_Test/b_*.png"], [("", "train"), ("", "test")]),
        (["D_training/wood/a_*.png", "D_test/wood/b_*.png"], [("D", "train"), ("D", "test")]),
    ],
)
def test_folders_called_after_a_split_are_splits_and_never_domains(tree, files, pairs):
    root = tree(*files)
    found = read(root)
    assert {(p.domain, p.split, p.material) for p in found.pairs} == {
        (domain or root.name, split, "wood") for domain, split in pairs
    }


def test_a_split_beside_a_domain_is_a_question_and_a_class_called_train_is_a_class(tree):
    assert read(tree("D/wood/a_*.png", "D/train/a_*.png")).materials() == ("wood", "train")
    with pytest.raises(DataError, match="Is 'test' beside 'D' a split or a domain"):
        read(tree("test/wood/a_*.png"))


@pytest.mark.parametrize("where", ["{}/a.png", "{}/wood/a.png", "D/wood/{}/a.png"])
def test_photos_and_touches_are_paired_from_folders_whose_words_tell_or_that_are_named(tree, where):
    root = tree(where.format("rgb"), where.format("gelsight_mini"))
    (pair,) = read(root).pairs
    assert ("rgb" in pair.vis.parts, "gelsight_mini" in pair.tac.parts) == (True, True)
    assert pair.material == ("wood" if "wood" in where else NO_CLASS)
    tree(where.format("left"))
    (other,) = read_pairs(root, vis="RGB", tac="left").pairs
    assert other.vis == pair.vis and "left" in other.tac.parts


@pytest.mark.parametrize(
    ("photo", "touch"),
    [
        ("D/wood/1_rgb.jpg", "D/wood/1_GelSight.png"),
        ("D/wood/vis/e\u0301_1.png", "D/wood/tac/\u00e9_1.png"),
        ("rgb/D/wood/img_7.jpg", "gelsight/D/wood/7.png"),
        ("D\u00e9/wood/1_vis.png", "De\u0301/wood/1_tac.png"),
    ],
)
def test_photo_and_touch_are_one_pair_by_a_last_word_by_number_and_in_any_unicode_form(
    tree, photo, touch
):
    (pair,) = read(tree(photo, touch)).pairs
    assert (pair.vis.name, pair.tac.name) == (photo.split("/")[-1], touch.split("/")[-1])
    assert pair.material == "wood"


def test_a_word_that_begins_a_name_tells_its_half_and_one_inside_is_a_question(tree):
    found = read(tree("D/wood/rgb_1.png", "D/wood/tactile_1.png", "D/wood/tactile_2.png"))
    assert [(p.vis.name, p.tac.name) for p in found.pairs] == [("rgb_1.png", "tactile_1.png")]
    assert [one.why for one in found.skipped] == ["no _vis image beside the other"]
    root = tree("E/wood/1_rgb.png", "E/wood/1_gelsight_left.png")
    with pytest.raises(DataError, match="1_gelsight_left.png' has a word of touches inside"):
        read(root / "E")


def test_numbers_pair_only_names_of_one_wording_each(tree):
    with pytest.raises(DataError, match=r"rgb, gelsight.*3 skipped"):
        read(tree("rgb/wood/img_1.png", "rgb/wood/top_2.png", "gelsight/wood/gel_1.png"))


@pytest.mark.parametrize("other", ["wood", "WOOD", "Wood ", "Ｗｏｏｄ"])
def test_two_classes_of_one_name_are_refused_with_both_folders(tree, other):
    root = tree("D/Wood/a_*.png", f"D/{other}/b_*.png")
    with pytest.raises(DataError, match="Two classes of one name") as caught:
        read(root)
    assert str(root / "D" / "Wood") in str(caught.value)
    assert str(root / "D" / other) in str(caught.value)


def test_strict_leaves_out_classes_beyond_the_five(tree, reasons):
    found = read(tree(PAIR, "D/felt/a_*.png"), strict=True)
    assert found.materials() == ("wood",)
    assert reasons(found)["D/felt/a"].startswith("strict: not one of wood, steel")


@pytest.mark.parametrize(
    ("files", "message"),
    [
        (["TAG/wood/a_*.png", "tag/wood/a_*.png"], "Two domains of one name"),
        ([], r"No pairs in '.*'; expected <domain>/<class>/<name>_vis.png"),
        (["D/a_vis.png", "D/b_tac.png"], r"2 skipped, such as 'D/a': no _tac image"),
        (["videos.csv"], "holds recordings; make pairs of them first"),
        (["wood/a.mp4"], "holds films, such as 'wood/a.mp4', and no table.*Write videos.csv"),
    ],
)
def test_a_folder_without_pairs_says_what_was_wanted(tree, files, message):
    with pytest.raises(DataError, match=message):
        read(tree(*files))


def test_a_domain_with_the_name_of_the_total_is_refused_before_anything_is_embedded(tree):
    with pytest.raises(DataError, match="A domain is called 'all'.*rename the domain"):
        read_pairs(tree("all/wood/a_*.png"))


def test_links_in_circles_end_and_add_no_pair(tree, reasons):
    root = tree(PAIR)
    (root / "D" / "up").symlink_to(root)
    (root / "D" / "wood" / "b_vis.png").symlink_to(root / "nowhere")
    (root / "D" / "wood" / "c_vis.png").mkdir()
    (root / "E").symlink_to(root / "D")
    (root / "self").symlink_to(root / "self")
    found = read(root)
    assert len(found.pairs) == 1
    assert reasons(found) == {
        "D/up": "leads to a folder that is read already",
        "D/wood/b_vis.png": "cannot be opened (a broken link?)",
        "E": "leads to a folder that is read already",
    }


@pytest.mark.skipif(
    os.name == "nt" or os.uname().sysname == "Darwin", reason="names are text there"
)
def test_names_that_are_not_utf8_are_skipped_and_can_be_printed(tree):
    odd = os.fsdecode(b"\xff\xfe")
    found = read(tree(PAIR, f"D/wood/{odd}_*.png"))
    assert len(found.pairs) == 1
    assert summary_table(found).encode("utf-8")
    assert [skipped.why for skipped in found.skipped] == [
        "a name in its path is not UTF-8; rename it"
    ] * 2


def test_a_folder_without_permission_is_listed(tree, reasons, monkeypatch):
    root = tree(PAIR, "D/glass/a_*.png")
    monkeypatch.setattr("os.access", lambda path, mode: Path(path).name != "glass")
    assert reasons(read(root)) == {"D/glass": "may not be opened: its permissions forbid it"}


names = st.text(
    st.sampled_from("aW \u00e9\uff37\n'\"_.-\u200b\U0001f600"), min_size=1, max_size=6
).filter(lambda name: name.strip(".") and len(name.encode()) < 100)
endings = st.sampled_from(
    ["_vis.png", "_tac.png", "_VIS.jpg", "_tac.txt", "_vis", ".png", "_tac.npy"]
)


@settings(max_examples=60)
@given(st.lists(st.tuples(names, names, names, endings), max_size=12))
def test_any_tree_is_read_or_refused_in_one_sentence(tmp_path_factory, tree):
    """And no image is in two pairs, and every pair's two halves are there."""
    root = tmp_path_factory.mktemp("tree")
    for domain, group, name, ending in tree:
        path = root / domain / group / (name + ending)
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(b"")
    try:
        found = read_pairs(root)
    except DataError as error:
        said = str(error)
        assert said.isprintable()
        return
    files = [file for p in found.pairs for file in {p.vis, p.tac}]  # of one modality, one
    assert len(set(files)) == len(files)
    assert all(file.is_file() for file in files)
    assert all(line.isprintable() for line in summary_table(found).split("\n"))
