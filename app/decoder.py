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
from threading import Timer
from time import process_time
from typing import TYPE_CHECKING, Any
from weakref import finalize

from app.limits import DECODE_S, DECODE_WAIT_S, DECODER_BYTES
from omnivat.kit.errors import DataError, OmniVatError
from omnivat.kit.progress import checkpoint

if TYPE_CHECKING:
    from PIL import Image

# glibc then returns what a large picture took
MALLOC = dict.fromkeys(("MALLOC_MMAP_THRESHOLD_", "MALLOC_TRIM_THRESHOLD_"), "1000000")
Process = subprocess.Popen[bytes]


@dataclass(frozen=True, slots=True, kw_only=True)
class Picture:
    """A decoded picture, upright RGB, perhaps scaled down, and its original size."""

    image: "Image.Image"
    width: int
    height: int


class Decoder:
    """Reads visitors' images; one instance for the server. `close` ends its processes."""

    def __init__(self) -> None:
        self._idle: list[Process] = []
        self.close = finalize(self, _end_all, self._idle)

    def read(self, source: bytes | Path, name: str) -> Picture:
        """Return the picture in bytes or a file. Raises DataError with its `name` for an
        unsupported one.
        """
        from PIL import Image

        from omnivat.data.images import read_bytes

        checkpoint()
        content = read_bytes(source, name)
        process = self._idle.pop() if self._idle else _started()
        late = Timer(DECODE_WAIT_S, process.kill)
        late.start()
        reply, pixels = _exchanged(process, name, content)
        late.cancel()
        if reply:
            self._idle.append(process)
        else:
            _end_all([process])
        checkpoint()
        if "size" not in reply:
            raise DataError(
                reply.get("error")
                or f"'{name}' could not be read within the time and memory allowed; scale it down,"
                " or save it as PNG or JPEG."
            )
        width, height = reply["of"]
        image = Image.frombytes("RGB", reply["size"], pixels)
        return Picture(image=image, width=width, height=height)


def _exchanged(process: Process, name: str, content: bytes) -> tuple[dict[str, Any], bytes]:
    """Send one picture to a process; return its reply and pixels, or nothing if it dies."""
    assert process.stdin and process.stdout, "the process has pipes"
    try:
        question = {"size": len(content), "name": name}
        process.stdin.write(json.dumps(question).encode() + b"\n" + content)
        process.stdin.flush()
        reply = json.loads(process.stdout.readline())
        wide, high = reply.get("size", (0, 0))
        pixels = process.stdout.read(3 * wide * high)
    except (OSError, ValueError):
        return {}, b""
    return (reply, pixels) if len(pixels) == 3 * wide * high else ({}, b"")


def _started() -> Process:
    path = os.pathsep.join(filter(None, [str(Path(__file__).parents[1]), *sys.path]))
    return subprocess.Popen(
        [sys.executable, "-m", "app.decoder"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        env={**os.environ, **MALLOC, "PYTHONPATH": path, "OMP_NUM_THREADS": "1"},
    )


def _end_all(processes: list[Process]) -> None:
    while processes:
        with suppress(OSError), processes.pop() as process:
            process.kill()


def serve() -> None:
    """Read pictures in this process: requests on standard input, pixels on standard output."""
    from omnivat.data.images import VISITORS, opened, upright

    limit("RLIMIT_DATA", DECODER_BYTES)
    output = sys.stdout.buffer
    while line := sys.stdin.buffer.readline():  # nothing once the server is gone
        limit("RLIMIT_CPU", int(process_time()) + 1 + DECODE_S)
        question = json.loads(line)
        content, name = sys.stdin.buffer.read(question["size"]), question["name"]
        try:
            picture = opened(content, name, **VISITORS)
            of = picture.size
            image = upright(picture, name)
        except OmniVatError as error:
            output.write(json.dumps({"error": str(error)}).encode() + b"\n")
        else:
            if (of[0] > of[1]) != (image.width > image.height):  # it was rotated upright
                of = of[::-1]
            output.write(json.dumps({"size": image.size, "of": of}).encode() + b"\n")
            output.write(image.tobytes())
        output.flush()


def limit(kind: str, most: int) -> None:
    """Limit what this process may use, where the system can."""
    with suppress(ImportError, ValueError, OSError):
        import resource

        number = getattr(resource, kind)
        resource.setrlimit(number, (most, resource.getrlimit(number)[1]))


if __name__ == "__main__":
    serve()
