"""Run a function on another person's bytes in a process with limits on memory and time.

A bound on a file's size bounds neither the memory nor the time that its reader takes. The process
has a limit on each: the system refuses it more, and a timer kills it.

The function takes the bytes and keywords of JSON, and returns an object of JSON and bytes.
"""

import json
import os
import subprocess
import sys
from contextlib import suppress
from importlib import import_module
from pathlib import Path
from threading import Timer
from time import process_time
from typing import Any
from weakref import finalize

from omnivat.kit.errors import DataError, OmniVatError

# glibc then returns what a large file took, and goes on using what an ordinary one takes
MALLOC = dict.fromkeys(("MALLOC_MMAP_THRESHOLD_", "MALLOC_TRIM_THRESHOLD_"), "4000000")
Process = subprocess.Popen[bytes]


class Limited:
    """Calls `function`, "module:name", in processes that last, one call at a time in each.

    memory   bytes of such a process
    seconds  of a processor, for a call
    wait     seconds until a call is killed

    `close` ends the processes; they also end with this one.

    >>> import pickle
    >>> limited = Limited("pickle:loads", memory=10**9, seconds=5, wait=60)
    >>> limited(pickle.dumps(({"epoch": 3}, b"own")), over="It takes too much memory.")
    ({'epoch': 3}, b'own')
    >>> limited.close()
    """

    def __init__(self, function: str, *, memory: int, seconds: int, wait: float) -> None:
        self.function, self.memory, self.seconds, self.wait = function, memory, seconds, wait
        self._idle: list[Process] = []
        self.close = finalize(self, _end_all, self._idle)

    def __call__(self, content: bytes, over: str, **words: Any) -> tuple[dict[str, Any], bytes]:
        """Return what the function returns. Raises DataError: the function's, or `over` if it
        takes more than the limits.
        """
        process = self._idle.pop() if self._idle else self.started()
        late = Timer(self.wait, process.kill)
        late.start()
        try:
            reply, found = _exchanged(process, content, words)
        except BaseException:
            _end_all([process])
            raise
        finally:
            late.cancel()
        if reply is None:
            _end_all([process])
            raise DataError(over)
        self._idle.append(process)
        if "error" in reply:
            raise DataError(reply["error"])
        return reply["value"], found

    def started(self) -> Process:
        """Start a process."""
        path = os.pathsep.join(filter(None, [str(Path(__file__).parents[2]), *sys.path]))
        command = [sys.executable, "-m", __name__, self.function]
        return subprocess.Popen(
            [*command, str(self.memory), str(self.seconds)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            env={**os.environ, **MALLOC, "PYTHONPATH": path, "OMP_NUM_THREADS": "1"},
        )


def _exchanged(
    process: Process, content: bytes, words: dict[str, Any]
) -> tuple[dict[str, Any] | None, bytes]:
    """Send one call; return its reply and bytes, or None if the process dies."""
    assert process.stdin and process.stdout, "the process has pipes"
    try:
        process.stdin.write(json.dumps([len(content), words]).encode() + b"\n" + content)
        process.stdin.flush()
        reply = json.loads(process.stdout.readline())
        found = process.stdout.read(reply["size"])
    except (OSError, ValueError):
        return None, b""
    return (reply, found) if len(found) == reply["size"] else (None, b"")


def _end_all(processes: list[Process]) -> None:
    while processes:
        with suppress(OSError), processes.pop() as process:
            process.kill()


def serve(function: str, memory: int, seconds: int) -> None:
    """Call the function in this process: calls on standard input, results on standard output."""
    module, _, name = function.partition(":")
    call, output = getattr(import_module(module), name), sys.stdout.buffer
    sys.stdout = sys.stderr  # what a reader prints is no reply
    limit("RLIMIT_DATA", memory)
    while line := sys.stdin.buffer.readline():  # nothing once the caller is gone
        limit("RLIMIT_CPU", int(process_time()) + 1 + seconds)
        size, words = json.loads(line)
        found = b""
        try:
            value, found = call(sys.stdin.buffer.read(size), **words)
            reply = {"value": value, "size": len(found)}
        except OmniVatError as error:
            reply = {"error": str(error), "size": 0}
        output.write(json.dumps(reply).encode() + b"\n")
        output.write(found)
        output.flush()


def limit(kind: str, most: int) -> None:
    """Limit what this process may use, where the system can."""
    with suppress(ImportError, ValueError, OSError):
        import resource

        number = getattr(resource, kind)
        resource.setrlimit(number, (most, resource.getrlimit(number)[1]))


if __name__ == "__main__":
    serve(sys.argv[1], *map(int, sys.argv[2:]))
