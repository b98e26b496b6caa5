"""Decoding uploads: the same pixels, within limits, killed if too slow."""

import struct
import subprocess
import sys
import tracemalloc
import zlib
from contextlib import closing, suppress
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from app.shared.decoder import Decoder
from benchmarks._attack_costly import chunk, encoded
from omnivat.data.images import read_image
from omnivat.kit.errors import DataError

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="module")
def decoder():
    with closing(Decoder()) as found:
        yield found


@pytest.fixture
def unused():
    """A decoder that has no process yet."""
    with closing(Decoder()) as found:
        yield found


@pytest.mark.parametrize("kind", ["PNG", "JPEG", "TIFF"])
def test_a_picture_has_the_pixels_that_the_library_reads(decoder, kind, tmp_path):
    random = np.random.default_rng(0)
    content = encoded(Image.fromarray(random.integers(0, 255, (60, 90, 3), dtype=np.uint8)), kind)
    (tmp_path / "a").write_bytes(content)
    for given in (content, tmp_path / "a"):
        found = decoder.read(given, "a")
        assert (found.width, found.height) == (90, 60)
        assert np.array_equal(np.asarray(found.image), np.asarray(read_image(content)))


def test_a_large_photo_says_the_size_that_it_had_and_lies_upright(decoder):
    exif = Image.Exif()
    exif[0x0112] = 6
    found = decoder.read(encoded(Image.new("RGB", (6000, 4000)), "JPEG", exif=exif), "photo.jpg")
    assert (found.width, found.height) == (4000, 6000)
    assert found.image.size == (2000, 3000)


def png(side, *parts):
    """Return a PNG of a header, other parts and few of its pixels."""
    head = chunk(b"IHDR", struct.pack(">IIBBBBB", side, side, 8, 2, 0, 0, 0))
    body = chunk(b"IDAT", zlib.compress(b"\0" * 99)) + chunk(b"IEND", b"")
    return b"\x89PNG\r\n\x1a\n" + head + b"".join(parts) + body


def tiff(values):
    """Return a TIFF of one table: tag -> value."""
    rows = b"".join(struct.pack("<HHII", tag, 4, 1, value) for tag, value in values.items())
    return b"II*\0" + struct.pack("<IH", 8, len(values)) + rows + bytes(4)


def exif_table(entries, size):
    """Return an EXIF table whose entries all name the same bytes."""
    rows = b"".join(struct.pack("<HHII", k + 1, 2, size, 8) for k in range(entries))
    return b"II*\0\x08\0\0\0" + struct.pack("<H", entries) + rows + bytes(size)


HOSTILE = {
    "a PNG of 4 GB": png(36_000),
    "a hundred megabytes of text in a PNG": png(
        64, chunk(b"zTXt", b"a\0\0" + zlib.compress(b"x" * 10**6)) * 100
    ),
    "a table of 20,000 notes in a PNG": png(64, chunk(b"eXIf", exif_table(20_000, 200_000))),
    "a TIFF of a huge tile": tiff({256: 64, 257: 64, 259: 5, 322: 65_536, 323: 65_536}),
    "a TIFF of 60,000 entries": b"II*\0" + struct.pack("<IH", 8, 60_000) + b"\0" * 999,
    "a JPEG of five thousand scans": encoded(Image.new("RGB", (64, 64)), "JPEG", progressive=True)
    .replace(b"\xff\xd9", b"\xff\xda\x00\x08\x01\x01\x00\x00\x3f\x00\x00" * 5000),
}  # fmt: skip


@pytest.mark.parametrize("what", HOSTILE)
def test_a_hostile_file_ends_in_one_sentence_and_takes_no_memory_of_the_page(decoder, what):
    content = HOSTILE[what]
    tracemalloc.start()
    try:
        with pytest.raises(DataError, match=r"'touch' .*\.$"):
            decoder.read(content, "touch")
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert peak < 2 * len(content) + 5_000_000


def standing_in(code):
    """Return a maker of a process that runs other code than the decoder's, and what it made."""
    started = []

    def made():
        started.append(
            subprocess.Popen(
                [sys.executable, "-c", code], stdin=subprocess.PIPE, stdout=subprocess.PIPE
            )
        )
        return started[-1]

    return made, started


def test_a_process_that_takes_too_long_is_killed_and_the_next_picture_is_read(unused, monkeypatch):
    made, started = standing_in("import time; time.sleep(600)")
    content = encoded(Image.new("L", (99, 99)), "WEBP")
    with monkeypatch.context() as patched:
        patched.setattr(unused._limited, "started", made)
        patched.setattr(unused._limited, "wait", 0.3)
        with pytest.raises(DataError, match="'slow' could not be read within the time and memory"):
            unused.read(content, "slow")
        assert started[0].poll() is not None
    assert unused.read(content, "good").image.size == (99, 99)


def test_a_process_that_dies_while_it_sends_gives_a_sentence(unused, monkeypatch):
    made, _ = standing_in("input(); print('{\"size\": 29403, \"value\": {}}'); print('x' * 50)")
    monkeypatch.setattr(unused._limited, "started", made)
    with pytest.raises(DataError, match="'slow' could not be read within the time and memory"):
        unused.read(encoded(Image.new("L", (99, 99)), "WEBP"), "slow")


def test_one_process_reads_one_picture_after_another_and_keeps_no_memory_of_a_large_one(
    unused, monkeypatch
):
    started, first = [], unused._limited.started
    monkeypatch.setattr(unused._limited, "started", lambda: started.append(first()) or started[-1])
    small, large = (
        encoded(Image.new("L", (99, 99)), "PNG"),
        encoded(Image.new("RGB", (2000, 2000)), "JPEG"),
    )
    for content in (small, b"no image", small, large, small):
        with suppress(DataError):
            unused.read(content, "a")
    assert len(started) == 1 and started[0].poll() is None
    status = Path(f"/proc/{started[0].pid}/status")
    if status.exists():
        kept = next(line for line in status.read_text().splitlines() if line.startswith("VmRSS"))
        # kB; the picture alone took 12 MB and its decoding more
        assert int(kept.split()[1]) < 80_000


def test_the_process_ends_by_itself_when_the_server_is_gone():
    process = subprocess.Popen(
        [
            sys.executable,
            "-m",
            "omnivat.kit.limited",
            "app.shared.decoder:decoded",
            "220000000",
            "3",
        ],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        cwd=ROOT,
    )
    process.communicate(timeout=60)
    assert process.returncode == 0
