"""Connections that send nothing, or too slowly, are closed; slow replies are not."""

import socket
import time
from threading import Thread

import pytest
import uvicorn
from starlette.applications import Starlette
from starlette.responses import PlainTextResponse
from starlette.routing import Route

from app import connections

PATIENCE_S = 0.6


@pytest.fixture(scope="module")
def port():
    async def slow(_):
        import asyncio

        await asyncio.sleep(4 * PATIENCE_S)
        return PlainTextResponse("late")

    async def quick(_):
        return PlainTextResponse("here")

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(connections, "IDLE_S", PATIENCE_S)
        patch.setitem(uvicorn.config.HTTP_PROTOCOLS, "auto", "")
        connections.install()
        routes = [Route("/slow", slow), Route("/", quick, methods=["GET", "POST"])]
        config = uvicorn.Config(Starlette(routes=routes), port=0, log_level="error", ws="none")
        server = uvicorn.Server(config)
        thread = Thread(target=server.run, daemon=True)
        thread.start()
        while not server.started:
            time.sleep(0.01)
        yield server.servers[0].sockets[0].getsockname()[1]
        server.should_exit = True
        thread.join(10)


def closes_within(port, *parts, pause=0.0, limit=10 * PATIENCE_S):
    """Send parts; return whether the server then closed the connection, and what it had sent."""
    began, got = time.monotonic(), b""
    with socket.create_connection(("127.0.0.1", port), timeout=limit) as link:
        try:
            for part in parts:
                link.sendall(part)
                time.sleep(pause)
            while block := link.recv(4096):
                got += block
        except TimeoutError:
            return False, got
        except OSError:  # closed while parts were being sent
            pass
    return time.monotonic() - began < limit, got


HEAD = b"GET / HTTP/1.1\r\nHost: here\r\n"


@pytest.mark.parametrize(
    ("parts", "pause"),
    [
        ([], 0),
        ([HEAD], 0),
        ([b"X: y\r\n" if k else HEAD for k in range(40)], 0.1),
        ([HEAD + b"\r\n", b"GE"], 0.1),
        ([b"POST / HTTP/1.1\r\nHost: here\r\nContent-Length: 99\r\n\r\nabc"], 0),
    ],
    ids=["silent", "half a head", "a head in drips", "half a second head", "a stalled body"],
)
def test_a_connection_that_keeps_the_server_waiting_is_closed(port, parts, pause):
    closed, _ = closes_within(port, *parts, pause=pause)
    assert closed


def test_a_slow_answer_is_waited_for(port):
    closed, got = closes_within(port, b"GET /slow HTTP/1.1\r\nHost: here\r\n\r\n")
    assert closed and got.endswith(b"late")
