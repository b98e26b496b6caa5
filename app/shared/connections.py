"""Limits for one address: connections, seconds for what it sends and reads, and
requests at a time.

uvicorn limits the connections of all addresses and the seconds between two requests. A request's
head, its body, and a reader that does not read have no limit there.
"""

import asyncio
from collections import Counter, defaultdict
from ipaddress import IPv4Address, ip_address, ip_network
from typing import Any

from starlette.responses import JSONResponse
from starlette.types import ASGIApp, Receive, Scope, Send
from uvicorn.protocols.http import h11_impl

from app.shared.limits import AT_ONCE, BODY_S, CONNECTIONS, IDLE_S, SHARE, SLOWEST

STATES = vars(h11_impl)["h11"]  # the package that uvicorn reads requests with
OPEN: Counter[str] = Counter()  # address -> its connections


def visitor_at(host: str) -> str:
    """Return a visitor's address; of IPv6 the network, as one visitor has 2^64 addresses.

    >>> visitor_at("192.0.2.7"), visitor_at("2001:db8::7"), visitor_at("::ffff:192.0.2.7")
    ('192.0.2.7', '2001:db8::/64', '192.0.2.7')
    """
    try:
        address = ip_address(host.partition("%")[0])
    except ValueError:
        return host
    if isinstance(address, IPv4Address):
        return host
    return str(address.ipv4_mapped or ip_network((address, 64), strict=False))


class Connection(h11_impl.H11Protocol):
    """A connection that ends if its visitor sends or reads too slowly."""

    def __init__(self, config: Any, server_state: Any, app_state: Any, _loop: Any = None) -> None:
        super().__init__(config, server_state, {**app_state, "connection": self}, _loop)
        self.limit_concurrency, self.timeout_keep_alive = CONNECTIONS, IDLE_S
        self._visitor = ""  # address of the visitor who opened this connection
        self._timed: Any = None  # the state of the visitor that has a time limit
        self._limits: dict[str, asyncio.TimerHandle] = {}

    def connection_made(self, transport: Any) -> None:
        """Count the connection, and wait for a request's head."""
        super().connection_made(transport)
        transport.set_write_buffer_limits(high=0)  # so every unread byte is timed
        if self.hold(visitor_at(self.client[0] if self.client else "")):
            self._watch()
        else:
            self.connections.discard(self)  # at once: requests of others count those there are
            transport.abort()

    def hold(self, visitor: str) -> bool:
        """Count the connection as one of `visitor`; False if their share is taken."""
        if visitor != self._visitor:
            if visitor and OPEN[visitor] >= SHARE:
                return False
            for name, more in ((self._visitor, -1), (visitor, 1)):
                OPEN[name] += more
            self._visitor = visitor
            for name in [name for name, count in OPEN.items() if not name or count < 1]:
                del OPEN[name]
        return True

    def connection_lost(self, exc: Exception | None) -> None:
        """Give the place of the connection back."""
        super().connection_lost(exc)
        self.hold("")
        for name in tuple(self._limits):
            self._limit(name, 0)

    def data_received(self, data: bytes) -> None:
        """Take bytes of a request, and limit the time of the rest."""
        super().data_received(data)
        self._watch()

    def on_response_complete(self) -> None:
        """Limit the time of a body that nobody reads."""
        super().on_response_complete()
        if self.conn.their_state is STATES.SEND_BODY:
            self._limit("read", IDLE_S)

    def _watch(self) -> None:
        state = self.conn.their_state
        if state is not self._timed:
            self._timed = state
            self._limit("read", {STATES.IDLE: IDLE_S, STATES.SEND_BODY: BODY_S}.get(state, 0))

    def pause_writing(self) -> None:
        """Limit the time in which the visitor reads what waits."""
        super().pause_writing()
        self._limit("write", IDLE_S + self.transport.get_write_buffer_size() / SLOWEST)

    def resume_writing(self) -> None:
        """Note that everything was read."""
        super().resume_writing()
        self._limit("write", 0)

    def _limit(self, name: str, seconds: float) -> None:
        """End the connection after `seconds`; 0: no limit."""
        if before := self._limits.pop(name, None):
            before.cancel()
        if seconds:
            self._limits[name] = self.loop.call_later(seconds, self.transport.abort)


class Turns:
    """An ASGI application that serves AT_ONCE requests of a visitor at a time; others wait."""

    def __init__(self, app: ASGIApp) -> None:
        self._app = app
        self._turns: dict[str, asyncio.Semaphore] = defaultdict(lambda: asyncio.Semaphore(AT_ONCE))
        self._here: Counter[str] = Counter()  # that run or wait

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve a request when its visitor has a turn; behind a proxy, the one that it reports."""
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        visitor = visitor_at((scope.get("client") or ("",))[0])
        connection = scope.get("state", {}).pop("connection", None)
        if self._here[visitor] >= SHARE or not (connection is None or connection.hold(visitor)):
            busy = {"error": "Too many requests of your address are here; try again in a minute."}
            await JSONResponse(busy, 503)(scope, receive, send)
            return
        self._here[visitor] += 1
        try:
            async with self._turns[visitor]:
                if connection is None or not connection.cycle.disconnected:
                    await self._app(scope, receive, send)
        finally:
            self._here[visitor] -= 1
            if not self._here[visitor]:
                del self._here[visitor], self._turns[visitor]
