"""Access rules of the server and its page, checked before any route.

Pages of other sites may neither send nor read. Host names that others bind to this machine (DNS
rebinding) are not served. Of Gradio's routes, only those of the page and short events are open:
its event streams would cost a connection each, for as long as a visitor likes. The page itself
loads nothing from other hosts.
"""

import logging
import re
from base64 import b64encode
from collections.abc import AsyncIterator, Iterable, Mapping
from contextlib import asynccontextmanager
from dataclasses import dataclass
from hashlib import sha256
from ipaddress import ip_address
from math import inf
from socket import gethostname
from typing import Any
from urllib.parse import urlsplit

from starlette.datastructures import Headers, MutableHeaders
from starlette.responses import JSONResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from app.shared.limits import SMALL_QUESTION_BYTES

log = logging.getLogger(__name__)

LOOPBACK = frozenset({"localhost", "127.0.0.1", "::1"})
OPEN = ("/omnivat/", "/assets/", "/static/", "/svelte/", "/custom_component/")
PAGE = frozenset(
    ("/", "/config", "/theme.css", "/favicon.ico", "/manifest.json", "/robots.txt")
) | {"/gradio_api/startup-events"}  # Gradio requests the last one itself when it starts
EVENTS = "/gradio_api/run/predict"  # of Gradio's components
POLICY = (
    "default-src 'self'",
    "style-src 'self' 'unsafe-inline'",
    "img-src 'self' data: blob:",
    "media-src 'self' data: blob:",
    "font-src 'self' data:",
    "worker-src 'self' blob:",
    "connect-src 'self' data: blob:",
    "object-src 'none'",
    "base-uri 'self'",
    "form-action 'self'",
)
# headers that would name this server in its page
NAMING = (b"forwarded", b"x-forwarded-host", b"x-gradio-server")
# what a browser never opens as a document that runs scripts
INERT = frozenset(
    ("application/javascript", "text/javascript", "text/css", "image/webp", "application/json")
)
INLINE = re.compile(rb"<script(?![^>]*\ssrc=)[^>]*>(.*?)</script>", re.DOTALL)


@dataclass(frozen=True, slots=True, kw_only=True)
class Rules:
    """Allowed host names, and pages that may frame the server."""

    names: frozenset[str] = LOOPBACK
    addresses: bool = False  # True allows any numeric address
    framed: bool = False


def rules(host: str, names: Iterable[str] = (), *, framed: bool = False) -> Rules:
    """Return the rules of a server on `host` with the additional host names `names`; "*.NAME" is
    every name that ends in ".NAME".

    Beyond loopback, the machine's own name and numeric addresses are allowed: no other site can
    bind them to it.
    """
    local = is_loopback(host)
    own = {name.strip("[]").lower() for name in (host, *names)} | (
        set() if local else {gethostname().lower()}
    )
    return Rules(names=LOOPBACK | own, addresses=not local, framed=framed)


def is_loopback(host: str) -> bool:
    """True if only this machine can reach `host`."""
    try:
        return ip_address(host.strip("[]")).is_loopback
    except ValueError:
        return host.lower() == "localhost"


class Guard:
    """An ASGI application wrapped in the rules.

    links  sent with each page, as the header `Link`
    added  what each page has more than Gradio's, before the first place of each key
    """

    def __init__(
        self, app: ASGIApp, rules: Rules, links: str = "", added: Mapping[bytes, str] | None = None
    ) -> None:
        self._app, self._rules, self._added = app, rules, added or {}
        self._links = {"link": links} if links else {}

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve a request, or refuse it with a sentence; the page has no WebSocket."""
        if scope["type"] == "websocket":
            await send({"type": "websocket.close", "code": 1008})
        elif scope["type"] != "http":
            await self._app(scope, receive, send)
        elif problem := refused(scope, self._rules):
            await JSONResponse({"error": problem}, 403)(scope, receive, send)
        elif (
            path := scope["path"].removeprefix(scope.get("root_path", ""))
        ) == EVENTS and not _size(scope) <= SMALL_QUESTION_BYTES:
            large = {"error": "These settings are too large to be sent; reload the page."}
            await JSONResponse(large, 413)(scope, receive, send)
        elif path == EVENTS or path in PAGE or path.startswith(OPEN):
            sent = [(name, value) for name, value in scope["headers"] if name.lower() not in NAMING]
            app = self._event if path == EVENTS else self._app
            await app({**scope, "headers": sent}, receive, self._guarded(send))
        else:
            missing = {"error": "The page has no such address; open it at '/'."}
            await JSONResponse(missing, 404)(scope, receive, send)

    async def _event(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve an event; one that Gradio cannot read is refused with a sentence."""
        status = 0

        async def checked(message: Message) -> None:
            nonlocal status
            status = message.get("status", status)
            if status < 400:
                await send(message)

        try:
            await self._app(scope, receive, checked)
        except Exception:  # of a text that is no event of the page
            log.exception("an event failed")
            status = status or 400  # nothing is sent after a reply has begun
        if status >= 400:
            unread = {"error": "The server cannot read these settings; reload the page."}
            await JSONResponse(unread, status if status < 500 else 400)(scope, receive, send)

    def _guarded(self, send: Send) -> Send:
        """Return a `send` that adds the headers; a page is buffered until it is complete."""
        held: list[Message] = []

        async def guarded(message: Message) -> None:
            if message["type"] == "http.response.start":
                sent = MutableHeaders(scope=message)
                if (
                    sent.get("content-type", "").startswith("text/html")
                    and "content-encoding" not in sent
                ):
                    held.append(message)
                    return
                found = headers(b"", self._rules)
                if sent.get("content-type", "").split(";")[0] in INERT:
                    del found["content-security-policy"]  # half of a small script's reply
                sent.update(found)
            elif held:
                held.append(message)
                if message.get("more_body"):
                    return
                start, *parts = held
                body = b"".join(part.get("body", b"") for part in parts)
                held.clear()
                for place, more in self._added.items():
                    body = body.replace(place, more.encode() + place, 1)
                sent = MutableHeaders(scope=start)
                sent.update(headers(body, self._rules) | self._links)
                if body:  # the reply to HEAD has none
                    sent["content-length"] = str(len(body))
                await send(start)
                message = {"type": "http.response.body", "body": body}
            await send(message)

        return guarded


def _size(scope: Scope) -> float:
    """Return the length of a request's body, as it is stated; infinite if it is not."""
    stated = Headers(scope=scope).get("content-length", "")
    return int(stated) if stated.isascii() and stated.isdigit() and len(stated) < 12 else inf


def refused(scope: Scope, rules: Rules) -> str:
    """Return the reason for refusing a request, one sentence; "" if it is served."""
    sent = Headers(scope=scope)
    host, origins = sent.get("host", ""), filter(None, sent.getlist("origin"))
    if not _known(host, rules):
        return (
            f"This server is not called '{host:.80}'. Start it with --allow-host NAME to serve that"
            " name, too."
        )
    opened = sent.get("sec-fetch-mode") == "navigate" and scope.get("method") in ("GET", "HEAD")
    foreign = sent.get("sec-fetch-site") in ("cross-site", "same-site") and not opened
    # browsers send it with any method
    if foreign or any(_place(origin) != _place(f"http://{host}") for origin in origins):
        return "A page of another site may not use this server; open the page itself."
    return ""


@asynccontextmanager
async def alone(app: Any) -> AsyncIterator[None]:
    """Serve a Gradio application without its own CORS headers, which allow any origin with
    cookies.
    """
    from gradio.route_utils import CustomCORSMiddleware

    app.user_middleware = [
        middleware
        for middleware in app.user_middleware
        if middleware.cls is not CustomCORSMiddleware
    ]
    app.middleware_stack = app.build_middleware_stack()
    yield


def _known(host: str, rules: Rules) -> bool:
    """True for a name, with or without a port, under which the server may be reached."""
    try:
        name = (urlsplit(f"//{host}").hostname or "").lower().rstrip(".")
        if name in rules.names or any(
            own.startswith("*.") and name.endswith(own[1:]) for own in rules.names
        ):
            return True
        return rules.addresses and bool(ip_address(name))
    except ValueError:
        return False


def _place(origin: str) -> tuple[str, int | None]:
    """Return name and port; default ports are equal, as a proxy may change the scheme."""
    try:
        parts = urlsplit(origin)
        port = parts.port
    except ValueError:
        return "", -1
    return (parts.hostname or origin).lower(), None if port in (80, 443) else port


def headers(page: bytes, rules: Rules) -> dict[str, str]:
    """Return the response headers by name.

    page   the HTML; its inline scripts are the only ones that the browser may run
    rules  `framed` lets other sites show the page in a frame
    """
    hashes = " ".join(
        f"'sha256-{b64encode(sha256(script).digest()).decode()}'" for script in INLINE.findall(page)
    )
    # Gradio compiles component code from text
    script = f"script-src 'self' 'unsafe-eval' {hashes}".strip()
    frames = "frame-ancestors *" if rules.framed else "frame-ancestors 'none'"
    found = {
        "content-security-policy": "; ".join((script, *POLICY, frames)),
        "x-content-type-options": "nosniff",
        "referrer-policy": "same-origin",
        "cross-origin-opener-policy": "same-origin",
        "cross-origin-resource-policy": "cross-origin" if rules.framed else "same-origin",
    }
    return found if rules.framed else {**found, "x-frame-options": "DENY"}


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
