"""A short round of fuzzing on every run, and that the fuzzing finds what it looks for."""

import json
from contextlib import nullcontext
from io import BytesIO
from pathlib import Path

import numpy as np
import pytest

from benchmarks._fuzz import MOST_MB, fuzz, limited, seeds_of, table_of
from benchmarks._fuzz_readers import READERS, Reader
from omnivat.kit.errors import DataError

CASES = 3  # of each reader
GOOD = b"good"


def planted(harm):
    def read(folder):
        if (folder / "a").read_bytes() != GOOD:
            harm(folder)

    return Reader(lambda _: {"a": GOOD}, read)


def refuse(text):
    raise DataError(text)


def ended(folder):
    import os
    import signal

    os.kill(os.getpid(), signal.SIGKILL)


PLANTED = {
    "ValueError": planted(lambda _: int("x")),
    "no sentence": planted(lambda _: refuse("no\nsentence")),
    "outside": planted(lambda folder: Path(f"{folder}.more").write_text("x")),
    "MB": planted(lambda _: len(b"x" * (MOST_MB + 50) * 1_000_000)),
    "over": planted(ended),
    "held": planted(lambda _: refuse("This file is damaged.")),
}


def of(name):
    """Return the first good case of a reader, or the one with the file `name`."""

    def found(reader):
        cases = seeds_of(READERS[reader])
        return next(case for case in cases if name in case or not name)

    return found


def changed(file, change):
    return lambda reader: {**of(file)(reader), file: change(of(file)(reader)[file])}


def beyond_unicode(content):
    with np.load(BytesIO(content)) as arrays, BytesIO() as handle:
        wide = {name: arrays[name] for name in arrays.files}
        wide["material"] = np.full(3, 0x110000, "u4").view("U1")
        np.savez(handle, **wide)
        return handle.getvalue()


def groups(content):
    h5py = pytest.importorskip("h5py")
    with BytesIO() as handle:
        with h5py.File(handle, "w") as file:
            file.create_group("config"), file.create_group("sensor_chunks")
        return handle.getvalue()


def lit(content):
    """Return a set whose header states lamps for many domains: each is a picture in little room."""
    length = int.from_bytes(content[:8], "little")
    table = json.loads(content[8 : 8 + length])
    one = next(iter(json.loads(table["__metadata__"]["lamps"]).values()))
    table["__metadata__"]["lamps"] = json.dumps({f"domain {k}": one for k in range(401)})
    head = json.dumps(table).encode()
    head += b" " * (-len(head) % 8)
    return len(head).to_bytes(8, "little") + head + content[8 + length :]


FOUND = {  # by this fuzzing, once: reader, case, and what is said of it ("": it is read)
    "notes that are no text": (
        "films",
        changed("b.mkv", lambda c: c.replace(b"ENCODER", b"ENC\x80DER")),
        "",
    ),
    "letters beyond Unicode": ("stored", changed("a.npz", beyond_unicode), "no Unicode"),
    "groups in place of arrays": ("recordings", changed("a.touch", groups), "has no config"),
    "places before the archive": ("archives", changed("a.zip", lambda c: c[64:]), "whole archive"),
    "lamps of 401 domains": ("sets", changed("b.safetensors", lit), "lamps of 401 domains"),
}


@pytest.mark.parametrize("kind", FOUND)
def test_what_fuzzing_has_found_is_held(kind, tmp_path):
    reader, case, words = FOUND[kind]
    for name, content in case(reader).items():
        place = tmp_path / "case" / name
        place.parent.mkdir(parents=True, exist_ok=True)
        place.write_bytes(content)
    with nullcontext() if not words else pytest.raises(DataError, match=words):
        READERS[reader].read(tmp_path / "case")


@pytest.fixture(scope="module")
def process():
    with_limits = limited()
    yield with_limits
    with_limits.close()


@pytest.mark.slow
@pytest.mark.parametrize("name", READERS)
def test_a_damaged_file_gives_a_value_or_one_sentence_within_the_limits(name, process):
    found = fuzz(name, 3, lambda cases: cases < CASES, process)
    assert {kind: text for kind, (text, _) in found.findings.items()} == {}
    assert found.cases == CASES


@pytest.mark.parametrize("name", PLANTED)
def test_each_kind_of_harm_is_found_and_held_cases_are_none(name, process):
    found = fuzz(name, 1, lambda cases: cases < 1, process, f"{__name__}:PLANTED")
    assert all(name in kind for kind in found.findings)
    assert bool(found.findings) == (name != "held")
    assert table_of({name: found}).splitlines()[2].startswith(f"| {name} | 1 |")
