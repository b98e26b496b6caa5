"""A CSV of pairs: what is read, what is skipped, what is refused."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnivat.data.materials import NO_CLASS
from omnivat.data.pairs import Pair
from omnivat.data.readers import read_pairs
from omnivat.kit.errors import DataError

HEADER = "vis,tac,domain,material"


@pytest.fixture
def table(tmp_path, tree):
    """Write pairs.csv beside three images and return its path."""
    tree("v.png", "t.png", "t_tac.png", "sub/v.png")

    def write(text, encoding="utf-8"):
        file = tmp_path / "pairs.csv"
        file.write_bytes(text.encode(encoding))
        return file

    return write


def test_a_row_gives_a_pair_with_all_that_is_known(table, tmp_path):
    """Also below a folder, by an absolute path or with backslashes."""
    table(
        f"{HEADER},object,split,part,looks_like,feels_like\n"
        f"sub\\v.png,{tmp_path / 't.png'},TAG, Wood ,chair,Train,Indoor, Felt ,\n"
    )
    found = read_pairs(tmp_path)
    assert found.pairs == (
        Pair(
            vis=tmp_path / "sub" / "v.png",
            tac=tmp_path / "t.png",
            domain="TAG",
            material="wood",
            object="chair",
            split="train",
            part="indoor",
            looks_like="felt",
        ),
    )
    assert found.origin == "table 'pairs.csv'"


def test_a_byte_order_mark_and_windows_line_ends_are_accepted(table):
    assert len(read_pairs(table(f"{HEADER}\r\nv.png,t.png,D,wood\r\n", "utf-8-sig")).pairs) == 1


@pytest.mark.parametrize(
    ("text", "vis", "tac"),
    [
        ("vis\nv.png\n", "v.png", "v.png"),
        ("vis,label\nv.png, Unlabelled\n", "v.png", "v.png"),
        ("tac\nt_tac.png\n", "t_tac.png", "t_tac.png"),
        ("vis,tac\nv.png,t_tac.png\n", "v.png", "t_tac.png"),
    ],
)
def test_of_one_row_a_picture_alone_stands_for_both(table, tmp_path, text, vis, tac):
    (pair,) = read_pairs(table(text)).pairs
    assert (pair.vis, pair.tac) == (tmp_path / vis, tmp_path / tac)
    assert (pair.domain, pair.material) == (tmp_path.name, NO_CLASS)


@pytest.mark.parametrize(
    ("row", "why"),
    [
        ("v.png,,TAG,wood", "'tac' is empty"),
        ("v.png,t.png", "'domain' is empty"),
        ("nowhere.png,t.png,TAG,wood", "the vis image is not there"),
        ("v.png," + "t" * 300 + ".png,TAG,wood", "the tac image is not there"),
        ("./v.png,t.png,TAG,Wood", "repeats an earlier row"),
    ],
)
def test_a_row_that_cannot_be_used_is_skipped_and_listed(table, reasons, row, why):
    found = read_pairs(table(f"{HEADER}\nv.png,t.png,TAG,wood\n\n{row}\n"))
    assert len(found.pairs) == 1
    assert why in reasons(found)["row 4"]


def test_the_same_images_under_two_materials_are_refused_with_both_rows(table):
    file = table(f"{HEADER}\nv.png,t.png,TAG,wood\nv.png,t.png,TAG,glass\n")
    with pytest.raises(DataError, match="the material 'wood' in row 2 and 'glass' in row 3"):
        read_pairs(file)


def test_strict_leaves_out_classes_beyond_the_five(table, reasons):
    file = table(f"{HEADER}\nv.png,t.png,TAG,wood\nt.png,v.png,TAG,felt\n")
    assert len(read_pairs(file).pairs) == 2
    assert reasons(read_pairs(file, strict=True))["row 3"].startswith("strict")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "none of its 0 rows"),
        ("vis\nt_tac.png\n", "a picture alone, whose name tells a touch"),
        ("tac\nt.png\n", "NAME_tac.png, or in a folder tac"),
        (f"{HEADER}\nx,y,D,wood\n", "The first reason, row 2: the vis image is not there"),
        ("vis,tac,domain,materials\nv.png,t.png,D,wood", "no column 'material'.*mean 'materials'"),
        ("v.png,t.png,TAG,wood\na,b,c,d", "no column 'vis'; its first row has v.png, t.png"),
        ("vis;tac\nv.png;t.png\n", "first row has vis;tac, expected .* separated by commas"),
        (f'{HEADER}\n"v.png,t.png,TAG,wood\n', "quotation mark that is not closed"),
        (f"{HEADER}\nv.png,t.png,TAG,wood,more\n", "more cells in line 2 than in its first row"),
        (f"{HEADER},split\nv.png,t.png,TAG,wood,tset\n", "no split 'tset'.*mean 'test'"),
    ],
)
def test_what_is_no_such_table_is_refused_in_one_sentence(table, text, message):
    with pytest.raises(DataError, match=message):
        read_pairs(table(text))


def test_another_encoding_is_refused_with_the_remedy(table):
    with pytest.raises(DataError, match="is not UTF-8 text. Save it as 'CSV UTF-8'"):
        read_pairs(table(f"{HEADER}\nv.png,t.png,D,h\xf6lzern\n", "latin-1"))


def test_a_file_that_is_no_csv_is_refused(tree):
    with pytest.raises(DataError, match="is a file, but pairs come from a folder or a CSV"):
        read_pairs(tree("a_vis.png") / "a_vis.png")


@given(
    st.text(st.sampled_from('v.pngt,\n\r"; \ufeff\0é\ud800'), max_size=60).map(
        lambda text: text.encode("utf-8", "surrogatepass")
    )
)
def test_any_bytes_are_read_or_refused_in_one_sentence(tmp_path_factory, content):
    folder = tmp_path_factory.mktemp("table")
    (folder / "v.png").write_bytes(b"")
    (folder / "pairs.csv").write_bytes(HEADER.encode() + b"\nv.png,v.png,D,wood\n" + content)
    try:
        assert read_pairs(folder).pairs
    except DataError as error:
        said = str(error)
        assert said.isprintable()
