"""A hostile address beside ordinary visitors: `python -m benchmarks.hostile [--minutes 10]`.

Visitors of addresses of their own drag p, read an own picture and load parts of the page, first
alone and then beside one address that holds silent sockets, sends heads by letters, does not read
what it requests, starts trainings under invented names and sends live frames as fast as they are
served. Everything runs on this machine (127.0.0.2 and so on), the hostile client in a process of
its own. A visitor's request fails if it has no reply of status 200 within 30 s.
"""

import argparse
import asyncio
import json
import multiprocessing
import sys
import time
from collections import Counter
from collections.abc import Callable, Coroutine
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from http.client import HTTPConnection, HTTPException
from pathlib import Path
from random import Random
from typing import Any
from urllib.parse import urlsplit

import numpy as np

from app.serving.guard import EVENTS
from benchmarks._browser import resident_mb, started
from benchmarks._machine import machine
from benchmarks.quick import Visitor, picture, small_training, with_files
from omnivat.kit.files import write_json

OUT = Path("docs/benchmarks/hostile.json")
HOSTILE = "127.0.0.2"
LATE_S, PAUSE_S = 30, 1.0  # a visitor's patience; mean seconds between two of its requests
ROLES = {"silent": 200, "slow head": 100, "no reader": 50, "training": 10, "live": 250}
HEAD = "{} /{} HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Length: {}\r\n\r\n"


class Ordinary(Visitor):
    """A visitor who connects from an address of its own."""

    def __init__(self, address: str, number: int) -> None:
        super().__init__(address, number)
        host, port = urlsplit(address).netloc.split(":")
        source = (f"127.0.1.{number + 1}", 0)
        self.connection = HTTPConnection(host, int(port), LATE_S, source_address=source)
        self.headers = {}

    def stay(self, until: float) -> list[tuple[str, float]]:
        """Send requests until a moment; return their kinds, or "failed", and seconds."""
        chance, found = Random(self.number), []
        row = f"row:{self.number}"
        kinds: dict[str, tuple[str, Any]] = {
            "drag": ("omnivat/pair", {"vis": row, "tac": row}),
            "fact": ("omnivat/about", None),
            "upload": self.upload,
        }
        while time.monotonic() < until:
            time.sleep(chance.expovariate(1 / PAUSE_S))
            kind = chance.choices(list(kinds), (8, 2, 2))[0]
            path, body = kinds[kind]
            if kind == "drag":
                body = {**body, "order": chance.random()}
            began = time.monotonic()
            try:
                self.send(path, body)
            except (HTTPException, OSError, ValueError) as error:
                self.connection.close()
                kind = f"failed: {kind}, {error or type(error).__name__}"
            found.append((kind, time.monotonic() - began))
        return found


async def hostile(port: int, until: float, event: dict[str, Any]) -> Counter[str]:
    """Play all roles until a moment; return how often each did its work.

    event  that starts a training
    """
    counts: Counter[str] = Counter()
    frame, names = picture(7), iter(range(10**9))

    async def connected(role: str, play: Callable[[Any, Any], Coroutine[Any, Any, None]]) -> None:
        while time.monotonic() < until:
            with suppress(OSError, TimeoutError, asyncio.IncompleteReadError):
                reader, writer = await asyncio.open_connection(
                    "127.0.0.1", port, limit=1000, local_addr=(HOSTILE, 0)
                )
                try:
                    async with asyncio.timeout(until - time.monotonic()):
                        await play(reader, writer)
                    counts[role] += 1
                finally:
                    writer.close()
            await asyncio.sleep(0.1)

    async def silent(reader: Any, _: Any) -> None:
        await reader.read(1)

    async def slow(_: Any, writer: Any) -> None:
        for letter in HEAD.format("GET", "omnivat/about", 0):
            writer.write(letter.encode())
            await writer.drain()
            await asyncio.sleep(5)

    async def blind(_: Any, writer: Any) -> None:
        many = HEAD.format("GET", "omnivat/frames", 0).encode() * 50  # more than a system keeps
        writer.write(many)
        await writer.wait_closed()

    def sender(path: str, kind: str, body: Callable[[], bytes]) -> Callable[[Any, Any], Any]:
        async def play(reader: Any, writer: Any) -> None:
            content = body()
            head = HEAD.format("POST", path, len(content)).replace("Host", f"{kind}\r\nHost", 1)
            writer.write(head.encode() + content)
            head = await reader.readuntil(b"\r\n\r\n")
            counts[f"{path.partition('?')[0]}: {head[9:12].decode()}"] += 1

        return play

    def training() -> bytes:
        return json.dumps(event | {"session_hash": f"v{next(names)}"}).encode()

    live, body = with_files("omnivat/live", {"modality": "vis"}, frame)
    plays = {
        "silent": silent,
        "slow head": slow,
        "no reader": blind,
        "training": sender(EVENTS[1:], "Content-Type: application/json", training),
        "live": sender(live, "Accept: */*", lambda: body),
    }
    await asyncio.gather(
        *(connected(r, plays[r]) for r, most in ROLES.items() for _ in range(most))
    )
    return counts


def attacked(port: int, until: float, event: dict[str, Any], pipe: Any) -> None:
    """Run the hostile client in this process; send its counts."""
    pipe.send(asyncio.run(hostile(port, until, event)))


def watched(
    address: str, visitors: int, seconds: float, event: dict[str, Any] | None = None
) -> dict[str, Any]:
    """Return the record of ordinary visitors: requests, failures and times.

    event  the request that starts a training; given, a hostile address is active as well
    """
    until = time.monotonic() + seconds
    counts: dict[str, int] = {}
    hear, tell = multiprocessing.Pipe(duplex=False)
    port = urlsplit(address).port
    process = multiprocessing.Process(target=attacked, args=(port, until, event, tell), daemon=True)
    if event:
        process.start()
    with ThreadPoolExecutor(visitors) as crowd:
        everybody = [Ordinary(address, k) for k in range(visitors)]
        every = [
            request for visit in crowd.map(lambda v: v.stay(until), everybody) for request in visit
        ]
    if event:
        counts = dict(sorted(hear.recv().items()))
        process.join()
    seconds_of = {
        kind: [s for name, s in every if name == kind] for kind in ("drag", "fact", "upload")
    }
    why = Counter(name for name, _ in every if name.startswith("failed"))
    failed = why.total()
    return {
        "requests": len(every),
        "failed": failed,
        "why": dict(why),
        "succeeded": round(1 - failed / max(len(every), 1), 5),
        "p95_s": {k: round(float(np.quantile(s or [0], 0.95)), 3) for k, s in seconds_of.items()},
        "slowest_s": round(max(s for _, s in every), 2),
        "hostile": counts,
    }


def main() -> int:
    """Measure both; print and write the record. Fails below 99.9 % of replies."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--minutes", type=float, default=10, help="beside the hostile address")
    parser.add_argument("--quiet", type=float, default=2, help="minutes of visitors alone")
    parser.add_argument("--visitors", type=int, default=20)
    parser.add_argument("--out", type=Path, default=OUT)
    chosen = parser.parse_args()
    with started() as (server, address, _):
        visitor = Visitor(address, 0)
        visitor.send("omnivat/pair", {"vis": "row:0", "tac": "row:0"})
        visitor.own_pair(0)  # head, set and encoder are loaded
        event = small_training(visitor)
        found: dict[str, Any] = {
            name: watched(address, chosen.visitors, 60 * minutes, given)
            for name, minutes, given in (
                ("alone", chosen.quiet, None),
                ("beside", chosen.minutes, event),
            )
        }
        found["server_mb"] = round(resident_mb(server))
    record = {"machine": machine(), "visitors": chosen.visitors, "minutes": chosen.minutes} | found
    write_json(chosen.out, record)
    print(json.dumps(record, indent=1))
    return int(found["beside"]["succeeded"] < 0.999)


if __name__ == "__main__":
    sys.exit(main())
