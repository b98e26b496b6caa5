"""A CSV of pairs: what is read, what is skipped, what is refused."""

import pytest

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


@pytest.mark.parametrize(("alone", "pairs", "there"), [(1, 19, ("vis", "tac")), (5, 20, ("tac",))])
def test_rows_without_a_photo_are_left_out_if_few_and_make_a_set_of_touches_if_many(
    table, tree, reasons, alone, pairs, there
):
    tree(*(f"t{k}.png" for k in range(20)))
    rows = [f"{'' if k < alone else 'v.png'},t{k}.png,rig,wood,mug,test" for k in range(20)]
    found = read_pairs(table(f"{HEADER},object,split\n" + "\n".join(rows)))
    assert (len(found.pairs), found.modalities()) == (pairs, there)
    assert {(p.domain, p.object, p.split) for p in found.pairs} == {("rig", "mug", "test")}
    assert reasons(found) == {f"row {k + 2}": "'vis' is empty" for k in range(20 - pairs)}


def test_a_laboratory_s_spreadsheet_loses_no_object(tmp_path, tree):
    """A title, a sheet of notes, merged cells, paths of another machine, suffixes left out."""
    openpyxl = pytest.importorskip("openpyxl")
    tree("in/v1.png", "in/v2.png", "in/t1.png", "in/t2.png")
    book = openpyxl.Workbook()
    book.active.append(["Notes"])
    sheet = book.create_sheet("May")
    for row in (
        ["Presses of May"],
        ["Photo", "Touch file", "Category", "Specimen", "Set", "Sensor type"],
        ["C:\\rec\\in\\V1.png", "in/t1", "Wood", "mug 1", "Train", "Mini"],
        ["/srv/rec/in/v2.png", "in/t2", None, None, "Train", "mini "],
        ["in/v1.png", "in/t2", "wood", "MUG  1", "Train", "Mini"],
    ):
        sheet.append(row)
    sheet.merge_cells("C3:C4")
    sheet.merge_cells("D3:D4")
    book.save(tmp_path / "book.xlsx")
    found = read_pairs(tmp_path / "book.xlsx")
    assert [(p.vis.name, p.tac.name) for p in found.pairs] == [
        ("v1.png", "t1.png"),
        ("v2.png", "t2.png"),
        ("v1.png", "t2.png"),
    ]
    assert {(p.domain, p.material, p.object, p.split) for p in found.pairs} == {
        ("Mini", "wood", "mug 1", "train")
    }
    assert "sheet 'May'" in found.origin


def test_a_sheet_that_is_used_to_its_last_cell_is_read_by_its_filled_ones(tmp_path, tree):
    openpyxl = pytest.importorskip("openpyxl")
    tree("v.png", "t.png")
    book = openpyxl.Workbook()
    book.active.append(["vis", "tac", "material"])
    book.active.cell(1_048_576, 3).value = "steel"
    book.active.cell(1_048_576, 2).value = "t.png"
    book.active.cell(1_048_576, 1).value = "v.png"
    book.active.cell(1_048_575, 16_384).number_format = "0.0"
    book.save(tmp_path / "book.xlsx")
    assert [pair.material for pair in read_pairs(tmp_path / "book.xlsx").pairs] == ["steel"]


def test_a_formula_that_no_spreadsheet_has_computed_is_named(tmp_path, tree):
    openpyxl = pytest.importorskip("openpyxl")
    tree("v.png", "t.png")
    book = openpyxl.Workbook()
    for row in (["vis", "tac", "material"], ["v.png", "t.png", '=LOWER("Wood")']):
        book.active.append(row)
    book.save(tmp_path / "book.xlsx")
    with pytest.raises(DataError, match="a formula in line 2 that was never computed; open it in"):
        read_pairs(tmp_path / "book.xlsx")


def test_a_byte_order_mark_and_windows_line_ends_are_accepted(table):
    assert len(read_pairs(table(f"{HEADER}\r\nv.png,t.png,D,wood\r\n", "utf-8-sig")).pairs) == 1


@pytest.mark.parametrize(
    ("text", "vis", "tac"),
    [
        ("vis\nv.png\n", "v.png", "v.png"),
        ("vis,label\nv.png, Unlabelled\n", "v.png", "v.png"),
        ("tac\nt.png\n", "t.png", "t.png"),  # the column tells the modality, not the name
        ("vis,tac\nv.png,t_tac.png\n", "v.png", "t_tac.png"),
        ("vis,tac\nt_tac.png,t_tac.png\n", "t_tac.png", "t_tac.png"),  # one picture, twice
        ("Photo;Tactile image\nv.png;t.png\n", "v.png", "t.png"),
        ("sep=;\nvis;tac\nv.png;t.png\n", "v.png", "t.png"),
        ("vis\ttac\nV.PNG\tt.png\n", "v.png", "t.png"),
        ("vis,tac,vis_from\n,t.png,v.png\n", "t.png", "t.png"),  # the column vis is there
        ("photo,gelsight,touch_depth,tac_before\nv.png,t.png,2,v.png\n", "v.png", "t.png"),
    ],
)
def test_of_one_row_a_picture_alone_stands_for_both(table, tmp_path, text, vis, tac):
    found = read_pairs(table(text))
    (pair,) = found.pairs
    assert (pair.vis, pair.tac) == (tmp_path / vis, tmp_path / tac)
    both = ("vis", "tac") if vis != tac else ("vis" if vis == "v.png" else "tac",)
    assert found.modalities() == both
    assert (pair.domain, pair.material) == (tmp_path.name, NO_CLASS)


@pytest.mark.parametrize(
    ("row", "why"),
    [
        (",,TAG,wood", "'vis' is empty"),
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


def test_of_touches_alone_a_row_of_a_photo_is_left_out(table, reasons):
    found = read_pairs(table("vis,tac\n,t.png\n,t_tac.png\nv.png,\n"))
    assert (len(found.pairs), found.modalities()) == (2, ("tac",))
    assert reasons(found)["row 4"] == "it has no tac image, and the set is of touches alone"


def test_strict_leaves_out_classes_beyond_the_five(table, reasons):
    file = table(f"{HEADER}\nv.png,t.png,TAG,wood\nt.png,v.png,TAG,felt\n")
    assert len(read_pairs(file).pairs) == 2
    assert reasons(read_pairs(file, strict=True))["row 3"].startswith("strict")


def test_the_same_images_under_two_materials_are_refused_with_both_rows(table):
    file = table(f"{HEADER}\nv.png,t.png,TAG,wood\nv.png,t.png,TAG,glass\n")
    with pytest.raises(DataError, match="the material 'wood' in row 2 and 'glass' in row 3"):
        read_pairs(file)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "none of its 0 rows"),
        ("vis,touch_a,touch_b\nv.png,t.png,t.png", "touch_a, touch_b; name one with --tac COLUMN"),
        (f"{HEADER}\nx,y,D,wood\n", "The first reason, row 2: the vis image is not there"),
        ("vis,tac,domain,materials\nv.png,t.png,D,wood", "no column 'material'.*mean 'materials'"),
        ("v.png,t.png,TAG,wood\na,b,c,d", "no column 'vis'; its first row has v.png, t.png"),
        (f'{HEADER}\n"v.png,t.png,TAG,wood\n', "quotation mark that is not closed"),
        (f"{HEADER}\nv.png,t.png,TAG,wood,more\n", "more cells in line 2 than in its first row"),
        (f"{HEADER},split\nv.png,t.png,TAG,wood,tset\n", "no split 'tset'.*mean 'test'"),
    ],
)
def test_what_is_no_such_table_is_refused_in_one_sentence(table, text, message):
    with pytest.raises(DataError, match=message):
        read_pairs(table(text))


@pytest.mark.parametrize("encoding", ["latin-1", "cp1252", "utf-16", "utf-16-le", "utf-16-be"])
@pytest.mark.parametrize("cells", [",", ";", "\t", "|"])
def test_tables_of_other_encodings_and_separators_are_read_and_old_ones_noted(
    table, encoding, cells
):
    text = f"{HEADER},object\nv.png,t.png,D,h\xf6lzern,Krug\n"
    found = read_pairs(table(text.replace(",", cells), encoding))
    assert [(p.material, p.object) for p in found.pairs] == [("h\xf6lzern", "Krug")]
    assert ("read as Windows-1252" in found.origin) is (encoding in ("latin-1", "cp1252"))


def test_bytes_that_are_no_text_are_refused_with_the_remedy(table):
    file = table("")
    file.write_bytes(b"\xff\x81\x00\x00\x01,\x90")
    with pytest.raises(DataError, match="is not UTF-8 text. Save it as 'CSV UTF-8'"):
        read_pairs(file)


def test_of_two_columns_of_one_name_the_first_is_used_and_the_other_is_named(table):
    found = read_pairs(table("vis,tac,material,note,Material\nv.png,t.png,wood,,steel\n"))
    assert found.pairs[0].material == "wood" and "not used: material (2)" in found.origin
    with pytest.raises(DataError, match="touch, touch .2.; name one with --tac COLUMN"):
        read_pairs(table("vis,touch,touch\nv.png,t.png,t_tac.png\n"))


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("a_vis.png", "is a file, but pairs come from a folder or a CSV"),
        ("a.npz", "make a folder of pairs first: `python -m omnivat import .*a.npz --out PAIRS`"),
    ],
)
def test_a_file_that_is_no_csv_is_refused(tree, name, message):
    with pytest.raises(DataError, match=message):
        read_pairs(tree(name) / name)
