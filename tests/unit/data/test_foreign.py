"""`omnivat import`: embeddings made elsewhere, from each kind of file, checked and named."""

import csv
import sys
from typing import Any
from zipfile import ZipFile

import numpy as np
import pytest
import torch
from safetensors.numpy import save_file
from safetensors.torch import save_file as save_torch

from omnivat.cli import main
from omnivat.data import columns
from omnivat.data.columns import columns_of
from omnivat.data.foreign import import_embeddings
from omnivat.data.named_columns import received
from omnivat.data.npz import read_npz
from omnivat.data.parquet import part
from omnivat.data.store import load_embeddings
from omnivat.kit.errors import DataError
from omnivat.kit.limited import Limited
from omnivat.study.shift import read_features

COUNT = 6
Table = dict[str, Any]


@pytest.fixture
def table():
    random = np.random.default_rng(0)
    return {
        "vis": random.normal(size=(COUNT, 4)).astype(np.float32),
        "tac": random.normal(size=(COUNT, 4)).astype(np.float32),
        "domain": np.array(["TAG", "TAG", "TAG", "Mine ü", "Mine ü", "Mine ü"]),
        "material": np.array(["steel", "wood", "cork"] * 2),
        "object": np.array([f"o{i}" for i in range(COUNT)]),
        "split": np.array(["train", "test"] * 3),
    }


def write_npz(table, file):
    np.savez(file, **table)


def write_parquet(table, file):
    pyarrow = pytest.importorskip("pyarrow")
    import pyarrow.parquet as parquet

    columns = {name: pyarrow.array(array.tolist()) for name, array in table.items()}
    for name in ("material", "domain"):  # as categories of pandas are written
        if name in columns:
            columns[name] = columns[name].dictionary_encode()
    parquet.write_table(pyarrow.table(columns), file)


def write_hdf5(table, file):
    h5py = pytest.importorskip("h5py")
    with h5py.File(file, "w") as handle:
        for name, array in table.items():
            handle[name] = array.tolist() if array.dtype.kind == "U" else array
        if names := [*dict.fromkeys(table.get("material", np.array([])).tolist())]:
            numbers = [names.index(name) for name in table["material"]]
            kind = h5py.enum_dtype({name: k for k, name in enumerate(names)}, basetype="u1")
            del handle["material"]
            handle.create_dataset("material", data=np.array(numbers, "u1"), dtype=kind)


def write_csv(table, file):
    columns = {}
    for name, array in table.items():
        if array.ndim == 2:
            columns |= {f"{name}_{i}": array[:, i] for i in range(array.shape[1])}
        else:
            columns[name] = array
    with file.open("w", newline="", encoding="utf-8") as handle:
        writer = csv.writer(handle)
        writer.writerow(columns)
        writer.writerows(zip(*columns.values(), strict=True))


WRITERS = {
    "set.npz": write_npz,
    "set.parquet": write_parquet,
    "set.h5": write_hdf5,
    "set.csv": write_csv,
}


@pytest.mark.parametrize("name", WRITERS)
def test_each_kind_of_file_becomes_the_same_set(table, tmp_path, name):
    WRITERS[name](table, tmp_path / name)
    out = tmp_path / "out.safetensors"
    assert main(["import", str(tmp_path / name), "--encoder", "Sparsh", "--out", str(out)]) == 0
    found = load_embeddings(out)
    np.testing.assert_allclose(found.vis, table["vis"], rtol=1e-6)
    np.testing.assert_allclose(found.tac, table["tac"], rtol=1e-6)
    header = found.header
    assert (header.encoder, header.domains) == ("imported:Sparsh", ("TAG", "Mine ü"))
    assert header.classes == ("wood", "steel", "cork")
    assert header.origin == f"imported from {name}"
    assert [header.classes[i] for i in found.label] == list(table["material"])
    assert found.rows["object"] == list(table["object"])
    assert found.rows["split"] == list(table["split"])
    assert found.rows["vis"][2] == "set/2_vis"


def test_columns_as_people_write_them_lose_no_object_and_none_is_taken_of_two(table, tmp_path):
    theirs = {"vis": "Vis", "tac": "TAC", "material": "Class Name", "object": "Object ID"}
    renamed = {theirs.get(name, name): array for name, array in table.items()}
    for name, write in WRITERS.items():
        write(renamed, tmp_path / name)
        found = import_embeddings(tmp_path / name, encoder="x")
        assert found.rows["object"] == list(table["object"])
        assert [found.header.classes[i] for i in found.label] == list(table["material"])
    text = (tmp_path / "set.csv").read_text("utf-8").replace("split", "Class Name")
    (tmp_path / "two.csv").write_text(text, "utf-8")
    with pytest.raises(DataError, match="has no column 'material'"):
        import_embeddings(tmp_path / "two.csv", encoder="x")
    with pytest.raises(DataError, match="has 2 columns called Class Name; rename or leave out"):
        import_embeddings(tmp_path / "two.csv", encoder="x", columns={"material": "Class Name"})


def test_the_narrower_vectors_end_in_zeros_and_the_header_says_so(table, tmp_path):
    table["tac"] = table["tac"][:, :3]
    write_npz(table, tmp_path / "a.npz")
    found = import_embeddings(tmp_path / "a.npz", encoder="x")
    assert found.tac.shape == (COUNT, 4) and not found.tac[:, 3].any()
    assert "vis 4, tac 3 values, then zeros" in found.header.preprocessing


@pytest.mark.parametrize(
    ("change", "match"),
    [
        (lambda t: [t.pop("vis"), t.pop("tac")], "no vectors 'vis' or 'tac'; it has domain"),
        (
            lambda t: t.update(gelsight=t.pop("tac"), digit=t["vis"]),
            "has gelsight, digit; name one with --column tac=THEIRS",
        ),
        (lambda t: t.update(material=np.array([""] * 6)), "no material in any row"),
        (lambda t: t.pop("material"), "no column 'material'; pass --column material"),
        (lambda t: t.pop("domain"), "no column 'domain'; pass --domain"),
        (lambda t: t.update(tac=t["tac"][:5]), r"tac of shape \(5, 4\), expected \(6, D\)"),
        (lambda t: t.update(vis=t["vis"] * np.nan), "has nan in vis, row 0"),
        (
            lambda t: t["domain"].__setitem__(2, "\ud800"),
            "domain in row 2 .* which no file can hold",
        ),
        (lambda t: t.update(vis=np.full((6, 4), "x")), "has no numbers in vis"),
        (lambda t: t.update(material=np.arange(6)), "number 5 as a material.*name 6 classes with"),
        (lambda t: t.update(domain=np.array(["a"] * 5 + [""])), "no domain in row 5"),
        (lambda t: t.update(vis=np.array(["v.png"] * 6)), "names pictures in vis.*as .*a.csv, and"),
        (lambda t: t.update(split=np.array(["tset"] * 6)), "row 0: there is no split 'tset'"),
        (lambda t: t.update(object=np.array([{}] * 6)), "pickled objects"),
    ],
)
def test_what_does_not_fit_is_refused_by_name(table, tmp_path, change, match):
    change(table)
    write_npz(table, tmp_path / "a.npz")
    with pytest.raises(DataError, match=match) as caught:
        import_embeddings(tmp_path / "a.npz", encoder="x")
    assert "a.npz" in str(caught.value)


@pytest.mark.parametrize("name", ["set.npz", "set.safetensors"])
def test_a_file_that_is_not_what_its_ending_says_is_refused(tmp_path, name):
    (tmp_path / name).write_bytes(b"\x00\x01nothing")
    with pytest.raises(DataError, match=f"{name}' (is not an NPZ file|cannot be read)"):
        import_embeddings(tmp_path / name, encoder="x")


def test_a_small_file_of_large_arrays_is_refused(table, tmp_path):
    write_npz(table, tmp_path / "a.npz")
    with pytest.raises(DataError, match="its arrays have over 0 MB"):
        read_npz(tmp_path / "a.npz", 10)


def test_numbered_columns_are_found_by_any_name_and_all_of_them_are_needed(tmp_path):
    file = tmp_path / "a.csv"
    for numbers, whole in ((range(3), True), ((0, 2, 3), False)):
        names = [*(f"img(_{k}" for k in numbers), "tac_0", "domain", "material"]
        rows = ["1,2,3,4,d,wood", "2,3,4,5,d,steel"]
        file.write_text("\n".join([",".join(names), *rows]))
        if whole:
            found = import_embeddings(file, encoder="x", columns={"vis": "img("})
            assert found.vis.tolist() == [[1, 2, 3], [2, 3, 4]]
            continue
        with pytest.raises(DataError, match=r"lacks some of the columns img\(_0 to img\(_3"):
            import_embeddings(file, encoder="x", columns={"vis": "img("})


@pytest.mark.parametrize("kind", ["U4", "i8", "f4", "S4"])
def test_numbered_labels_of_any_type_have_the_names_that_are_given(table, tmp_path, kind):
    table["material"] = np.array([[0], [1], [2]] * 2).astype(kind)  # as a column of a matrix
    write_npz(table, tmp_path / "a.npz")
    names = ("felt", "wood", "cork")
    found = import_embeddings(tmp_path / "a.npz", encoder="x", classes=names)
    assert [found.header.classes[k] for k in found.label] == [*names, *names]
    told = import_embeddings(tmp_path / "a.npz", encoder="x", classes=None)
    assert set(told.header.classes) == {"class 0", "class 1", "class 2"}


@pytest.mark.parametrize("missing", [-1.0, np.nan, "", "-1"])
def test_pairs_without_a_class_are_left_out_and_named(table, tmp_path, missing):
    labels = [0, 1, missing, 1, 0, 1]
    table["material"] = np.array(labels if not isinstance(missing, str) else [*map(str, labels)])
    write_npz(table, tmp_path / "a.npz")
    found = import_embeddings(tmp_path / "a.npz", encoder="x", classes=("wood", "felt"))
    assert len(found) == 5 and found.rows["object"] == ["o0", "o1", "o3", "o4", "o5"]
    assert found.header.origin.endswith("1 of 6 rows left out, which have no class: row 2")
    np.testing.assert_array_equal(found.vis, np.delete(table["vis"], 2, 0))


def test_columns_that_nobody_asked_for_end_nothing(table, tmp_path):
    pa, pq = pytest.importorskip("pyarrow"), pytest.importorskip("pyarrow.parquet")
    columns = {name: array.tolist() for name, array in table.items()}
    ragged = {
        "tokens": [[1] * k for k in range(COUNT)],
        "boxes": [[[1, 2]] * k for k in range(COUNT)],
    }
    pq.write_table(pa.table(columns | ragged), tmp_path / "a.parquet")
    found = import_embeddings(tmp_path / "a.parquet", encoder="x")
    np.testing.assert_allclose(found.tac, table["tac"], rtol=1e-6)


def test_a_row_without_its_numbers_is_named(table, tmp_path):
    pa, pq = pytest.importorskip("pyarrow"), pytest.importorskip("pyarrow.parquet")
    for vector, words in (
        (None, "nothing in row 4 of vis, and 4"),
        ([1.0], "1 numbers in row 4 of vis"),
    ):
        columns = {name: array.tolist() for name, array in table.items()}
        columns["vis"][4] = vector
        pq.write_table(pa.table(columns), tmp_path / "a.parquet")
        with pytest.raises(DataError, match=words):
            import_embeddings(tmp_path / "a.parquet", encoder="x")
    write_csv(table, tmp_path / "a.csv")
    lines = (tmp_path / "a.csv").read_text().splitlines()
    cells = lines[4].split(",")
    for row, words in (
        (["n/a", *cells[1:]], "'n/a'"),
        (["nan", *cells[1:]], "has nan in vis"),
        (["", *cells[1:]], "an empty cell"),
        (["x"], "1 cells"),
    ):
        (tmp_path / "a.csv").write_text("\n".join([*lines[:4], ",".join(row), *lines[5:]]))
        with pytest.raises(DataError, match=rf"(?=.*row 3 \(line 5\)).*{words}"):
            import_embeddings(tmp_path / "a.csv", encoder="x")


def test_semicolons_decimal_commas_and_blank_last_lines_are_read(table, tmp_path):
    write_csv(table, tmp_path / "a.csv")
    text = (tmp_path / "a.csv").read_text("utf-8")
    decimals = text.replace(",", ";").replace(".", ",").replace("\n", "\r\n") + "\r\n;;\r\n"
    (tmp_path / "a.csv").write_text(decimals, "utf-8")
    found = import_embeddings(tmp_path / "a.csv", encoder="x")
    np.testing.assert_allclose(found.vis, table["vis"], rtol=1e-6)


def test_plain_safetensors_and_vectors_of_one_modality_are_a_set(table, tmp_path):
    short = torch.tensor(table["tac"]).bfloat16()
    save_torch({"tac": short}, tmp_path / "b.safetensors")
    rough = columns_of(tmp_path / "b.safetensors").get("tac")
    np.testing.assert_array_equal(rough, short.float().numpy())
    numbers = {"touch": table["tac"], "label": np.arange(COUNT) % 2}
    save_file(numbers, tmp_path / "a.safetensors")
    found = read_features(tmp_path / "a.safetensors")
    assert (found.modalities, found.domains, found.labelled) == (("tac",), ["a"], True)
    out = tmp_path / "out.safetensors"
    line = ["import", str(tmp_path / "a.safetensors"), "--encoder", "x", "--domain", "rig"]
    assert main([*line, "--classes", "wood,felt", "--out", str(out)]) == 0
    again = load_embeddings(out)
    assert (again.header.modalities, again.header.classes) == (("tac",), ("wood", "felt"))
    assert again.header.origin == "imported from a.safetensors; tac is 'touch'"
    np.testing.assert_array_equal(again.vis, table["tac"])
    assert read_features(out).modalities == ("tac",)


def test_an_npz_whose_arrays_or_vectors_take_far_more_than_its_own_size_is_refused(
    tmp_path, monkeypatch
):
    np.savez_compressed(tmp_path / "a.npz", vis=np.zeros((100, 1000), bool))
    for most, what in ((90_000, "arrays"), (300_000, "vectors")):
        monkeypatch.setattr("omnivat.data.named_columns.MEMORY", most)
        with pytest.raises(DataError, match=f"of memory for its {what}.*split it"):
            import_embeddings(tmp_path / "a.npz", encoder="x", domain="A", material="wood")


def test_an_npz_of_a_type_that_numpy_cannot_hold_is_refused_by_that_type(tmp_path):
    head = b"{'descr': '<U750000000', 'fortran_order': False, 'shape': (1,)}\n"
    with ZipFile(tmp_path / "a.npz", "w") as archive:
        archive.writestr("vis.npy", b"\x93NUMPY\1\0" + len(head).to_bytes(2, "little") + head)
    with pytest.raises(DataError, match="cannot be read .*<U750000000"):
        import_embeddings(tmp_path / "a.npz", encoder="x")


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no such limits")
def test_a_small_parquet_file_of_countless_rows_does_not_fill_memory(tmp_path, monkeypatch):
    pyarrow, parquet = pytest.importorskip("pyarrow"), pytest.importorskip("pyarrow.parquet")
    rows = pyarrow.table({"vis": np.zeros(5_000_000, np.int64)})
    with parquet.ParquetWriter(tmp_path / "a.parquet", rows.schema) as writer:
        for _ in range(8):
            writer.write_table(rows)
    assert (tmp_path / "a.parquet").stat().st_size < 1_000_000
    small = Limited("omnivat.data.parquet:part", memory=400_000_000, seconds=30)
    monkeypatch.setattr("omnivat.data.parquet.read_part", small)
    with pytest.raises(DataError, match=r"a.parquet' takes more memory or time .*again\.$"):
        columns_of(tmp_path / "a.parquet").get("vis")
    small.close()


def test_files_imported_under_one_name_are_of_one_encoder(table, tmp_path):
    write_npz(table, tmp_path / "a.npz")
    table["vis"] = table["vis"] + 1
    write_npz(table, tmp_path / "b.npz")
    first, second, other = (
        import_embeddings(tmp_path / file, encoder=name).header.key
        for file, name in (("a.npz", "x"), ("b.npz", "x"), ("b.npz", "y"))
    )
    assert first == second != other


def test_parquet_with_a_column_for_each_number_is_opened_once(tmp_path, monkeypatch):
    pa, pq = pytest.importorskip("pyarrow"), pytest.importorskip("pyarrow.parquet")
    pq.write_table(pa.table({f"vis_{k}": [float(k)] for k in range(9)}), tmp_path / "a.parquet")
    opened = []
    whole = pq.ParquetFile
    monkeypatch.setattr(pq, "ParquetFile", lambda *of, **how: opened.append(of) or whole(*of))
    of = {"file": str(tmp_path / "a.parquet"), "what": "column"}
    found = [received(*part(b"", name=f"vis_{k}", **of)) for k in range(9)]
    assert np.array_equal(found, np.arange(9.0)[:, None]) and len(opened) == 1


def test_letters_that_steer_a_terminal_are_printed_as_escapes(tmp_path, capsys):
    np.savez(tmp_path / "a.npz", vis=np.eye(2), material=["\x1b[2Jwood", "steel\n"])
    words = ["--encoder", "x", "--domain", "\x1b]0;d", "--out", str(tmp_path / "a.safetensors")]
    assert main(["import", str(tmp_path / "a.npz"), *words]) == 0
    written = capsys.readouterr().out
    assert "\x1b" not in written and "\\x1b[2Jwood" in written


def test_numbered_columns_of_a_table_are_found_without_a_search_for_each(tmp_path, monkeypatch):
    """A search for each of 100,000 columns took minutes."""

    class Header(list[str]):
        def index(self, *_):
            raise AssertionError("a search")

    rows = {1: Header(f"vis_{k}" for k in range(9)), 2: ["1"] * 9}
    monkeypatch.setattr(columns, "numbered_rows", lambda _: rows)
    (tmp_path / "wide.csv").touch()
    assert columns_of(tmp_path / "wide.csv").get("vis").shape == (1, 9)
