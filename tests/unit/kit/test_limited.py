"""Limits on readers, and one sentence for each way in which they end."""

import os
import re
import sys
from itertools import islice

import pytest

from omnivat.kit.errors import DataError
from omnivat.kit.limited import Limited

ENDS = {  # of `reader`, and its sentence
    "memory": "takes more memory or time than its reader has; export it again.",
    "time": "takes more memory or time than its reader has; export it again.",
    "death": "takes more memory or time than its reader has; export it again.",
    "fault": "cannot be read (no number); export it again.",
    "sentence": "This file is damaged.",
}


def reader(_, *, file, way):
    """Yield some numbers, and perhaps end in some way."""
    for number in range(3):
        yield {"number": number}, bytes(number)
        yield None, b""
    if way == "memory":
        yield {}, bytes(len(bytes(500_000_000)) % 7)  # taken, not sent
    while way == "time":
        pass
    if way == "death":
        os._exit(1)
    if way == "fault":
        raise ValueError("no number\nat all")
    if way == "sentence":
        raise DataError("This file is damaged.")


@pytest.fixture
def limited():
    made = Limited(f"{__name__}:reader", memory=400_000_000, seconds=1, wait=60.0)
    yield made
    made.close()


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no such limits")
@pytest.mark.parametrize("way", ENDS)
def test_each_end_of_a_reader_is_one_sentence_with_the_name_of_the_file(way, limited, tmp_path):
    file = tmp_path / "a b"
    file.touch()
    found = []
    with pytest.raises(DataError, match=f"{re.escape(ENDS[way])}$") as caught:
        found.extend(limited.read(file, way=way))
    assert way == "sentence" or str(file) in str(caught.value)
    assert way == "memory" or found == [({"number": n}, bytes(n)) for n in range(3)]
    assert len([*limited.read(file, way="")]) == 3  # the next call is not harmed


def test_a_reader_that_is_left_early_ends_and_one_that_is_not_goes_on(limited, tmp_path):
    (tmp_path / "a").touch()
    assert len([*islice(limited.read(tmp_path / "a", way=""), 1)]) == 1
    assert not limited._idle
    for _ in range(2):
        assert len([*limited.read(tmp_path / "a", way="")]) == 3
        assert len(limited._idle) == 1


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no such limits")
def test_limits_grow_with_the_file_where_they_are_meant_to(tmp_path):
    with (tmp_path / "large").open("wb") as file:
        file.truncate(100_000_000)
    growing = Limited(f"{__name__}:reader", memory=400_000_000, seconds=1, grows=True)
    assert len([*growing.read(tmp_path / "large", way="memory")]) == 4
    growing.close()
