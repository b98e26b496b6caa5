"""Freed memory goes back to the system, of which glibc would keep hundreds of megabytes.

Each thread takes memory from an arena, where what it frees stays. Few arenas, large blocks outside
them, and a trim after work keep the server at what it uses; other systems need none of these.
"""

import ctypes
from contextlib import suppress
from threading import Lock, Timer

MOST_ARENAS = 2
# Bytes of a block that is mapped by itself; glibc would raise this to 32 MB. The layers of the
# encoder have up to 5 MB: to map each anew would take a third of the time of an upload.
LARGE = 6 << 20
FREE = 12 << 20  # bytes at the end of an arena that wait for the trim; 128 kB by default
PAUSE_S = 2.0  # from the end of some work to the trim, which more work shares


def share_arenas() -> None:
    """Limit the arenas of this process and what they hold, before it has threads."""
    _glibc("mallopt", -8, MOST_ARENAS)  # -8 is M_ARENA_MAX
    _glibc("mallopt", -3, LARGE)  # -3 is M_MMAP_THRESHOLD
    _glibc("mallopt", -1, FREE)  # -1 is M_TRIM_THRESHOLD


class Trim:
    """Gives freed memory back, once for all requests of `pause_s` seconds."""

    def __init__(self, pause_s: float = PAUSE_S) -> None:
        self._pause_s, self._lock = pause_s, Lock()
        self._pending: Timer | None = None

    def soon(self) -> None:
        """Trim after the pause; return at once."""
        with self._lock:
            if self._pending is None:
                self._pending = Timer(self._pause_s, self._now)
                self._pending.daemon = True
                self._pending.start()

    def _now(self) -> None:
        with self._lock:
            self._pending = None
        _glibc("malloc_trim", 0)


def _glibc(name: str, *arguments: int) -> None:
    """Call a function of glibc; nothing happens on a system without it."""
    with suppress(AttributeError, OSError, TypeError):
        getattr(ctypes.CDLL(None), name)(*arguments)


TRIM = Trim()
