"""Close idle connections, and connections that send a request's header too slowly.

Request bodies have a separate time limit (app/requests.py).
"""

from asyncio import TimerHandle
from typing import Any

from uvicorn import config
from uvicorn.protocols.http.auto import AutoHTTPProtocol

from app.limits import IDLE_S

LOOKS = 2  # consecutive checks without a request in progress


class Patient(AutoHTTPProtocol):  # type: ignore[misc, valid-type]
    """uvicorn's HTTP protocol; it closes after IDLE_S without a complete request."""

    waited = 0
    seen: Any = None
    timer: TimerHandle | None = None

    def connection_made(self, transport: Any) -> None:
        """Start checking the connection."""
        super().connection_made(transport)
        self.timer = self.loop.call_later(IDLE_S / LOOKS, self.look)

    def connection_lost(self, exc: Exception | None) -> None:
        """Stop checking."""
        if self.timer is not None:
            self.timer.cancel()
        super().connection_lost(exc)

    def look(self) -> None:
        """Close the connection if it still waits for a request."""
        if self.transport.is_closing() or self.transport.get_protocol() is not self:
            return  # closed, or now a websocket
        waits = self.cycle is None or self.cycle.response_complete
        self.waited = self.waited + 1 if waits and self.cycle is self.seen else int(waits)
        self.seen = self.cycle
        if self.waited >= LOOKS:
            self.transport.close()
        else:
            self.timer = self.loop.call_later(IDLE_S / LOOKS, self.look)


def install() -> None:
    """Use it in every server of this process; Gradio's server has no such setting."""
    config.HTTP_PROTOCOLS["auto"] = f"{__name__}:{Patient.__name__}"
