"""No address takes the server from another: silent and slow visitors end, shares are counted."""

import asyncio
import socket
from contextlib import closing, suppress
from threading import Event, Thread
from time import sleep

import httpx
import pytest
import uvicorn
from starlette.applications import Starlette
from starlette.responses import PlainTextResponse, Response
from starlette.routing import Route

from app.shared import connections
from app.shared.connections import OPEN, Connection, Turns

FREE = Event()
HEAD = b"GET /short HTTP/1.1\r\nHost: x\r\n"


async def short(request):
    return PlainTextResponse("short")


async def long(request):
    return Response(bytes(30_000_000))  # more than a system holds for a reader


async def held(request):
    while not FREE.is_set():
        await asyncio.sleep(0.01)
    return PlainTextResponse("held")


@pytest.fixture
def port(monkeypatch):
    """Serve three pages with short limits; return the port."""
    for name, value in {"IDLE_S": 0.4, "BODY_S": 0.8, "SLOWEST": 10**9}.items():
        monkeypatch.setattr(connections, name, value)
    FREE.clear()
    pages = [Route(f"/{one.__name__}", one, methods=["GET", "POST"]) for one in (short, long, held)]
    config = uvicorn.Config(Turns(Starlette(routes=pages)), http=Connection, log_level="critical")
    server = uvicorn.Server(config)
    with closing(socket.create_server(("127.0.0.1", 0))) as listening:
        thread = Thread(target=server.run, kwargs={"sockets": [listening]})
        thread.start()
        yield listening.getsockname()[1]
        FREE.set()
        server.should_exit = True
        thread.join()
    assert not OPEN, "every connection gave its place back"


def opened(port, source="127.0.0.1"):
    return socket.create_connection(("127.0.0.1", port), 30, source_address=(source, 0))


def until(state):
    while not state():
        sleep(0.01)


def ended(one):
    """Return what arrives until the server ends a connection."""
    found = b""
    with suppress(ConnectionError):
        while part := one.recv(65536):
            found += part
    return found


@pytest.mark.parametrize(
    "sent",
    [b"", b"POST /short HTTP/1.1\r\nHost: x\r\nContent-Length: 9\r\n\r\nabc"],
    ids=["nothing", "half a body that nobody reads"],
)
def test_a_visitor_who_stops_sending_loses_the_connection(port, sent):
    with opened(port) as one:
        one.sendall(sent)
        assert (b"short" in ended(one)) == (b"POST" in sent)


def test_a_letter_now_and_then_does_not_keep_a_connection(port):
    with opened(port) as one, suppress(ConnectionError):
        one.settimeout(0.1)
        for letter in HEAD * 100:
            one.send(bytes([letter]))
            with suppress(TimeoutError):
                assert not one.recv(1)
                break
        else:
            pytest.fail("4,000 letters were taken")


def test_a_second_request_on_a_connection_has_the_same_limit(port):
    with opened(port) as one:
        one.sendall(HEAD + b"\r\n")
        while b"short" not in one.recv(65536):
            pass
        one.sendall(HEAD)
        assert not ended(one)


def test_a_visitor_who_does_not_read_loses_the_connection_and_one_who_reads_gets_everything(
    port, monkeypatch
):
    with opened(port) as one:
        one.sendall(HEAD.replace(b"short", b"long") + b"\r\n")
        until(lambda: not OPEN)
    monkeypatch.setattr(connections, "SLOWEST", 10_000)
    assert len(httpx.get(f"http://127.0.0.1:{port}/long").content) == 30_000_000


def test_one_address_has_its_share_of_connections_and_another_is_served(port, monkeypatch):
    monkeypatch.setattr(connections, "SHARE", 3)
    monkeypatch.setattr(connections, "IDLE_S", 30)
    mine = [opened(port, "127.0.0.2") for _ in range(3)]
    until(lambda: OPEN["127.0.0.2"] == 3)
    with opened(port, "127.0.0.2") as fourth:
        assert not ended(fourth)
    assert httpx.get(f"http://127.0.0.1:{port}/short").text == "short"
    for one in mine:
        one.close()
    until(lambda: not OPEN["127.0.0.2"])


def test_requests_beyond_a_visitors_turns_wait_and_beyond_the_share_get_a_sentence(
    port, monkeypatch
):
    monkeypatch.setattr(connections, "AT_ONCE", 1)
    monkeypatch.setattr(connections, "SHARE", 2)

    def request(name, visitor):
        one = opened(port)
        head = HEAD.replace(b"short", name) + f"X-Forwarded-For: {visitor}\r\n\r\n".encode()
        one.sendall(head)
        return one

    with request(b"held", "192.0.2.1"), request(b"short", "192.0.2.1") as second:
        until(lambda: OPEN["192.0.2.1"] == 2)
        with request(b"short", "192.0.2.1") as third:
            reply = ended(third)
            assert b" 503 " in reply and b"Too many requests of your address" in reply
        with request(b"short", "192.0.2.2") as other:
            while b"short" not in other.recv(65536):
                pass
        second.settimeout(0.2)
        with pytest.raises(TimeoutError):
            second.recv(1)
