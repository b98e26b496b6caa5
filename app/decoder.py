"""Decode visitors' images in processes that last, one image at a time each; one that takes too long
is killed.

A process has limited memory, and DECODE_S seconds of a processor for each image. The lane of short
requests bounds how many decode at once.
"""

import json
import os
import subprocess
import sys
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from threading import Lock, Thread
from time import monotonic
from typing import TYPE_CHECKING, Any
from weakref import finalize

from app.limits import DECODE_S, DECODE_WAIT_S, DECODER_BYTES
from omnivat.kit.errors import DataError, OmniVatError
from omnivat.kit.progress import checkpoint

if TYPE_CHECKING:
    from PIL import Image

KEPT = 2  # idle processes
# glibc then returns what a large picture took
MALLOC = dict.fromkeys(("MALLOC_MMAP_THRESHOLD_", "MALLOC_TRIM_THRESHOLD_"), "1000000")
LOOK_S = 0.1  # seconds between two checkpoints of a request that waits
READY = b"ready\n"
Process = subprocess.Popen[bytes]


@dataclass(frozen=True, slots=True, kw_only=True)
class Picture:
    """A decoded picture, upright RGB, perhaps scaled down, and its original size."""

    image: "Image.Image"
    width: int
    height: int


class Decoder:
    """Reads visitors' images; one instance for the server."""

    def __init__(self) -> None:
        self._lock = Lock()
        self._idle: list[Process] = []
        self._closed = False
        finalize(self, _end_all, self._idle)  # at exit, too

    def read(self, source: bytes | Path, name: str) -> Picture:
        """Return the picture in bytes or a file. Raises DataError with its `name` for an
        unsupported one.
        """
        checkpoint()
        with self._lock:
            process = self._idle.pop() if self._idle else None
        process = process or _started()
        reply: list[tuple[dict[str, Any], bytes]] = []
        exchange = Thread(target=_exchange, args=(process, source, name, reply), daemon=True)
        began, lasts = monotonic(), False
        exchange.start()
        try:
            while True:
                exchange.join(LOOK_S)
                checkpoint()  # once at least, also after a reply that came at once
                if not exchange.is_alive() or monotonic() - began >= DECODE_WAIT_S:
                    break
            lasts = bool(reply) and not self._closed
        finally:
            with self._lock:
                if lasts and len(self._idle) < KEPT:
                    self._idle.append(process)
                else:
                    _end(process)
        exchange.join()
        return _picture(
            name, reply[0] if reply else None, late=monotonic() - began >= DECODE_WAIT_S
        )

    def close(self) -> None:
        """End the idle processes."""
        with self._lock:
            self._closed = True
            _end_all(self._idle)


def _picture(name: str, reply: tuple[dict[str, Any], bytes] | None, *, late: bool) -> Picture:
    from PIL import Image

    if reply is None and late:
        raise DataError(
            f"'{name}' takes longer than {DECODE_WAIT_S} s to read; save it as PNG or JPEG and try"
            " again."
        )
    header, pixels = reply or ({}, b"")
    wide, high = header.get("size", (0, 0))
    if not wide or len(pixels) != 3 * wide * high:
        killed = (
            "could not be read within the time and memory allowed; scale it down, or save it as"
            " JPEG."
        )
        raise DataError(header.get("error") or f"'{name}' {killed}")
    width, height = header["of"]
    image = Image.frombuffer("RGB", (wide, high), pixels, "raw", "RGB", 0, 1).copy()
    return Picture(image=image, width=width, height=height)


def _exchange(
    process: Process, source: bytes | Path, name: str, reply: list[tuple[dict[str, Any], bytes]]
) -> None:
    """Send one picture to a process and take its reply; none if it dies."""
    content = source if isinstance(source, bytes) else b""
    question = {
        "file": "" if isinstance(source, bytes) else str(source),
        "size": len(content),
        "name": name,
    }
    with suppress(OSError, ValueError):
        assert process.stdin and process.stdout, "the process has pipes"
        process.stdin.write(json.dumps(question).encode() + b"\n" + content)
        process.stdin.flush()
        header = json.loads(process.stdout.readline())
        wide, high = header.get("size", (0, 0))
        reply.append((header, process.stdout.read(3 * wide * high)))


def _started() -> Process:
    path = os.pathsep.join(filter(None, [str(Path(__file__).parents[1]), *sys.path]))
    process = subprocess.Popen(
        [sys.executable, "-m", "app.decoder"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        env={**os.environ, **MALLOC, "PYTHONPATH": path, "OMP_NUM_THREADS": "1"},
    )
    if process.stdout is None or process.stdout.readline() != READY:
        _end(process)
        raise DataError("No process can be started to read the image; try again in a minute.")
    return process


def _end_all(processes: list[Process]) -> None:
    while processes:
        _end(processes.pop())


def _end(process: Process) -> None:
    process.kill()
    process.wait()
    for pipe in (process.stdin, process.stdout):
        with suppress(OSError):
            if pipe:
                pipe.close()


def serve() -> None:
    """Read pictures in this process: requests on standard input, pixels on standard output."""
    from omnivat.data.images import VISITORS, opened, upright

    limit(memory=True)
    for kind in ("Png", "Jpeg", "WebP", "Gif", "Bmp", "Tiff"):  # imported before a request arrives
        __import__(f"PIL.{kind}ImagePlugin")
    output = sys.stdout.buffer
    output.write(READY)
    output.flush()
    while line := sys.stdin.buffer.readline():  # nothing once the server is gone
        limit()
        question = json.loads(line)
        sent = sys.stdin.buffer.read(question["size"])
        try:
            content = sent or Path(question["file"]).read_bytes() if question["file"] else sent
            if not content:
                raise DataError(
                    f"'{question['name']}' is empty (0 bytes); copy or save the image again."
                )
            held = opened(content, question["name"], limits=VISITORS)
            of = held.size
            image = upright(held, question["name"])
        except OmniVatError as error:
            output.write(json.dumps({"error": str(error)}).encode() + b"\n")
        else:
            if (of[0] > of[1]) != (image.width > image.height):  # it was rotated upright
                of = of[::-1]
            output.write(json.dumps({"size": image.size, "of": of}).encode() + b"\n")
            output.write(image.tobytes())
        output.flush()


def limit(*, memory: bool = False) -> None:
    """Allow this process DECODE_S more seconds of a processor or, at its start, limit its
    memory.
    """
    with suppress(ImportError, ValueError, OSError):
        import resource

        if memory:
            resource.setrlimit(resource.RLIMIT_DATA, (DECODER_BYTES, DECODER_BYTES))
        else:
            used = resource.getrusage(resource.RUSAGE_SELF)
            _, most = resource.getrlimit(resource.RLIMIT_CPU)
            resource.setrlimit(
                resource.RLIMIT_CPU, (int(used.ru_utime + used.ru_stime) + 1 + DECODE_S, most)
            )


if __name__ == "__main__":
    serve()
