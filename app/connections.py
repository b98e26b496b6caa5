"""Limit connections: idle and slow ones are closed, and there are never too many.

Request bodies have a separate time limit (app/requests.py). At the limit, the address with the most
connections loses one, so that one visitor cannot keep the others out.
"""

from asyncio import TimerHandle
from collections import Counter
from contextlib import suppress
from functools import partialmethod
from typing import Any

from uvicorn import config
from uvicorn.protocols.http.auto import AutoHTTPProtocol

from app.limits import CONNECTIONS, DESCRIPTORS, IDLE_S

BACKLOG = 128  # connections that wait to be accepted
_FIRST = config.Config.__init__
LOOKS = 2  # consecutive checks without a request in progress
UNREAD = 6  # consecutive checks in which the visitor reads nothing of a response


class Patient(AutoHTTPProtocol):  # type: ignore[misc, valid-type]
    """uvicorn's HTTP protocol; it closes after IDLE_S without a complete request."""

    waited = unread = unsent = 0
    seen: Any = None
    address = ""
    timer: TimerHandle | None = None

    def connection_made(self, transport: Any) -> None:
        """Start checking the connection."""
        super().connection_made(transport)
        self.address = str((transport.get_extra_info("peername") or [""])[0])
        CROWD[self] = None
        make_room()
        self.timer = self.loop.call_later(IDLE_S / LOOKS, self.look)

    def connection_lost(self, exc: Exception | None) -> None:
        """Stop checking."""
        CROWD.pop(self, None)
        if self.timer is not None:
            self.timer.cancel()
        super().connection_lost(exc)

    @property
    def idle(self) -> bool:
        """True if it waits for a request."""
        return bool(self.cycle is None or self.cycle.response_complete)

    def look(self) -> None:
        """Close the connection if it still waits for a request, or the visitor reads nothing."""
        if self.transport.is_closing():
            return
        unsent = self.transport.get_write_buffer_size()
        waits = self.idle and not unsent
        self.waited = self.waited + 1 if waits and self.cycle is self.seen else int(waits)
        self.seen = self.cycle
        self.unread = self.unread + 1 if unsent and unsent == self.unsent else 0
        self.unsent = unsent
        if self.unread >= UNREAD:
            self.transport.abort()
        elif self.waited >= LOOKS:
            self.transport.close()
        else:
            self.timer = self.loop.call_later(IDLE_S / LOOKS, self.look)


CROWD: dict[Patient, None] = {}  # open connections, oldest first
room = CONNECTIONS


def make_room() -> None:
    """Close one connection beyond `room`: of the address with most, the longest idle or the newest."""
    if len(CROWD) <= room:
        return
    (most, _), *_ = Counter(one.address for one in CROWD).most_common(1)
    theirs = [one for one in CROWD if one.address == most]
    one = next((one for one in theirs if one.idle and one is not theirs[-1]), theirs[-1])
    del CROWD[one]
    one.transport.abort()


def descriptors() -> int:
    """Raise this process's limit of open files to DESCRIPTORS where allowed; return the limit."""
    with suppress(ImportError, ValueError, OSError):
        import resource

        soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
        if soft < DESCRIPTORS:
            soft = DESCRIPTORS if hard == resource.RLIM_INFINITY else min(hard, DESCRIPTORS)
            resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))
        return int(soft)
    return DESCRIPTORS


def install() -> None:
    """Use it in every server of this process, without WebSocket: Gradio's server has no such settings."""
    global room
    room = min(CONNECTIONS, descriptors() // 3)  # a request may open files, too
    config.HTTP_PROTOCOLS["auto"] = f"{__name__}:{Patient.__name__}"
    config.WS_PROTOCOLS["auto"] = None
    kind: Any = config.Config
    # asyncio accepts the whole backlog before any connection can be counted
    kind.__init__ = partialmethod(_FIRST, backlog=BACKLOG)
