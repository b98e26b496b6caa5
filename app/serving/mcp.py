"""The API's tools by the Model Context Protocol: JSON-RPC over streamable HTTP, without state or
streams.

Gradio has an MCP server, too. It reaches its tools through Gradio's queue and event streams, which
`app.serving.guard` keeps closed, so it could not have the page's limits.
"""

import json
from typing import Any, TypeGuard

from starlette.requests import Request
from starlette.responses import JSONResponse, Response

from app.serving.api import used
from app.serving.api_schema import TOOLS
from app.shared.messages import UNEXPECTED, log, readable, status_of
from app.shared.requests import question_from
from app.shared.state import Question, Reply
from app.shared.visitor_sets import VisitorSets
from omnivat import __version__
from omnivat.kit.errors import DataError, OmniVatError

VERSION = "2026-07-28"  # without a handshake: each request states its version
SHAKEN = ("2025-11-25", "2025-06-18", "2025-03-26")  # versions that begin with `initialize`
VERSIONS = (VERSION, *SHAKEN)
META = "io.modelcontextprotocol/"  # of the names in a message's `_meta`
SERVER = {"name": "omnivat", "version": __version__}
KEPT = {"ttlMs": 60_000, "cacheScope": "public"}  # how long a client may keep a list
LISTED = ("name", "description", "inputSchema", "outputSchema", "annotations")  # of a tool
PARSE, REQUEST, METHOD, PARAMS, UNSUPPORTED = -32700, -32600, -32601, -32602, -32022
WHOLE = 'A request has "jsonrpc": "2.0", an id and a method.'
USE = "Start with about: it names the classes, domains, examples and sets."


class RpcError(DataError):
    """An error of the protocol, with its code."""

    def __init__(self, sentence: str, code: int) -> None:
        super().__init__(sentence)
        self.code = code


async def mcp(sets: VisitorSets, request: Request) -> Response:
    """Reply to one JSON-RPC message."""
    message: dict[str, Any] = {}

    def read(body: bytes) -> tuple[str, Question] | None:
        try:
            message.update(question_from(body))
        except DataError as error:
            raise RpcError(str(error), PARSE) from error
        if message.get("jsonrpc") != "2.0":
            raise RpcError(WHOLE, REQUEST)
        require_version(message)
        if message.get("method") != "tools/call" or "id" not in message:
            return None
        params = message.get("params")
        name, given = (params.get("name"), params.get("arguments")) if _is(params) else ("", None)
        given = {} if given is None else given
        if not isinstance(name, str) or name not in TOOLS:
            raise RpcError(f"There is no such tool; there are {', '.join(TOOLS)}.", PARAMS)
        if not _is(given):
            raise RpcError("arguments has to be an object.", PARAMS)
        return name, given

    try:
        result = await used(sets, request, read)
        if result is not None:
            found = {"content": _text(json.dumps(result)), "structuredContent": result}
        elif "id" not in message:  # a notification, or a reply to nothing
            return Response(status_code=202)
        else:
            found = replied(message)
    except OmniVatError as error:
        return _failed(message.get("id"), error)
    found = {"resultType": "complete", **found}
    return JSONResponse({"jsonrpc": "2.0", "id": _name(message.get("id")), "result": found})


def require_version(message: Question) -> None:
    """Raise RpcError for a request that states an unknown version of the protocol."""
    params = message.get("params")
    meta = params.get("_meta") if _is(params) else None
    stated = meta.get(f"{META}protocolVersion", VERSION) if _is(meta) else VERSION
    if stated not in VERSIONS:
        known = ", ".join(VERSIONS)
        raise RpcError(f"Version {stated!r:.40} is unknown; there are {known}.", UNSUPPORTED)


def replied(message: Question) -> Reply:
    """Return the result of a request that uses no tool; raises RpcError for an unknown one."""
    method, params = message.get("method"), message.get("params")
    if method == "ping":
        return {}
    if method == "initialize":
        wanted = params.get("protocolVersion") if _is(params) else None
        return {
            "protocolVersion": wanted if wanted in SHAKEN else SHAKEN[0],
            "capabilities": {"tools": {}},
            "serverInfo": SERVER,
            "instructions": USE,
        }
    if method == "server/discover":
        return {
            "supportedVersions": list(VERSIONS),
            "capabilities": {"tools": {}},
            "instructions": USE,
            "_meta": {f"{META}serverInfo": SERVER},
            **KEPT,
        }
    if method == "tools/list":
        rows = ((name, *tool, {"readOnlyHint": True}) for name, tool in TOOLS.items())
        return {"tools": [dict(zip(LISTED, row, strict=True)) for row in rows], **KEPT}
    if not isinstance(method, str):
        raise RpcError(WHOLE, REQUEST)
    raise RpcError(
        f"The method '{method:.40}' is unknown; there are server/discover, tools/list and"
        " tools/call.",
        METHOD,
    )


def _failed(number: Any, error: OmniVatError) -> Response:
    """Return an error: of a tool as a result that a model can read, of the protocol by its code."""
    sentence, code = readable(str(error)), getattr(error, "code", None)
    log.info("mcp refused: %s", error)
    head = {"jsonrpc": "2.0", "id": _name(number)}
    if code is None and number is not None and sentence != UNEXPECTED:
        found = {"resultType": "complete", "content": _text(sentence), "isError": True}
        return JSONResponse({**head, "result": found})
    data = {"data": {"supported": list(VERSIONS)}} if code == UNSUPPORTED else {}
    body = {**head, "error": {"code": code or REQUEST, "message": sentence, **data}}
    known = code in (METHOD, PARAMS)
    return JSONResponse(body, status_code=200 if known else status_of(error))


def _text(text: str) -> list[dict[str, str]]:
    return [{"type": "text", "text": text}]


def _is(value: Any) -> TypeGuard[dict[str, Any]]:
    return isinstance(value, dict)


def _name(number: Any) -> Any:
    """Return a request's id, which is a short text or a number; None for anything else."""
    if isinstance(number, str):
        return readable(number[:200])
    return number if isinstance(number, int | float) and abs(number) < 1e15 else None
