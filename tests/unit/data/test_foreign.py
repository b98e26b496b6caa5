"""`omnivat import`: embeddings made elsewhere, from each kind of file, checked and named."""

import csv
from typing import Any

import numpy as np
import pytest

from omnivat.cli import main
from omnivat.data.foreign import import_embeddings
from omnivat.data.store import load_embeddings
from omnivat.kit.errors import DataError

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

    columns = {name: array.tolist() for name, array in table.items()}
    parquet.write_table(pyarrow.table(columns), file)


def write_hdf5(table, file):
    h5py = pytest.importorskip("h5py")
    with h5py.File(file, "w") as handle:
        for name, array in table.items():
            handle[name] = array.tolist() if array.dtype.kind == "U" else array


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


def test_files_imported_under_one_name_are_of_one_encoder(table, tmp_path):
    write_npz(table, tmp_path / "a.npz")
    table["vis"] = table["vis"] + 1
    write_npz(table, tmp_path / "b.npz")
    first, second, other = (
        import_embeddings(tmp_path / file, encoder=name).header.key
        for file, name in (("a.npz", "x"), ("b.npz", "x"), ("b.npz", "y"))
    )
    assert first == second != other


def test_the_narrower_vectors_end_in_zeros_and_the_header_says_so(table, tmp_path):
    table["tac"] = table["tac"][:, :3]
    write_npz(table, tmp_path / "a.npz")
    found = import_embeddings(tmp_path / "a.npz", encoder="x")
    assert found.tac.shape == (COUNT, 4) and not found.tac[:, 3].any()
    assert "vis 4, tac 3 values, then zeros" in found.header.preprocessing


def test_columns_of_other_names_are_found(table, tmp_path):
    renamed = {"photo": table.pop("vis"), "kind": table.pop("material"), **table}
    for name in ("set.npz", "set.csv"):
        WRITERS[name](renamed, tmp_path / name)
        names = {"vis": "photo", "material": "kind"}
        found = import_embeddings(tmp_path / name, encoder="x", columns=names)
        np.testing.assert_allclose(found.vis, renamed["photo"], rtol=1e-6)
        assert found.header.classes == ("wood", "steel", "cork")


@pytest.mark.parametrize(
    ("change", "match"),
    [
        (lambda t: t.pop("tac"), "no vectors 'tac'; it has vis"),
        (lambda t: t.pop("material"), "no column 'material'; pass --column material"),
        (lambda t: t.pop("domain"), "no column 'domain'; pass --domain"),
        (lambda t: t.update(tac=t["tac"][:5]), r"tac of shape \(5, 4\), expected \(6, D\)"),
        (lambda t: t.update(vis=t["vis"] * np.nan), "vis of .* has nan in row 0, column 0"),
        (lambda t: t.update(vis=t["vis"].astype(float) * 1e300), "has -?inf in row 0"),
        (
            lambda t: t["domain"].__setitem__(2, "\ud800"),
            "domain in row 2 .* which no file can hold",
        ),
        (lambda t: t.update(vis=np.full((6, 4), "x")), "has no numbers in vis"),
        (lambda t: t.update(material=np.arange(6)), "0 to 5; name them with --classes"),
        (lambda t: t.update(split=np.array(["dev"] * 6)), "the split 'dev'"),
        (lambda t: t.update(domain=np.array(["a"] * 5 + [""])), "pairs without a domain"),
        (lambda t: t.update(object=np.array([{}] * 6)), "pickled objects"),
    ],
)
def test_what_does_not_fit_is_refused_by_name(table, tmp_path, change, match):
    change(table)
    write_npz(table, tmp_path / "a.npz")
    with pytest.raises(DataError, match=match) as caught:
        import_embeddings(tmp_path / "a.npz", encoder="x")
    assert "a.npz" in str(caught.value)


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


@pytest.mark.parametrize("name", [*WRITERS, "set.txt", "set.hdf5"])
def test_a_file_that_is_not_what_its_ending_says_is_refused(tmp_path, name):
    (tmp_path / name).write_bytes(b"\x00\x01nothing")
    with pytest.raises(DataError, match=name):
        import_embeddings(tmp_path / name, encoder="x")
