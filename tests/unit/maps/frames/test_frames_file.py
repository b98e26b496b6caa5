"""The frames file: what is written is read back, and damage is detected."""

import json
import re
import subprocess
import sys

import numpy as np
import pytest

from omnivat.kit.errors import DataError
from omnivat.maps.frames import read_frames, write_frames


@pytest.fixture
def written(frames, tmp_path):
    path = tmp_path / "frames.bin"
    write_frames(path, frames)
    return path


def test_a_written_file_reads_back_as_it_was(frames, written):
    read = read_frames(written)
    for name in ("domain", "label", "prediction", "confidence"):
        np.testing.assert_array_equal(getattr(read, name), getattr(frames, name))
    for name in ("orders", "domains", "classes", "curves", "head", "embeddings", "pairs"):
        assert getattr(read, name) == getattr(frames, name)
    assert read.head["source"] == "D0"
    assert read.embeddings["simulated"] is True
    for name, wanted in frames.maps.items():
        np.testing.assert_array_equal(read.maps[name].points, wanted.points)
        assert read.maps[name].low == wanted.low
        assert read.maps[name].max_error == wanted.max_error


def test_reading_loads_no_torch(written):
    program = (
        "import sys; from omnivat.maps.frames import read_frames; "
        f"read_frames({str(written)!r}); print('torch' in sys.modules)"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    )
    assert done.stdout.strip() == "False"


def damaged(path, change):
    """Rewrite the JSON of a frames file through `change`."""
    content = path.read_bytes()
    length = int.from_bytes(content[8:12], "little")
    record = json.loads(content[12 : 12 + length])
    change(record)
    text = json.dumps(record).encode()
    text += b" " * (-(12 + len(text)) % 8)
    path.write_bytes(b"OVFRAMES" + len(text).to_bytes(4, "little") + text + content[12 + length :])


def test_a_missing_file_says_how_to_build_one(tmp_path):
    with pytest.raises(DataError, match="No frames file at .*omnivat sweep"):
        read_frames(tmp_path / "none.bin")


@pytest.mark.parametrize("kept", [0, 11, 40, -1])
def test_a_file_that_is_cut_short_is_refused(written, kept):
    written.write_bytes(written.read_bytes()[:kept])
    with pytest.raises(DataError, match=r"frames\.bin"):
        read_frames(written)


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (lambda r: r.update(version=9), "version 9, expected 1"),
        (lambda r: r["arrays"]["label"].update(offset=10**9), "array 'label' does not fit"),
        (lambda r: r["arrays"]["confidence"].update(shape=[5, 23]), "confidence has shape (5, 23)"),
        (lambda r: r["arrays"].pop("domain"), "cannot be read"),
        (lambda r: r.update(pairs=7), "frames (7 pairs stated, 24 found)."),
        (lambda r: r.update(classes=["wood"]), "has no name"),
        (lambda r: r["curves"].update({"margin/raw": [1.0]}), "curve margin/raw has 1 values"),
        (lambda r: r["maps"]["pca/f_hat"].update(orders=[0, 1]), "map pca/f_hat has shape"),
        (lambda r: r["maps"]["pca/raw"].update(orders=[99]), "a stop that does not exist"),
    ],
)
def test_a_file_whose_parts_do_not_fit_is_refused(written, change, sentence):
    damaged(written, change)
    with pytest.raises(DataError, match=re.escape(sentence)):
        read_frames(written)
