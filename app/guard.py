"""Access rules of the server and its page, checked before any route.

Pages of other sites may neither send nor read. Host names that others bind to this machine (DNS
rebinding) are not served. Of Gradio's routes, only those of the page are open: its event streams and
its API would cost a connection each, for as long as a visitor likes. The page itself loads nothing
from other hosts.
"""

import json
import re
from base64 import b64encode
from collections.abc import AsyncIterator, Awaitable, Callable, Iterable, MutableMapping
from contextlib import asynccontextmanager
from dataclasses import dataclass
from hashlib import sha256
from ipaddress import ip_address
from socket import gethostname
from typing import Any
from urllib.parse import urlsplit

Scope = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[MutableMapping[str, Any]]]
Send = Callable[[MutableMapping[str, Any]], Awaitable[None]]
App = Callable[[Scope, Receive, Send], Awaitable[None]]

LOOPBACK = frozenset({"localhost", "127.0.0.1", "::1"})
SAFE = ("GET", "HEAD")
OPEN = ("/omnivat/", "/assets/", "/static/", "/svelte/", "/custom_component/", "/pwa_icon")
PAGE = frozenset(("/", "/config", "/theme.css", "/favicon.ico", "/manifest.json", "/robots.txt")) | {
    "/gradio_api/startup-events"
}  # Gradio requests the last one itself when it starts
INLINE = re.compile(rb"<script(?![^>]*\ssrc=)[^>]*>(.*?)</script>", re.DOTALL)


@dataclass(frozen=True, slots=True, kw_only=True)
class Rules:
    """Allowed host names, and pages that may frame the server."""

    names: frozenset[str] = LOOPBACK
    addresses: bool = False  # True allows any numeric address
    framed: bool = False


def rules(host: str, names: Iterable[str] = (), *, framed: bool = False) -> Rules:
    """Return the rules of a server on `host` with the additional host names `names`.

    Beyond loopback, the machine's own name and numeric addresses are allowed, because no other site
    can bind them to this machine.
    """
    own = {host.strip("[]").lower(), *(name.strip("[]").lower() for name in names)}
    if is_loopback(host):
        return Rules(names=LOOPBACK | own, framed=framed)
    return Rules(names=LOOPBACK | own | {gethostname().lower()}, addresses=True, framed=framed)


def is_loopback(host: str) -> bool:
    """True if only this machine can reach `host`."""
    try:
        return ip_address(host.strip("[]")).is_loopback
    except ValueError:
        return host.lower() == "localhost"


class Guard:
    """An ASGI application wrapped in the rules."""

    def __init__(self, app: App, rules: Rules) -> None:
        self._app, self._rules = app, rules

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve a request, or refuse it with a sentence."""
        if scope["type"] not in ("http", "websocket"):
            await self._app(scope, receive, send)
            return
        if problem := refused(scope, self._rules):
            await _refuse(scope, send, problem, 403)
            return
        if not is_open(scope):
            await _refuse(scope, send, "The page has no such address; open it at '/'.", 404)
            return
        await self._app(scope, receive, self._guarded(send))

    def _guarded(self, send: Send) -> Send:
        """Return a `send` that adds the headers; a page is buffered until it is complete."""
        held: list[MutableMapping[str, Any]] = []

        async def guarded(message: MutableMapping[str, Any]) -> None:
            if message["type"] == "http.response.start":
                page = _header(message["headers"], b"content-type").startswith(b"text/html")
                packed = _header(message["headers"], b"content-encoding")
                if page and not packed:
                    held.append(message)
                    return
                message["headers"] = [*message["headers"], *headers(b"", self._rules)]
            elif held:
                held.append(message)
                if message.get("more_body"):
                    return
                start, *parts = held
                body = b"".join(part.get("body", b"") for part in parts)
                held.clear()
                start["headers"] = [*start["headers"], *headers(body, self._rules)]
                await send(start)
                message = {"type": "http.response.body", "body": body}
            await send(message)

        return guarded


def refused(scope: Scope, rules: Rules) -> str:
    """Return the reason for refusing a request, one sentence; "" if it is served."""
    host = _header(scope["headers"], b"host").decode("latin-1")
    if not _known(_name(host), rules):
        return f"This server is not called '{host:.80}'. Start it with --allow-host NAME to serve that name, too."
    site = _header(scope["headers"], b"sec-fetch-site")
    mode = _header(scope["headers"], b"sec-fetch-mode")
    origin = _header(scope["headers"], b"origin").decode("latin-1")
    foreign = "A page of another site may not use this server; open the page itself."
    if origin and _place(origin) != _place(f"http://{host}"):  # browsers send it with any method
        return foreign
    if site in (b"cross-site", b"same-site"):
        opened = mode == b"navigate" and scope.get("method") in SAFE
        if not opened:
            return foreign
    return ""


def is_open(scope: Scope) -> bool:
    """True for the addresses of the page; it has no WebSocket."""
    path = scope["path"].removeprefix(scope.get("root_path", ""))
    return scope["type"] == "http" and (path in PAGE or path.startswith(OPEN))


@asynccontextmanager
async def alone(app: Any) -> AsyncIterator[None]:
    """Serve a Gradio application without its own CORS headers, which allow any origin with cookies."""
    from gradio.route_utils import CustomCORSMiddleware

    app.user_middleware = [one for one in app.user_middleware if one.cls is not CustomCORSMiddleware]
    app.middleware_stack = app.build_middleware_stack()
    yield


def _known(name: str, rules: Rules) -> bool:
    if name in rules.names:
        return True
    try:
        ip_address(name)
    except ValueError:
        return False
    return rules.addresses


def _name(host: str) -> str:
    """Return a host without its port."""
    try:
        return (urlsplit(f"//{host}").hostname or "").lower().rstrip(".")
    except ValueError:
        return ""


def _place(origin: str) -> tuple[str, int | None]:
    """Return name and port; default ports are equal, as a proxy may change the scheme."""
    try:
        parts = urlsplit(origin)
        port = parts.port
    except ValueError:
        return "", -1
    return (parts.hostname or origin).lower(), None if port in (80, 443) else port


def headers(page: bytes, rules: Rules) -> list[tuple[bytes, bytes]]:
    """Return the response headers; they allow only the inline scripts of `page`."""
    hashes = " ".join(f"'sha256-{b64encode(sha256(script).digest()).decode()}'" for script in INLINE.findall(page))
    policy = "; ".join(
        [
            "default-src 'self'",
            # Gradio compiles component code from text
            f"script-src 'self' 'unsafe-eval' {hashes}".strip(),
            "style-src 'self' 'unsafe-inline'",
            "img-src 'self' data: blob:",
            "media-src 'self' data: blob:",
            "font-src 'self' data:",
            "worker-src 'self' blob:",
            "connect-src 'self' data: blob:",
            "object-src 'none'",
            "base-uri 'self'",
            "form-action 'self'",
            f"frame-ancestors {'*' if rules.framed else chr(39) + 'none' + chr(39)}",
        ]
    )
    headers = {
        "content-security-policy": policy,
        "x-content-type-options": "nosniff",
        "referrer-policy": "same-origin",
        "cross-origin-opener-policy": "same-origin",
        "cross-origin-resource-policy": "cross-origin" if rules.framed else "same-origin",
    }
    if not rules.framed:
        headers["x-frame-options"] = "DENY"
    return [(name.encode(), value.encode()) for name, value in headers.items()]


def _header(headers: Iterable[tuple[bytes, bytes]], name: bytes) -> bytes:
    return next((value for key, value in headers if key.lower() == name), b"")


async def _refuse(scope: Scope, send: Send, problem: str, status: int) -> None:
    if scope["type"] == "websocket":
        await send({"type": "websocket.close", "code": 1008})
        return
    body = json.dumps({"error": problem}).encode()
    headers = [(b"content-type", b"application/json"), (b"content-length", str(len(body)).encode())]
    await send({"type": "http.response.start", "status": status, "headers": headers})
    await send({"type": "http.response.body", "body": body})


def warning(host: str, port: int) -> str:
    """Return the warning for the owner of a server that others can reach; else ""."""
    if is_loopback(host):
        return ""
    return (
        f"WARNING: the page listens on {host}, port {port}. Whoever reaches this machine can use "
        "it without a password: see the set, its thumbnails and names and the trained head, send "
        "images and heads, and use its processor and up to 2 GB of its disk. Stop it here with "
        "Ctrl+C, or start it without --host for yourself alone."
    )
