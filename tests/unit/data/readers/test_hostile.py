"""For any content of a data set's files, a reader returns pairs or raises one sentence."""

import json
import shutil
from pathlib import Path

import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from omnivat.data.pairs import summary_table
from omnivat.data.readers import read_pairs
from omnivat.kit.errors import DataError

few = settings(max_examples=40, suppress_health_check=[HealthCheck.function_scoped_fixture])
cells = st.sampled_from(
    [
        "1",
        "0",
        "-1",
        "a",
        "glass",
        "3.5",
        "",
        " ",
        "../..",
        "1e9",
        "٣",
        "²",
        "\0",
        "é",
        '"',
        "9" * 30,
    ]
)
tables = st.lists(st.lists(cells, max_size=9), max_size=6).map(
    lambda rows: "\n".join(",".join(row) for row in rows).encode()
)
contents = st.one_of(st.binary(max_size=40), tables)
words = st.text(st.sampled_from("a1, \n\0é\U0001f600"), max_size=3)
values = st.recursive(
    st.one_of(st.none(), st.booleans(), st.integers(-1, 101), words, st.just(float("nan"))),
    lambda inner: st.one_of(
        st.lists(inner, max_size=3),
        st.dictionaries(st.sampled_from(["1", "101", "a", "train", ""]), inner, max_size=3),
    ),
    max_leaves=8,
)


def answer(root: Path, **options: object) -> None:
    """Read, and check that the result is either complete pairs or a printable sentence."""
    try:
        found = read_pairs(root, **options)
    except DataError as error:
        said = str(error)
        assert said.isprintable()
        assert len(said) < 1500
        return
    assert found.pairs
    assert all(p.vis.is_file() and p.tac.is_file() for p in found.pairs)
    assert summary_table(found).replace("\n", "").isprintable()


@pytest.mark.slow
@few
@given(values, values, contents)
@example({"1": 0}, {}, b"1,,,\x00")
def test_any_values_in_objectfolder_2_tables_give_pairs_or_a_sentence(
    release, labels, split, table
):
    root = release({1: "Wood", 2: "Glass", 101: "Iron"}, instances=1)
    answer(root)
    (root / "split.json").write_text(json.dumps(split))
    answer(root, split="release")
    (root / "objects.csv").write_bytes(b"1,x,1,Wood,u\n" + table)
    answer(root)
    (root / "label.json").write_text(json.dumps(labels))
    answer(root)


@pytest.mark.slow
@few
@given(contents, st.one_of(st.none(), contents))
def test_any_bytes_in_tacquad_contacts_give_pairs_or_a_sentence(
    tree, tmp_path, monkeypatch, contact, materials
):
    monkeypatch.setenv("OMNIVAT_CACHE", str(tmp_path / "cache"))
    shutil.rmtree(tmp_path / "data_indoor", ignore_errors=True)
    tree(*(f"data_indoor/glass/{f}" for f in ("digit/1.png", "img_digit/1.png", "tac3d/1.npy")))
    (tmp_path / "data_indoor" / "glass" / "tac3d" / "1.npy").write_bytes(contact)
    (tmp_path / "contact_indoor.csv").write_bytes(b"glass,0,1,0,1,0,1\n" + contact)
    table = tmp_path / "materials.csv"
    table.unlink(missing_ok=True)
    if materials is not None:
        table.write_bytes(b"item,material\n" + materials)
    answer(tmp_path)
