"""Untrusted files: hostile values give one sentence and nothing else."""

import json
import struct
from pathlib import Path

import pytest

from omnivat.kit.errors import DataError
from omnivat.kit.files import read_whole, require_regular
from omnivat.kit.schema import columns_in, json_in, name_list, object_in, tensor_table, texts

HOSTILE_JSON = {
    "a number of 5,000 digits": b'{"a": ' + b"9" * 5000 + b"}",
    "an infinite number": b'{"a": 1e999}',
    "a hundred thousand lists": b'{"a": ' + b"[" * 100_000 + b"]" * 100_000 + b"}",
    "41 lists": b'{"a": ' + b"[" * 41 + b"]" * 41 + b"}",
    "half a character": b'{"a": ["\\ud800"]}',
    "half a character in a name": b'{"\\udfff": 1}',
    "no JSON": b"{]",
    "bytes that are no text": b'{"a": "\xff"}',
    "a list": b"[1]",
    "nothing": b"",
}


@pytest.mark.parametrize("what", HOSTILE_JSON)
def test_hostile_json_is_refused_in_one_sentence_with_its_name(what):
    with pytest.raises(DataError, match=r"'settings.json'.*\.$") as caught:
        object_in(HOSTILE_JSON[what], "settings.json")
    assert len(str(caught.value)) < 400
    assert "\n" not in str(caught.value)


def test_good_json_is_taken_as_it_is():
    deep = json.loads("[" * 40 + "]" * 40)  # the most
    value = {"a": [10**17, 2.5, None, True, {"b": "ü"}], "c": {}, "d": deep}
    assert json_in(json.dumps(value).encode(), "x") == value


@pytest.mark.parametrize("value", [[], {"a": 1}, {"a": ["b"]}, "a", None])
def test_what_are_no_texts_under_names_is_refused(value):
    with pytest.raises(DataError, match="texts under names"):
        texts(value, "encoder")


@pytest.mark.parametrize(
    "value", ["ab", [1], [""], ["a", "a"], ["x" * 301], {"a": 1}, list("abcd")]
)
def test_what_is_no_list_of_names_is_refused(value):
    with pytest.raises(DataError, match="different names"):
        name_list(value, "classes", 3)


@pytest.mark.parametrize(
    "content", [b'{"a": "b"}', b'{"a": [1]}', b"[]", b'{"a": [], "b": [], "c": []}']
)
def test_columns_that_are_no_texts_are_refused(content):
    with pytest.raises(DataError, match=r"'?rows'?"):
        columns_in(content, "rows", 2)


def tensors(file, table, length=None):
    text = table if isinstance(table, bytes) else json.dumps(table).encode()
    file.write_bytes(struct.pack("<Q", len(text) if length is None else length) + text)
    return file


def entry(**changes):
    return {"dtype": "F32", "shape": [0], "data_offsets": [0, 0]} | changes


HOSTILE_TABLES = {
    "5,000 names": {f"n{k}": entry() for k in range(5_000)},
    "no JSON": b"{]",
    "a list": [],
    "a type that is not taken": {"a": entry(dtype="C64")},
    "an array that is a number": {"a": 3},
    "a negative side": {"a": entry(shape=[-1])},
    "fifty axes": {"a": entry(shape=[1] * 50)},
    "one place": {"a": entry(data_offsets=[0])},
    "metadata of numbers": {"__metadata__": {"a": 1}},
    "half a character": b'{"\\ud800": {}}',
}


@pytest.mark.parametrize("what", HOSTILE_TABLES)
def test_hostile_headers_are_refused_before_anything_is_loaded(tmp_path, what):
    with pytest.raises(DataError, match=r"^'.*\.$"):
        tensor_table(tensors(tmp_path / "a.safetensors", HOSTILE_TABLES[what]))


@pytest.mark.parametrize("length", [2**63, 10**9, 99])
def test_a_header_that_is_longer_than_the_file_or_allowed_is_refused(tmp_path, length):
    with pytest.raises(DataError, match="cannot be read"):
        tensor_table(tensors(tmp_path / "a", {}, length))


def test_a_file_that_safetensors_wrote_is_taken(tmp_path):
    import numpy as np
    from safetensors.numpy import save_file

    save_file({"a": np.zeros((2, 3), np.float32)}, tmp_path / "a", metadata={"who": "me"})
    table, metadata, start = tensor_table(tmp_path / "a")
    assert table["a"]["shape"] == [2, 3]
    assert metadata == {"who": "me"}
    assert start % 8 == 0


def test_a_pipe_a_device_and_a_file_without_end_are_refused_at_once(tmp_path):
    import os

    os.mkfifo(tmp_path / "pipe")
    for path in (tmp_path / "pipe", Path("/dev/zero")):
        for attempt in (require_regular, lambda path: read_whole(path, 100)):
            with pytest.raises(DataError, match="pipe or device"):
                attempt(path)
    (tmp_path / "large").write_bytes(b"x" * 101)
    assert len(read_whole(tmp_path / "large", 101)) == 101
    with pytest.raises(DataError, match="larger than"):
        read_whole(tmp_path / "large", 100)
