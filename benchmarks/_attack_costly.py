"""Image files with a decoding cost far above their size, and its measurement."""

import os
import struct
import zlib
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path
from resource import RUSAGE_CHILDREN, RUSAGE_SELF, getrusage
from threading import Event, Thread
from time import sleep
from typing import Any

import numpy as np
from PIL import Image

MOST_S, MOST_MB, FOUR_MB = 1.0, 150, 400  # limits: CPU seconds and memory of one, memory of four
REST_S = 3.0  # seconds after which memory must be released
OWN = Path("/proc/self/cmdline").read_bytes() if Path("/proc/self/cmdline").exists() else b""


def costly() -> Iterator[tuple[str, bytes]]:
    """Yield names and files of at most 20 MB: the largest accepted ones, and larger ones."""
    random = np.random.default_rng(0)
    noise = Image.fromarray(random.integers(0, 256, (1990, 2000, 3), dtype=np.uint8))
    slope = np.add.outer(np.arange(3400), np.arange(3600)).astype(np.uint8)
    soft = Image.fromarray(np.stack([slope, slope[::-1], slope[:, ::-1]], -1))
    plain = Image.new
    yield from {
        "WebP, 34 bytes, 64 megapixels": _file(plain("RGBA", (8000, 8000)), "WEBP", lossless=True),
        "WebP, noise": _file(noise, "WEBP", quality=100, method=0),
        "WebP, lossless noise": _file(noise, "WEBP", lossless=True, method=0, quality=0),
        "JPEG, progressive noise": _file(noise.resize((3200, 2800)), "JPEG", progressive=True),
        "JPEG, 64 megapixels": _file(plain("RGB", (8000, 8000), 1), "JPEG"),
        "JPEG, 64 megapixels, progressive": _file(plain("RGB", (8000, 8000), 1), "JPEG", progressive=True),
        "JPEG, CMYK": _file(plain("CMYK", (7000, 7000), 1), "JPEG"),
        "PNG, soft": _file(soft, "PNG", compress_level=1),
        "PNG, transparent": _file(plain("RGBA", (3500, 3500), (1, 2, 3, 4)), "PNG"),
        "PNG, 16 bits grey": _file(Image.fromarray(np.zeros((4890, 4890), np.uint16)), "PNG"),
        "PNG, interlaced, 16 bits RGBA": interlaced(2820, 2820),
        "TIFF, deflate": _file(soft, "TIFF", compression="tiff_adobe_deflate"),
        "TIFF, LZW": _file(noise, "TIFF", compression="tiff_lzw"),
        "TIFF, floating": _file(Image.fromarray(np.zeros((3500, 3500), np.float32)), "TIFF", compression="tiff_lzw"),
        "GIF": _file(plain("P", (4000, 4000), 1), "GIF"),
        "BMP": _file(soft.resize((2500, 2600)), "BMP"),
        "JPEG 2000": _file(plain("RGB", (4000, 4000)), "JPEG2000"),
        "PPM, a comment of 19 MB": b"P6\n#" + b"x" * 19_000_000 + b"\n9 9\n255\n" + bytes(243),
        **_noted(),
    }.items()


def _noted() -> dict[str, bytes]:
    """Return small pictures with large notes: EXIF tables, comments, fill bytes."""
    small = Image.new("RGB", (600, 600), 5)
    jpeg, png = _file(small, "JPEG"), _file(small, "PNG")
    gif = _file(small.convert("P"), "GIF")
    entries = b"".join(struct.pack("<HHII", k, 2, 200_000, 8) for k in range(65_000))
    table = b"II*\0\x08\0\0\0" + struct.pack("<H", 65_000) + entries + bytes(200_000)
    at = png.index(b"IDAT") - 4
    part = b"\xff\xe1" + struct.pack(">H", 65_008) + b"Exif\0\0" + bytes(65_000)
    return {
        "PNG, 1 MB of EXIF entries": png[:at] + _chunk(b"eXIf", table) + png[at:],
        "JPEG, 300 EXIF parts": jpeg[:2] + part * 300 + jpeg[2:],
        "JPEG, 19 MB of fill bytes": jpeg[:2] + b"\xff" * 19_000_000 + jpeg[2:],
        "JPEG, 9 million starts of a scan": _file(small, "JPEG", progressive=True) + b"\xff\xda" * 9_000_000,
        "GIF, 1.2 MB of comments": gif.replace(b"\x2c", b"\x21\xfe" + (b"\xff" + bytes(255)) * 4_900 + b"\0\x2c", 1),
        "PNG, 8 x 1.9 million": _file(Image.new("RGBA", (8, 1_900_000)), "PNG"),
    }


def _chunk(name: bytes, body: bytes) -> bytes:
    return struct.pack(">I", len(body)) + name + body + struct.pack(">I", zlib.crc32(name + body))


def _file(image: Image.Image, kind: str, **options: Any) -> bytes:
    with BytesIO() as handle:
        image.save(handle, kind, **options)
        return handle.getvalue()


def interlaced(width: int, height: int) -> bytes:
    """Return a PNG of one colour, 16 bits RGBA, in the seven passes of Adam7."""
    passes = ((0, 0, 8, 8), (4, 0, 8, 8), (0, 4, 4, 8), (2, 0, 4, 4), (0, 2, 2, 4))
    packer, parts = zlib.compressobj(6), []
    for left, top, across, down in (*passes, (1, 0, 2, 2), (0, 1, 1, 2)):
        row = b"\4" + bytes([7]) * (8 * -(-(width - left) // across))
        parts += [packer.compress(row) for _ in range(-(-(height - top) // down))]
    head = struct.pack(">IIBBBBB", width, height, 16, 6, 0, 0, 1)
    chunks = ((b"IHDR", head), (b"IDAT", b"".join(parts) + packer.flush()), (b"IEND", b""))
    return b"\x89PNG\r\n\x1a\n" + b"".join(_chunk(name, body) for name, body in chunks)


def measured(decoder: Any, on_file: Callable[[str, dict[str, Any]], None]) -> dict[str, Any]:
    """Decode each costly file alone, then four at once; return the memory of the four.

    on_file  called with the name, CPU seconds, added memory (MB) and result of each
    """
    from omnivat.kit.errors import DataError

    def read(content: bytes) -> str:
        try:
            return str(decoder.read(content, "x").image.size)
        except DataError as error:
            return str(error)

    files = dict(costly())
    read(files["BMP"])  # a process waits from here on
    sleep(REST_S)
    for name, content in files.items():
        before = _seconds()
        with watched() as memory:
            said = read(content)
        found = {"processor_s": round(_seconds() - before, 2), "mb": memory[0], "said": said}
        on_file(name, found)
        sleep(0.5)
    sleep(REST_S)
    four = [files[n] for n in ("PNG, soft", "PNG, transparent", "TIFF, deflate", "WebP, noise")]
    with watched() as memory, ThreadPoolExecutor(4) as crowd:
        list(crowd.map(read, four))
    sleep(REST_S)
    return {"mb": memory[0], "kept_mb": round(_tree_mb() - memory[1])}


@contextmanager
def watched() -> Iterator[list[int]]:
    """Yield a list that then has the memory growth (MB) of this process and its children."""
    base, peak, ended = _tree_mb(), [0.0], Event()

    def watch() -> None:
        while not ended.wait(0.004):
            peak[0] = max(peak[0], _tree_mb())

    thread, found = Thread(target=watch, daemon=True), [0, round(base)]
    thread.start()
    yield found
    ended.set()
    thread.join()
    found[0] = max(0, round(peak[0] - base))


def _tree_mb() -> float:
    """Return the private memory of this process and its children, in MB."""
    ours = [os.getpid()]
    for task in Path("/proc/self/task").iterdir():
        try:
            ours += map(int, (task / "children").read_text(encoding="ascii").split())
        except OSError:  # the thread has ended
            continue
    return sum(map(_own_mb, ours))


def _own_mb(process: int) -> float:
    """Return the private memory of one process; 0 if it is starting."""
    try:
        folder = Path(f"/proc/{process}")
        if process != os.getpid() and (folder / "cmdline").read_bytes() == OWN:
            return 0.0
        status = (folder / "status").read_text(encoding="ascii", errors="replace")
    except OSError:
        return 0.0
    return sum(int(line.split()[1]) for line in status.splitlines() if line[:7] == "RssAnon") / 1024


def _seconds() -> float:
    return sum(used.ru_utime + used.ru_stime for used in map(getrusage, (RUSAGE_SELF, RUSAGE_CHILDREN)))
