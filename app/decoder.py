"""Decode visitors' images within a memory budget, without hanging the server.

A small plain JPEG or PNG is decoded here. Any other image is decoded by a separate process for one
image, with limited memory; it is killed if it takes too long.
"""

import ctypes
import json
import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from mmap import ACCESS_READ, mmap
from pathlib import Path
from threading import Condition, Lock, Timer
from typing import TYPE_CHECKING, Any

from app.limits import DECODE_S, DECODE_WAIT_S, DECODER_BYTES, IMAGE_MEMORY
from omnivat.kit.errors import DataError, OmniVatError

if TYPE_CHECKING:
    from PIL import Image

SIMPLE_BYTES = 4_000_000  # a larger file is read by a separate process
LARGE = 8_000_000  # bytes of a picture; beyond, freed memory is returned to the system
M_MMAP_THRESHOLD = -3  # of mallopt(3)
MAPPED = 5_000_000  # bytes; the encoder's largest tensor has 4.8 million and is faster in memory that stays
HAND_BACK_S = 1.0  # seconds after a large picture was decoded
READY = b"ready\n"
Check = Callable[[], None]


@dataclass(frozen=True, slots=True, kw_only=True)
class Picture:
    """A decoded picture, upright RGB, perhaps scaled down, and its original size."""

    image: "Image.Image"
    width: int
    height: int


class Budget:
    """Memory shared by all requests; a request for more than is left waits."""

    def __init__(self, total: int = IMAGE_MEMORY) -> None:
        self._total = self._left = total
        self._changed = Condition()

    @contextmanager
    def of(self, wanted: int, check: Check) -> Iterator[None]:
        """Reserve `wanted` bytes, at most the whole budget; `check` may end the wait."""
        wanted = min(wanted, self._total)
        with self._changed:
            while not self._changed.wait_for(lambda: self._left >= wanted, timeout=0.1):
                check()
            self._left -= wanted
        try:
            yield
        finally:
            with self._changed:
                self._left += wanted
                self._changed.notify_all()


class Decoder:
    """Reads visitors' images; one instance for the server."""

    def __init__(self) -> None:
        self._budget = Budget()
        self._lock = Lock()
        self._spare: subprocess.Popen[bytes] | None = None
        self._timer: Timer | None = None
        self._closed = False
        # glibc raises this limit by itself, and pictures decoded in several threads then leave 70 MB behind
        _libc("mallopt", M_MMAP_THRESHOLD, MAPPED)

    def read(self, source: bytes | Path, name: str, check: Check = lambda: None) -> Picture:
        """Return the picture in bytes or a file. Raises DataError with its `name` for an unsupported one.

        check  called while waiting for other pictures; an error it raises ends the wait
        """
        from omnivat.data.images import VISITORS, draft_scale, examined, read_image

        with _content(source, name) as content:
            found = examined(content, name, limits=VISITORS)
            cost = found.cost(draft_scale(found.width, found.height) if found.kind == "JPEG" else 1)
            with self._budget.of(int(cost) + 2 * len(content), check):
                if found.simple and len(content) <= SIMPLE_BYTES:
                    image = read_image(bytes(content), name, limits=VISITORS)
                else:
                    image = self._elsewhere(source, content, name)
        if image.width * image.height * 4 > LARGE:
            self._hand_back_soon()
        turned = (found.width > found.height) != (image.width > image.height)  # it was rotated upright
        width, height = (found.height, found.width) if turned else (found.width, found.height)
        return Picture(image=image, width=width, height=height)

    def _elsewhere(self, source: bytes | Path, content: Any, name: str) -> "Image.Image":
        """Read the picture in a process that can be killed."""
        from PIL import Image

        file, size = (str(source), 0) if isinstance(source, Path) else ("", len(content))
        question = json.dumps({"file": file, "size": size, "name": name}).encode() + b"\n"
        with self._lock:
            process, self._spare = self._spare or _started(), None
        if process.stdout is None or process.stdout.readline() != READY:
            raise DataError("No process can be started to read the image; try again in a minute.")
        try:
            output, _ = process.communicate(question + (content[:] if size else b""), DECODE_WAIT_S)
        except subprocess.TimeoutExpired as error:
            raise DataError(
                f"'{name}' takes longer than {DECODE_WAIT_S} s to read; save it as PNG or JPEG and try again."
            ) from error
        finally:
            process.kill()
            process.communicate()
            with self._lock:
                if self._spare is None and not self._closed:
                    self._spare = _started()  # the next picture will find it ready
        line, _, pixels = output.partition(b"\n")
        header = json.loads(line) if line.endswith(b"}") else {}
        wide, high = header.get("size", (0, 0))
        if not wide or len(pixels) != 3 * wide * high:  # it may have been killed halfway
            killed = "could not be read within the time and memory allowed; scale it down, or save it as JPEG."
            raise DataError(header.get("error") or f"'{name}' {killed}")
        return Image.frombuffer("RGB", (wide, high), pixels, "raw", "RGB", 0, 1).copy()

    def _hand_back_soon(self) -> None:
        """Return freed memory to the system once the picture has been used and dropped."""
        with self._lock:
            if self._timer is None or not self._timer.is_alive():
                self._timer = Timer(HAND_BACK_S, _libc, ("malloc_trim", 0))
                self._timer.daemon = True
                self._timer.start()

    def close(self) -> None:
        """Stop the waiting process."""
        with self._lock:
            self._closed = True
            if self._spare is not None:
                self._spare.kill()
                self._spare.communicate()
            self._spare = None


@contextmanager
def _content(source: bytes | Path, name: str) -> Iterator[bytes | mmap]:
    """Yield the bytes of a picture; a file is memory-mapped."""
    if not (source if isinstance(source, bytes) else source.stat().st_size):
        raise DataError(f"'{name}' is empty (0 bytes); copy or save the image again.")
    if isinstance(source, bytes):
        yield source
    else:
        with source.open("rb") as handle, mmap(handle.fileno(), 0, access=ACCESS_READ) as content:
            yield content


def _started() -> "subprocess.Popen[bytes]":
    path = os.pathsep.join(filter(None, [str(Path(__file__).parents[1]), *sys.path]))
    return subprocess.Popen(
        [sys.executable, "-m", "app.decoder"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        env={**os.environ, "PYTHONPATH": path, "OMP_NUM_THREADS": "1"},
    )


def _libc(function: str, *numbers: int) -> None:
    """Call a function of the system's C library, where it has it."""
    with suppress(OSError, AttributeError):
        if sys.platform == "linux":
            getattr(ctypes.CDLL("libc.so.6"), function)(*numbers)


def serve() -> None:
    """Read one picture in this process: request on standard input, pixels on standard output."""
    from omnivat.data.images import VISITORS, read_image

    with suppress(ImportError, ValueError, OSError):
        import resource

        resource.setrlimit(resource.RLIMIT_DATA, (DECODER_BYTES, DECODER_BYTES))
        resource.setrlimit(resource.RLIMIT_CPU, (DECODE_S, DECODE_S))
    for kind in ("Png", "Jpeg", "WebP", "Gif", "Bmp", "Tiff"):  # imported before a request arrives
        __import__(f"PIL.{kind}ImagePlugin")
    output = sys.stdout.buffer
    output.write(READY)
    output.flush()
    line = sys.stdin.buffer.readline()
    if not line:  # the server is gone
        return
    question = json.loads(line)
    source = Path(question["file"]) if question["file"] else sys.stdin.buffer.read(question["size"])
    try:
        image = read_image(source, question["name"], limits=VISITORS)
    except OmniVatError as error:
        output.write(json.dumps({"error": str(error)}).encode() + b"\n")
    else:
        output.write(json.dumps({"size": image.size}).encode() + b"\n")
        output.write(image.tobytes())
    output.flush()


if __name__ == "__main__":
    serve()
