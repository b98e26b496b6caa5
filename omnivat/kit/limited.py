"""Run a function on another person's bytes in a process with limits on memory and time.

A bound on a file's size bounds neither the memory nor the time that its reader takes. The process
has a limit on each: the system refuses it more, and a timer kills it.

The function takes the bytes and keywords of JSON, and returns an object of JSON and bytes, or
yields several.
"""

import json
import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import suppress
from importlib import import_module
from pathlib import Path
from threading import Timer
from time import process_time
from typing import Any
from weakref import finalize

from omnivat.kit.errors import DataError, OmniVatError, first_line, printable
from omnivat.kit.files import require_regular

# glibc then returns what a large file took, and goes on using what an ordinary one takes
MALLOC = dict.fromkeys(("MALLOC_MMAP_THRESHOLD_", "MALLOC_TRIM_THRESHOLD_"), "4000000")
Process = subprocess.Popen[bytes]


MEMORY, WAIT = 4_000_000_000, 300.0  # of a process that reads a large file
GROWTH = 4  # bytes of memory for each byte of such a file
BYTES_A_SECOND = 10_000_000  # of a file, to which limits grow
Result = tuple[dict[str, Any], bytes]


class Limited:
    """Calls `function`, "module:name", in processes that last, one call at a time in each.

    memory   bytes of such a process
    seconds  of a processor, for a call, or for each that it yields
    wait     seconds until a call is killed, or one that yields nothing
    grows    whether memory and seconds grow with the file that a call names

    `close` ends the processes; they also end with this one.

    >>> import pickle
    >>> limited = Limited("pickle:loads", memory=10**9, seconds=5, wait=60)
    >>> limited(pickle.dumps(({"epoch": 3}, b"own")), over="It takes too much memory.")
    ({'epoch': 3}, b'own')
    >>> limited.close()
    """

    def __init__(
        self,
        function: str,
        *,
        memory: int = MEMORY,
        seconds: int,
        wait: float = WAIT,
        grows: bool = False,
    ) -> None:
        self.function, self.wait = function, wait
        self.limits = [*map(str, (memory, seconds, GROWTH * grows))]
        self._idle: list[Process] = []
        self.close = finalize(self, _end_all, self._idle)

    def __call__(self, content: bytes, over: str, **words: Any) -> Result:
        """Return what the function returns. Raises DataError: the function's, or `over` if it
        takes more than the limits.
        """
        (result,) = self.each(content, over, **words)
        return result

    def each(
        self, content: bytes, over: str, fault: Callable[[str], str] | None = None, **words: Any
    ) -> Iterator[Result]:
        """Yield each that the function yields, but for a value of None, which only renews its
        limits. Errors as of a call; `fault` gives the sentence for an error of another kind.
        """
        process = self._idle.pop() if self._idle else self.started()
        call, ended = json.dumps([len(content), words]).encode() + b"\n" + content, False
        try:
            while not ended:
                late = Timer(self.wait, process.kill)
                late.start()
                try:
                    reply, found = _exchanged(process, call)
                finally:
                    late.cancel()
                if reply is None:
                    raise DataError(over)
                call, ended = b"", "value" not in reply
                if ended:
                    self._idle.append(process)
                if "fault" in reply:
                    raise DataError(fault(reply["fault"]) if fault else over)
                if "error" in reply:
                    raise DataError(reply["error"])
                if reply.get("value") is not None:
                    yield reply["value"], found
        finally:
            if not ended:
                _end_all([process])

    def read(self, file: Path, remedy: str = "export it again", **words: Any) -> Iterator[Result]:
        """Yield each that the function yields of a `file`, which is in every error's sentence."""
        require_regular(file)
        where = f"'{printable(str(file))}'"
        yield from self.each(
            b"",
            f"{where} takes more memory or time than its reader has; {remedy}.",
            lambda why: f"{where} cannot be read ({why}); {remedy}.",
            file=str(file.absolute()),
            **words,
        )

    def started(self) -> Process:
        """Start a process."""
        path = os.pathsep.join(filter(None, [str(Path(__file__).parents[2]), *sys.path]))
        command = [sys.executable, "-m", __name__, self.function]
        return subprocess.Popen(
            [*command, *self.limits],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            env={**os.environ, **MALLOC, "PYTHONPATH": path, "OMP_NUM_THREADS": "1"},
        )


def _exchanged(process: Process, call: bytes) -> tuple[dict[str, Any] | None, bytes]:
    """Send a call (b"" for none); return the next reply and its bytes, or (None, b"") if the
    process has ended.
    """
    assert process.stdin and process.stdout, "the process has pipes"
    try:
        process.stdin.write(call)
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


def serve(function: str, memory: int, seconds: int, grows: int = 0) -> None:
    """Call a function in this process: calls on standard input, results on standard output.

    function  "module:name"
    memory    limit on memory, bytes
    seconds   limit on processor time of a call
    grows     bytes of memory that each byte of the call's file adds to the limit
    """
    module, _, name = function.partition(":")
    call, output = getattr(import_module(module), name), sys.stdout.buffer
    sys.stdout = sys.stderr  # what a reader prints is no reply

    def reply(found: bytes = b"", **about: Any) -> None:
        output.write(json.dumps(about | {"size": len(found)}, default=str).encode() + b"\n")
        output.write(found)
        output.flush()

    while line := sys.stdin.buffer.readline():  # nothing once the caller is gone
        size, words = json.loads(line)
        own = Path(words["file"]).stat().st_size if grows else 0
        limit("RLIMIT_DATA", memory + grows * own)
        try:
            most = 1 + seconds + own // BYTES_A_SECOND
            limit("RLIMIT_CPU", int(process_time()) + most)
            result = call(sys.stdin.buffer.read(size), **words)
            for value, found in [result] if isinstance(result, tuple) else result:
                reply(found, value=value)
                limit("RLIMIT_CPU", int(process_time()) + most)
            reply()
        except OmniVatError as error:
            reply(error=str(error))
        except MemoryError:
            return  # over the limits
        except Exception as error:  # libraries have many kinds for damaged files
            reply(fault=first_line(error))


def limit(kind: str, most: int) -> None:
    """Limit what this process may use, where the system can."""
    with suppress(ImportError, ValueError, OSError):
        import resource

        number = getattr(resource, kind)
        resource.setrlimit(number, (most, resource.getrlimit(number)[1]))


if __name__ == "__main__":
    serve(sys.argv[1], *map(int, sys.argv[2:]))
