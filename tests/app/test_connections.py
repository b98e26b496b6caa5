"""Connections that send nothing, or too slowly, are closed; slow replies are not."""

import socket
import time
from contextlib import ExitStack, suppress
from functools import partial
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

    async def large(_):
        return PlainTextResponse("x" * 50_000_000)

    async def quick(_):
        return PlainTextResponse("here")

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(connections, "IDLE_S", PATIENCE_S)
        patch.setitem(uvicorn.config.HTTP_PROTOCOLS, "auto", "")
        patch.setitem(uvicorn.config.WS_PROTOCOLS, "auto", "auto")
        patch.setattr(uvicorn.config.Config, "__init__", uvicorn.config.Config.__init__)
        connections.install()
        routes = [Route("/slow", slow), Route("/large", large), Route("/", quick, methods=["GET", "POST"])]
        config = uvicorn.Config(Starlette(routes=routes), port=0, log_level="error")
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


def until(condition):
    """Wait for a condition."""
    for _ in range(2000):
        if condition():
            return
        time.sleep(0.01)
    raise AssertionError("it did not happen")


def test_a_crowd_of_connections_never_keeps_a_new_visitor_out(port, monkeypatch):
    monkeypatch.setattr(connections, "room", 20)
    until(lambda: not connections.CROWD)
    made = []
    monkeypatch.setattr(connections, "make_room", partial(_counted, connections.make_room, made))
    with ExitStack() as stack:
        for _ in range(60):  # each in the middle of a request
            link = socket.create_connection(("127.0.0.1", port), source_address=("127.0.0.2", 0))
            stack.enter_context(link)
            with suppress(OSError):
                link.sendall(b"GET /slow HTTP/1.1\r\nHost: here\r\n\r\n")
        until(lambda: len(made) == 60)
        assert max(made) <= 20
        closed, got = closes_within(port, HEAD + b"Connection: close\r\n\r\n")
        assert closed and got.endswith(b"here")


def _counted(make_room, made):
    make_room()
    made.append(len(connections.CROWD))


def test_of_one_address_the_connection_that_idled_longest_makes_room(port, monkeypatch):
    monkeypatch.setattr(connections, "room", 3)
    until(lambda: not connections.CROWD)
    with ExitStack() as stack:
        first, *_, last = [stack.enter_context(socket.create_connection(("127.0.0.1", port), 10)) for _ in range(4)]
        with suppress(ConnectionResetError):
            assert first.recv(1) == b""
        last.sendall(HEAD + b"Connection: close\r\n\r\n")
        assert last.recv(4096).startswith(b"HTTP/1.1 200")


def test_who_reads_nothing_of_a_response_is_dropped(port):
    with socket.create_connection(("127.0.0.1", port)) as link:
        link.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        link.sendall(b"GET /large HTTP/1.1\r\nHost: here\r\n\r\n")
        until = time.monotonic() + 20 * PATIENCE_S
        time.sleep(PATIENCE_S)
        assert len(connections.CROWD) == 1
        while connections.CROWD and time.monotonic() < until:
            time.sleep(0.05)
        assert not connections.CROWD


def test_the_server_takes_no_websocket_and_enough_descriptors(port):
    assert uvicorn.config.WS_PROTOCOLS["auto"] is None
    assert uvicorn.Config("app").backlog == connections.BACKLOG
    assert connections.descriptors() >= 3 * connections.room
