"""A plain folder of pairs: what is read, what is skipped, what is refused."""

import os
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from omnivat.data.pairs import summary_table
from omnivat.data.readers import read_pairs
from omnivat.data.readers.folder import read
from omnivat.kit.errors import DataError


def reasons(pairs):
    return {skipped.what: skipped.why for skipped in pairs.skipped}


def test_domain_and_class_come_from_the_folders(tmp_path, pair):
    pair(tmp_path / "TAG" / "Wood", "a")
    pair(tmp_path / "TAG" / "felt", "a")
    found = read(tmp_path)
    assert [(p.domain, p.material) for p in found.pairs] == [("TAG", "wood"), ("TAG", "felt")]
    assert found.pairs[0].vis == tmp_path / "TAG" / "Wood" / "a_vis.png"
    assert not found.skipped
    assert not found.simulated


def test_halves_may_differ_in_format_and_case(tmp_path, pair):
    pair(tmp_path / "D" / "wood", "a", vis=".JPG", tac=".webp")
    pair(tmp_path / "D" / "wood", "b", vis=".tif", tac=".bmp")
    pair(tmp_path / "D" / "wood", "c.v2")
    (tmp_path / "D" / "wood" / "a_vis.JPG").rename(tmp_path / "D" / "wood" / "a_VIS.JPG")
    assert len(read(tmp_path).pairs) == 3


def test_a_folder_in_a_class_is_an_object(tmp_path, pair):
    pair(tmp_path / "D" / "wood" / "1", "a")
    pair(tmp_path / "D" / "glass" / "1", "a")
    names = [p.object for p in read(tmp_path).pairs]
    assert names == ["glass/1", "wood/1"]  # another thing of the same number


def test_a_simulated_domain_marks_the_set(tmp_path, pair):
    pair(tmp_path / "TAG-sim" / "wood", "a")
    assert read(tmp_path).simulated


def test_half_a_pair_is_skipped_and_listed(tmp_path, pair, put):
    pair(tmp_path / "D" / "wood", "a")
    put(tmp_path / "D" / "wood" / "b_vis.png")
    put(tmp_path / "D" / "wood" / "c_tac.png")
    found = read(tmp_path)
    assert len(found.pairs) == 1
    assert reasons(found) == {
        "D/wood/b": "no _tac image beside the other",
        "D/wood/c": "no _vis image beside the other",
    }


def test_a_half_that_is_there_twice_is_skipped_with_both_names(tmp_path, pair, put):
    pair(tmp_path / "D" / "wood", "a")
    pair(tmp_path / "D" / "wood", "b")
    put(tmp_path / "D" / "wood" / "b_vis.jpg")
    found = read(tmp_path)
    assert len(found.pairs) == 1
    assert "b_vis.jpg and b_vis.png" in reasons(found)["D/wood/b"]


@pytest.mark.parametrize(
    ("name", "why"),
    [
        ("photo.png", "ends neither in _vis nor in _tac"),
        ("a_vis.docx", "'.docx' is not a suffix of images"),
        ("_vis.png", "only _vis or _tac"),
    ],
)
def test_other_names_are_skipped_with_a_reason(tmp_path, pair, put, name, why):
    pair(tmp_path / "D" / "wood", "ok")
    put(tmp_path / "D" / "wood" / name)
    assert why in reasons(read(tmp_path))[f"D/wood/{name}"]


def test_hidden_files_and_notes_pass_unseen(tmp_path, pair, put):
    pair(tmp_path / "D" / "wood", "a")
    put(tmp_path / "D" / "wood" / "._a_vis.png")
    put(tmp_path / ".git" / "wood" / "a_vis.png")
    (tmp_path / "D" / "wood" / "notes.txt").write_text("bought in May")
    found = read(tmp_path)
    assert (len(found.pairs), found.skipped) == (1, ())


@pytest.mark.parametrize("other", ["wood", "WOOD", "Wood ", "Ｗｏｏｄ"])
def test_two_classes_of_one_name_are_refused_with_both_folders(tmp_path, pair, other):
    pair(tmp_path / "D" / "Wood", "a")
    pair(tmp_path / "D" / other, "b")
    with pytest.raises(DataError, match="Two classes of one name") as caught:
        read(tmp_path)
    assert str(tmp_path / "D" / "Wood") in str(caught.value)
    assert str(tmp_path / "D" / other) in str(caught.value)


def test_one_class_written_in_two_ways_in_two_domains_is_one_class(tmp_path, pair):
    pair(tmp_path / "A" / "Wood", "a")
    pair(tmp_path / "B" / "wood", "a")
    assert read(tmp_path).materials() == ("wood",)


def test_two_domains_of_one_name_are_refused(tmp_path, pair):
    pair(tmp_path / "TAG" / "wood", "a")
    pair(tmp_path / "tag" / "wood", "a")
    with pytest.raises(DataError, match="Two domains of one name"):
        read(tmp_path)


def test_strict_leaves_out_classes_beyond_the_five(tmp_path, pair):
    pair(tmp_path / "D" / "wood", "a")
    pair(tmp_path / "D" / "felt", "a")
    found = read(tmp_path, strict=True)
    assert found.materials() == ("wood",)
    assert reasons(found)["D/felt"].startswith("strict: not one of wood, steel")


@pytest.mark.parametrize("depth", [(), ("wood",)])
def test_a_folder_too_near_to_the_top_is_named(tmp_path, pair, depth):
    pair(tmp_path.joinpath(*depth), "a")
    with pytest.raises(DataError, match="lack a folder for their domain or class"):
        read(tmp_path)


def test_an_empty_folder_says_what_was_wanted(tmp_path):
    with pytest.raises(
        DataError, match=r"No pairs in '.*'; expected <domain>/<class>/<name>_vis.png"
    ):
        read(tmp_path)


def test_a_folder_of_lone_halves_says_the_first_reason(tmp_path, put):
    put(tmp_path / "D" / "wood" / "a_vis.png")
    with pytest.raises(DataError, match=r"1 skipped, such as 'D/wood/a': no _tac image"):
        read(tmp_path)


def test_links_in_circles_end_and_add_no_pair(tmp_path, pair):
    pair(tmp_path / "D" / "wood", "a")
    (tmp_path / "D" / "up").symlink_to(tmp_path)
    (tmp_path / "D" / "wood" / "round").symlink_to(tmp_path / "D" / "wood")
    (tmp_path / "E").symlink_to(tmp_path / "D")
    (tmp_path / "self").symlink_to(tmp_path / "self")
    found = read(tmp_path)
    assert len(found.pairs) == 1
    assert reasons(found)["D/up"] == "leads back to a folder that it lies in"
    assert reasons(found)["E"] == "leads to the same folder as 'D'"


def test_a_broken_link_and_a_folder_named_like_an_image_are_skipped(tmp_path, pair):
    pair(tmp_path / "D" / "wood", "a")
    (tmp_path / "D" / "wood" / "b_vis.png").symlink_to(tmp_path / "nowhere")
    (tmp_path / "D" / "wood" / "c_vis.png").mkdir()
    found = read(tmp_path)
    assert reasons(found)["D/wood/b_vis.png"] == "cannot be opened (a broken link?)"
    assert reasons(found)["D/wood/c_vis.png"] == "a folder with the name of an image"


@pytest.mark.skipif(
    os.name == "nt" or os.uname().sysname == "Darwin", reason="names are text there"
)
def test_names_that_are_not_utf8_are_skipped_and_can_be_printed(tmp_path, pair, image_bytes):
    pair(tmp_path / "D" / "wood", "a")
    folder = os.fsencode(tmp_path / "D" / "wood")
    for half in (b"_vis", b"_tac"):
        Path(os.fsdecode(folder + b"/\xff\xfe" + half + b".png")).write_bytes(image_bytes)
    found = read(tmp_path)
    assert len(found.pairs) == 1
    assert summary_table(found).encode("utf-8")
    assert [skipped.why for skipped in found.skipped] == [
        "the file's name is not UTF-8; rename it"
    ] * 2


def test_a_folder_without_permission_is_listed(tmp_path, pair, monkeypatch):
    pair(tmp_path / "D" / "wood", "a")
    pair(tmp_path / "D" / "glass", "a")
    monkeypatch.setattr("os.access", lambda path, mode: Path(path).name != "glass")
    assert reasons(read(tmp_path)) == {"D/glass": "may not be opened: its permissions forbid it"}


def test_a_path_that_is_not_there_is_named(tmp_path):
    with pytest.raises(DataError, match="There is no folder or file at"):
        read_pairs(tmp_path / "nowhere")


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


def test_a_domain_with_the_name_of_the_total_is_refused_before_anything_is_embedded(tmp_path, pair):
    pair(tmp_path / "all" / "wood", "a")
    with pytest.raises(DataError, match="A domain is called 'all'.*rename the domain"):
        read_pairs(tmp_path)
