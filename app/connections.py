"""Connections that keep the server waiting are closed: a silent one, or a request's head in drips.

The bodies of requests have a time limit of their own (app/requests.py).
"""

from asyncio import TimerHandle
from typing import Any

from uvicorn import config
from uvicorn.protocols.http.auto import AutoHTTPProtocol

from app.limits import IDLE_S

LOOKS = 2  # in a row at which no request is being answered


class Patient(AutoHTTPProtocol):  # type: ignore[misc, valid-type]
    """uvicorn's own HTTP, closed when no request comes of it within IDLE_S."""

    waited = 0
    seen: Any = None
    timer: TimerHandle | None = None

    def connection_made(self, transport: Any) -> None:
        """Look at the connection now and then."""
        super().connection_made(transport)
        self.timer = self.loop.call_later(IDLE_S / LOOKS, self.look)

    def connection_lost(self, exc: Exception | None) -> None:
        """Look no more."""
        if self.timer is not None:
            self.timer.cancel()
        super().connection_lost(exc)

    def look(self) -> None:
        """Close the connection where it waits for a request, as it did before."""
        if self.transport.is_closing() or self.transport.get_protocol() is not self:
            return  # closed, or a websocket by now
        waits = self.cycle is None or self.cycle.response_complete
        self.waited = self.waited + 1 if waits and self.cycle is self.seen else int(waits)
        self.seen = self.cycle
        if self.waited >= LOOKS:
            self.transport.close()
        else:
            self.timer = self.loop.call_later(IDLE_S / LOOKS, self.look)


def install() -> None:
    """Have every server of this process use it; Gradio starts its own and takes no such setting."""
    config.HTTP_PROTOCOLS["auto"] = f"{__name__}:{Patient.__name__}"
