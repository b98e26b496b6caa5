"""The threads of the server's jobs; idle ones wait for the next job."""

from collections.abc import Callable
from queue import SimpleQueue
from threading import Lock, Thread, current_thread
from time import monotonic

KEPT_THREADS = 4  # idle ones
Inbox = SimpleQueue[Callable[[], None] | None]


class JobThreads:
    """Threads that run jobs. KEPT_THREADS idle ones wait for the next job: a new one costs as
    much as a drag.
    """

    def __init__(self) -> None:
        self._lock = Lock()
        self._idle: list[Inbox] = []
        self._all: set[Thread] = set()
        self._closed = False

    def run(self, work: Callable[[], None]) -> None:
        """Run `work` in an idle thread or in a new one. Raises RuntimeError if the system has
        none left.
        """
        with self._lock:
            inbox = self._idle.pop() if self._idle else None
        if inbox is None:
            inbox = SimpleQueue()
            Thread(target=self._serve, args=(inbox,), name="job", daemon=True).start()
        inbox.put(work)

    def _serve(self, inbox: Inbox) -> None:
        self._all.add(own := current_thread())
        try:
            while (work := inbox.get()) is not None:
                work()
                del work  # it would keep what the job held
                with self._lock:
                    if self._closed or len(self._idle) >= KEPT_THREADS:
                        return
                    self._idle.append(inbox)
        finally:
            self._all.discard(own)

    def close(self, until: float) -> None:
        """End the idle threads; wait for the others until then."""
        with self._lock:
            self._closed = True
            idle, self._idle = self._idle, []
        for inbox in idle:
            inbox.put(None)
        for thread in list(self._all):
            thread.join(max(0.0, until - monotonic()))
