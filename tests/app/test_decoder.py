"""Decoding uploads: the same pixels, within limits, killed if too slow."""

import subprocess
import sys
from io import BytesIO
from pathlib import Path
from threading import Thread
from time import perf_counter, sleep

import numpy as np
import pytest
from PIL import Image

from app.decoder import Budget, Decoder
from omnivat.data.images import read_image
from omnivat.kit.errors import DataError

ROOT = Path(__file__).resolve().parents[2]


def encoded(image, kind, **options):
    with BytesIO() as handle:
        image.save(handle, kind, **options)
        return handle.getvalue()


@pytest.fixture
def decoder():
    decoder = Decoder()
    yield decoder
    decoder.close()


@pytest.mark.parametrize("kind", ["PNG", "JPEG", "WEBP", "GIF", "BMP", "TIFF"])
@pytest.mark.parametrize("as_file", [False, True])
def test_a_picture_has_the_pixels_that_the_library_reads(decoder, kind, as_file, tmp_path):
    random = np.random.default_rng(0)
    content = encoded(Image.fromarray(random.integers(0, 255, (60, 90, 3), dtype=np.uint8)), kind)
    (tmp_path / "a").write_bytes(content)
    found = decoder.read(tmp_path / "a" if as_file else content, "a")
    assert (found.width, found.height) == (90, 60)
    assert np.array_equal(np.asarray(found.image), np.asarray(read_image(content)))


def test_a_large_photo_says_the_size_that_it_had_and_lies_upright(decoder):
    exif = Image.Exif()
    exif[0x0112] = 6
    found = decoder.read(encoded(Image.new("RGB", (6000, 4000)), "JPEG", exif=exif), "photo.jpg")
    assert (found.width, found.height) == (4000, 6000)
    assert found.image.size == (2000, 3000)


@pytest.mark.parametrize("content", [b"", b"no image", encoded(Image.new("L", (99, 99)), "WEBP")[:60]])
def test_what_cannot_be_read_is_refused_in_a_sentence_with_its_name(decoder, content):
    with pytest.raises(DataError, match=r"'touch' .*\."):
        decoder.read(content, "touch")


def test_a_process_that_takes_too_long_is_killed_and_the_next_picture_is_read(decoder, monkeypatch):
    slow = [sys.executable, "-c", "print('ready', flush=True); import time; time.sleep(60)"]
    started = []

    def never_ends():
        process = subprocess.Popen(slow, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        started.append(process)
        return process

    content = encoded(Image.new("L", (99, 99)), "WEBP")
    with monkeypatch.context() as patched:
        patched.setattr("app.decoder._started", never_ends)
        patched.setattr("app.decoder.DECODE_WAIT_S", 0.3)
        with pytest.raises(DataError, match="takes longer than 0.3 s"):
            decoder.read(content, "slow")
        assert started[0].poll() is not None
        decoder.close()
    assert decoder.read(content, "good").image.size == (99, 99)


def test_a_process_that_dies_while_it_sends_gives_a_sentence(decoder, monkeypatch):
    dying = "print('ready', flush=True); input(); print('{\"size\": [99, 99]}'); print('x' * 50)"

    def dies():
        return subprocess.Popen([sys.executable, "-c", dying], stdin=subprocess.PIPE, stdout=subprocess.PIPE)

    monkeypatch.setattr("app.decoder._started", dies)
    with pytest.raises(DataError, match="'slow' could not be read within the time and memory"):
        decoder.read(encoded(Image.new("L", (99, 99)), "WEBP"), "slow")


def test_the_process_ends_by_itself_when_the_server_is_gone():
    process = subprocess.Popen(
        [sys.executable, "-m", "app.decoder"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, cwd=ROOT
    )
    assert process.stdout.readline() == b"ready\n"
    process.communicate(timeout=10)
    assert process.returncode == 0


def test_who_wants_more_memory_than_is_left_waits_for_it():
    budget, order = Budget(100), []

    def second():
        with budget.of(60, lambda: None):
            order.append("second")

    with budget.of(60, lambda: None):
        thread = Thread(target=second)
        thread.start()
        sleep(0.05)
        order.append("first ends")
    thread.join()
    assert order == ["first ends", "second"]


def test_a_wait_for_memory_can_be_ended_and_more_than_all_is_all():
    budget = Budget(100)

    def gone():
        raise DataError("The visitor is gone.")

    with budget.of(1_000, lambda: None):
        began = perf_counter()
        with pytest.raises(DataError, match="gone"), budget.of(1, gone):
            pass
        assert perf_counter() - began < 2
