"""Files of JSON lines: whole records are read, an interrupted last line is left out."""

import gzip

import pytest

from omnivat.kit.errors import DataError
from omnivat.kit.lines import lines

WHOLE = '{"format": "a", "n": 1}\n\n{"format": "b", "n": 2}\n'


@pytest.mark.parametrize("end", ["", '{"format": "a", "n'])
def test_records_of_the_wanted_formats_are_read_up_to_an_interrupted_line(tmp_path, end):
    (tmp_path / "a.jsonl").write_text(WHOLE + end)
    (tmp_path / "a.jsonl.gz").write_bytes(gzip.compress((WHOLE + end).encode()))
    for name in ("a.jsonl", "a.jsonl.gz"):
        assert [record["n"] for record in lines(tmp_path / name, "a", "b")] == [1, 2]
    assert not list(lines(tmp_path / "none.jsonl", "a"))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("{]\n" + WHOLE, "Line 1 of .* is not JSON; remove it"),
        ("[1]\n", "Line 1 of .* is not a record of a run"),
        (WHOLE + '{"format": "c"}\n', "Line 4 of .* is not a record of a run"),
    ],
)
def test_a_line_that_is_no_record_is_named(tmp_path, text, words):
    (tmp_path / "a.jsonl").write_text(text)
    with pytest.raises(DataError, match=words):
        list(lines(tmp_path / "a.jsonl", "a", "b"))
