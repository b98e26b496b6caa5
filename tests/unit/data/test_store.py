"""A set of embeddings on disk: it loads unchanged, and errors name damage."""

import csv
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from safetensors import safe_open
from safetensors.numpy import save_file

from omnivat.data.arrays import Column, read_arrays, write_arrays
from omnivat.data.profile import profile_of
from omnivat.data.profile_file import load_profile, save_profile
from omnivat.data.store import load_embeddings, save_embeddings, write_manifest
from omnivat.kit.errors import DataError

VECTORS = ("vis", "tac", "vis_flip", "tac_flip")


@pytest.fixture
def embeddings(make_embeddings):
    """A set whose first pair imitates another class."""
    made = make_embeddings(per_class=3, split=True)
    return replace(made, rows=made.rows | {"looks_like": ["wood", *made.rows["looks_like"][1:]]})


@pytest.fixture
def file(embeddings, tmp_path):
    """The same on disk."""
    save_embeddings(tmp_path / "set.safetensors", embeddings)
    return tmp_path / "set.safetensors"


def test_what_is_saved_is_what_is_loaded_also_by_the_safetensors_package(embeddings, file):
    """The writer is ours, so that sets need not fit in memory; the format is not."""
    loaded = load_embeddings(file)
    assert (loaded.header, loaded.rows) == (embeddings.header, embeddings.rows)
    with safe_open(file, framework="numpy") as handle:
        for name in (*VECTORS, "domain", "label"):
            assert np.array_equal(getattr(loaded, name), getattr(embeddings, name)), name
            assert np.array_equal(handle.get_tensor(name), getattr(embeddings, name)), name
    part = loaded.select(np.array([1, 0]))
    assert part.rows["looks_like"] == ["", "wood"] and np.array_equal(part.vis, loaded.vis[[1, 0]])


def test_vectors_are_mapped_and_writing_to_them_leaves_the_file(file):
    before, loaded = file.read_bytes(), load_embeddings(file)
    assert isinstance(loaded.vis, np.memmap)
    loaded.vis[0] = 0
    assert file.read_bytes() == before


def test_half_precision_takes_half_the_room_and_keeps_three_digits(embeddings, tmp_path):
    save_embeddings(tmp_path / "half.safetensors", embeddings, dtype="float16")
    loaded = load_embeddings(tmp_path / "half.safetensors")
    assert loaded.vis.dtype == np.float32
    np.testing.assert_allclose(loaded.vis, embeddings.vis, rtol=2**-11, atol=1e-7)
    with safe_open(tmp_path / "half.safetensors", framework="numpy") as handle:
        assert handle.get_tensor("vis").dtype == np.float16


def test_values_that_are_not_finite_are_not_written(embeddings, file):
    before = file.read_bytes()
    embeddings.tac[1, 2] = np.inf
    with pytest.raises(DataError, match=r"set\.safetensors.* tac has inf in row 1, column 2"):
        save_embeddings(file, embeddings)
    assert file.read_bytes() == before
    assert {path.name for path in file.parent.iterdir()} == {"set.csv", "set.safetensors"}


def test_a_domain_with_the_name_of_the_total_is_neither_written_nor_read(embeddings, file):
    header, before = embeddings.header, file.read_bytes()
    named = replace(embeddings, header=replace(header, domains=("all", *header.domains[1:])))
    with pytest.raises(DataError, match="A domain is called 'all'.*rename the domain"):
        save_embeddings(file, named)
    assert file.read_bytes() == before
    rewritten(file, {"domains": '["all", "B"]'})
    with pytest.raises(DataError, match="A domain is called 'all'.*rename the domain"):
        load_embeddings(file)


def test_a_name_that_cannot_be_read_again_is_not_written(embeddings, tmp_path):
    classes = ("x" * 301, *embeddings.header.classes[1:])
    long = replace(embeddings, header=replace(embeddings.header, classes=classes))
    with pytest.raises(DataError, match="names of 1 to 300 letters"):
        save_embeddings(tmp_path / "long.safetensors", long)
    assert not any(tmp_path.iterdir())


def test_a_value_too_large_for_half_precision_is_not_written(embeddings, tmp_path):
    embeddings.vis[0, 0] = 70_000
    save_embeddings(tmp_path / "single.safetensors", embeddings)
    with pytest.raises(DataError, match="float16"):
        save_embeddings(tmp_path / "half.safetensors", embeddings, dtype="float16")


@pytest.mark.parametrize("share", [0.0, 0.001, 0.999])
def test_a_file_cut_short_is_refused_by_name(file, share):
    content = file.read_bytes()
    file.write_bytes(content[: int(len(content) * share)])
    with pytest.raises(DataError, match=r"set\.safetensors"):
        load_embeddings(file)


def test_a_missing_file_and_another_one_are_refused_with_the_command_that_makes_it(tmp_path):
    save_file({"a": np.zeros(3, np.float32)}, tmp_path / "other.safetensors")
    (tmp_path / "pairs.csv").write_text("vis,tac")
    for name, why in (
        ("none.safetensors", "No embeddings file"),
        ("other.safetensors", "not a set of embeddings"),
        ("pairs.csv", "is a table"),
    ):
        with pytest.raises(DataError, match=f"{why}.*python -m omnivat embed"):
            load_embeddings(tmp_path / name)


def rewritten(file, texts=(), **changes):
    """Write the file again with some texts of the header and some arrays in place of its own."""
    arrays, metadata = read_arrays(file)
    arrays = {name: np.array(array) for name, array in arrays.items()} | changes
    save_file(arrays, file, metadata=metadata | dict(texts))


@pytest.mark.parametrize(
    ("changes", "match"),
    [
        ({"label": np.zeros(3, np.int64)}, "differing lengths"),
        ({"rows": np.frombuffer(b"{}", np.uint8)}, "differing lengths"),
        ({"label": np.full(30, 99)}, "label index without a name"),
        ({"domain": np.full(30, -1)}, "domain index without a name"),
        ({"vis": np.full((30, 24), np.nan, np.float32)}, "nan in row 0, column 0"),
        ({"vis": np.full((30, 24), 1e30, np.float32)}, "1e.30 in row 0, column 0"),
        ({"vis": np.full((30, 24), 1e-40, np.float32)}, "no value above"),
        ({"rows": np.frombuffer(b"{]", np.uint8)}, "cannot be read"),
        ({"rows": np.zeros(2, np.int64)}, "'rows' should be the bytes of a JSON object"),
        ({"vis": np.zeros((30, 24), np.int64)}, "of type int64, expected float32 or float16"),
    ],
)
def test_arrays_that_do_not_fit_are_refused(file, changes, match):
    rewritten(file)
    load_embeddings(file)
    rewritten(file, **changes)
    with pytest.raises(DataError, match=match):
        load_embeddings(file)


@pytest.mark.parametrize("power", [-45, -9, -6, 6, 9, 36])
def test_a_set_and_its_profile_are_refused_or_can_be_read_again_whatever_their_size(
    embeddings, tmp_path, power
):
    with np.errstate(over="ignore", under="ignore"):
        vis = (embeddings.vis * np.float64(10.0) ** power).astype(np.float32)
    scaled = replace(embeddings, vis=vis)
    if not -6 <= power <= 6:
        with pytest.raises(DataError, match="scale all rows|at most"):
            save_embeddings(tmp_path / "set.safetensors", scaled)
        assert not (tmp_path / "set.safetensors").exists()
        return
    save_embeddings(tmp_path / "set.safetensors", scaled)
    found = load_embeddings(tmp_path / "set.safetensors")
    save_profile(tmp_path / "profile.safetensors", profile_of(found))
    assert load_profile(tmp_path / "profile.safetensors").counts["vis"] == len(found)


def test_names_whose_table_of_counts_would_fill_the_memory_are_refused(embeddings, tmp_path):
    names = {key: tuple(f"{key} {k}" for k in range(1_100)) for key in ("domains", "classes")}
    file = tmp_path / "set.safetensors"
    save_embeddings(file, replace(embeddings, header=replace(embeddings.header, **names)))
    with pytest.raises(DataError, match="1,100 domains and 1,100 classes"):
        load_embeddings(file)


def test_the_manifest_names_every_pair_as_csv_and_as_parquet(embeddings, file):
    with file.with_suffix(".csv").open(newline="", encoding="utf-8") as handle:
        rows = list(csv.DictReader(handle))
    for name in ("vis", "looks_like"):
        assert [row[name] for row in rows] == embeddings.rows[name]
    classes = embeddings.header.classes
    assert [row["material"] for row in rows] == [classes[label] for label in embeddings.label]
    parquet = pytest.importorskip("pyarrow.parquet")
    columns = {name: [row[name] for row in rows] for name in rows[0]}
    write_manifest(file, columns, "parquet")
    assert parquet.read_table(file.with_suffix(".parquet")).to_pylist() == rows


def test_a_domain_its_split_and_an_unknown_one(embeddings):
    train = embeddings.in_domain("OF Real-sim", split="train")
    test = embeddings.in_domain("OF Real-sim", split="test")
    assert len(train) + len(test) == len(embeddings) // 2
    assert set(train.rows["split"]) == {"train"}
    assert (train.domain == 1).all()
    with pytest.raises(DataError, match="OF Real-sim"):
        embeddings.in_domain("Of Real-sim")


def test_loading_needs_no_torch():
    code = "import sys, omnivat.data.store; sys.exit('torch' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_blocks_that_do_not_add_up_are_refused(tmp_path):
    short = Column(dtype=np.dtype("float32"), shape=(4, 2), blocks=[np.zeros((3, 2), np.float32)])
    with pytest.raises(ValueError, match="8 bytes less"):
        write_arrays(tmp_path / "a.safetensors", {"a": short}, {})


def test_a_name_that_is_no_text_is_refused_in_a_sentence_and_nothing_is_written(
    make_embeddings, tmp_path
):
    odd = make_embeddings()
    odd.rows["object"][0] = "a\udcff"
    with pytest.raises(DataError, match="no text .UTF-8.; rename that file"):
        save_embeddings(tmp_path / "odd.safetensors", odd)
    assert not list(tmp_path.iterdir())
