"""How quick the page is, without a browser: `python -m benchmarks.quick [--repeat 5] [--visitors
50]`.

Each round starts a server. Figures are medians over rounds (and over requests): the first page and
its memory, an own pair from the drop to three readings, the profile of a sensor from 20 pictures,
and visitors at once, who drag p and upload while every fifth trains. `--mixed` has the others
make a profile, teach a head, or place a picture on the map. Seconds are wall time, so they hold on
a quiet machine alone; the load is in the record.
"""

import argparse
import json
import statistics
import sys
import time
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from http.client import HTTPConnection, HTTPException
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit
from urllib.request import urlopen

import numpy as np
from PIL import Image

from app.serving.guard import EVENTS
from app.train.plan import NUMBERS
from benchmarks._attack_costly import encoded
from benchmarks._browser import resident_mb, started, summed
from benchmarks._machine import machine
from omnivat.kit.files import write_json

OUT = Path("docs/benchmarks/quick.json")
PROFILE, PAIRS, DRAGS, EVERY = 20, 10, 20, 5  # pictures, own pairs; drags; each 5th visitor trains
AT_ONCE = 10  # pictures of one request
OWN_PAIR = {"vis": "file:0", "tac": "file:1", "with": ["familiar", "journey", "moving"]}
# figure -> what it is, and its target on a quiet machine
FIGURES = {
    "first_page_s": ("process start to first page, s", 2.0),
    "first_page_mb": ("server after the first page, its map, head and set, MB", 350),
    "own_pair_s": ("own pair, from the drop to readings, neighbours, map and nodes, s", 0.5),
    "profile_s": ("profile from 20 pictures, s", 1.0),
    "drag_p95_s": ("visitors at once: a drag, 95th percentile, s", 0.3),
    "upload_p95_s": ("visitors at once: an upload, to its prediction, 95th percentile, s", 2.0),
    "whole_p95_s": ("visitors at once: an upload, to all of its reply, 95th percentile, s", 10.0),
    "slowest_s": ("visitors at once: the longest wait of anyone, s", 10.0),
    "failed": ("visitors at once: requests that failed", 0),
}


def picture(number: int) -> bytes:
    """Return a JPEG of 640 x 480 that no other number has."""
    random = np.random.default_rng(number)
    small = Image.fromarray(random.integers(0, 256, (12, 16, 3), dtype=np.uint8))
    return encoded(small.resize((640, 480)), "JPEG", quality=90)


def with_files(path: str, question: dict[str, Any], *files: bytes) -> tuple[str, bytes]:
    """Return the path and the body of a question with pictures after it."""
    parts = [json.dumps(question).encode(), *files]
    return f"{path}?sizes={','.join(str(len(part)) for part in parts)}", b"".join(parts)


class Visitor:
    """One visitor: an address of its own, as a proxy would report it, and one open connection,
    as in a browser.
    """

    def __init__(self, address: str, number: int) -> None:
        self.connection, self.number = HTTPConnection(urlsplit(address).netloc), number
        self.first = 0.0  # when the last reply began
        self.headers = {"X-Forwarded-For": f"10.1.{number // 250}.{number % 250 + 1}"}
        question = {**OWN_PAIR, "tac": None}
        self.upload = with_files("omnivat/pair", question, picture(1000 * number + 999))

    def send(self, path: str, body: bytes | dict[str, Any] | None = None) -> Any:
        """Return the JSON reply of a POST, or of a GET without a body."""
        method = "GET" if body is None else "POST"
        content = json.dumps(body).encode() if isinstance(body, dict) else body
        kind = {"Content-Type": "application/json"} if isinstance(body, dict) else {}
        self.connection.request(method, f"/{path}", content, self.headers | kind)
        with self.connection.getresponse() as reply:
            lines = [reply.readline()]  # what is there first
            self.first = time.perf_counter()
            lines += reply.read().splitlines()
        if reply.status != 200:
            raise HTTPException(f"{path}: {reply.status}")
        found, *rest = (json.loads(line) for line in lines if line)
        for more in rest:
            if "problem" in more:
                raise HTTPException(f"{path}: {more['problem']}")
            found |= more
        return found

    def pictured(self, path: str, question: dict[str, Any], *files: bytes) -> Any:
        """Return the reply to a question with pictures, "file:0" and so on."""
        return self.send(*with_files(path, question, *files))

    def own_pair(self, number: int) -> float:
        """Return the seconds from two new pictures to all that the page shows of them."""
        began = time.perf_counter()
        first = 1000 * self.number + 2 * number
        found = self.pictured("omnivat/pair", OWN_PAIR, picture(first), picture(first + 1))
        assert len(found["exact"]["readings"]) >= 3
        return time.perf_counter() - began

    def profile(self, first: int) -> float:
        """Return the seconds from PROFILE new pictures to their profile."""
        began, made = time.perf_counter(), {"profile": ""}
        for start in range(first, first + PROFILE, AT_ONCE):
            names = [f"file:{k}" for k in range(AT_ONCE)]
            question = {"touches": names, "profile": made["profile"]}
            files = (picture(1000 * self.number + start + k) for k in range(AT_ONCE))
            made = self.pictured("omnivat/profile", question, *files)
        return time.perf_counter() - began

    def more(self, training: dict[str, Any]) -> tuple[str, dict[str, Any]]:
        """Return path and body of the further request of this visitor, by its number."""
        if self.number % EVERY == 0:
            return EVENTS.removeprefix("/"), training
        rows = [f"row:{row}" for row in range(self.number, 600, 60)]
        if self.number % EVERY == 1:
            return "omnivat/profile", {"touches": rows}
        if self.number % EVERY == 2:
            lessons = [{"vis": row, "tac": row, "label": str(k % 2)} for k, row in enumerate(rows)]
            return "omnivat/teach", {"lessons": lessons}
        return "omnivat/journey", {"vis": rows[0], "tac": rows[1]}

    def visit(self, training: dict[str, Any], *, mixed: bool) -> Iterator[tuple[str, float]]:
        """Drag p, upload a picture, drag again; some train, or do another thing meanwhile.

        Yield names and seconds.
        """

        def timed(what: str, path: str, body: bytes | dict[str, Any]) -> tuple[str, float]:
            began = time.perf_counter()
            try:
                self.send(path, body)
            except (HTTPException, OSError, ValueError):
                self.connection.close()
                return "failed", 0.0
            return what, time.perf_counter() - began

        if mixed or self.number % EVERY == 0:
            path, body = self.more(training)
            yield timed(path, path, body)
        for k in range(DRAGS):
            row = f"row:{self.number * DRAGS + k}"
            yield timed("drag", "omnivat/pair", {"vis": row, "tac": row, "order": k / DRAGS})
            if k == DRAGS // 2:
                began = time.perf_counter()
                whole = timed("whole", *self.upload)
                yield ("upload", self.first - began) if whole[0] == "whole" else whole
                yield whole


def small_training(visitor: Visitor) -> dict[str, Any]:
    """Return the event of Gradio's components that starts a short training."""
    _, begin, *_ = visitor.send("config")["dependencies"]
    source = visitor.send("omnivat/about")["head"]["source"]
    numbers = {name: row[-1] for name, row in NUMBERS.items()} | {"epochs": 5}
    settings = (source, "gradient", 16, *numbers.values(), False)
    data = [None, 1280, "domain", *settings]  # no run before, the page's width, the map's colours
    return {"data": data, "fn_index": begin["id"], "session_hash": "a"}


def measured(visitors: int, *, mixed: bool) -> dict[str, float]:
    """Start a server and measure one round."""
    with started() as (process, address, first):
        for path in ("omnivat/frames", "omnivat/about", "omnivat/pairs"):
            with urlopen(address + path) as reply:
                reply.read()
        client = Visitor(address, 0)
        found = {"first_page_s": first, "first_page_mb": resident_mb(process)}
        client.send("omnivat/pair", {"vis": "row:0", "tac": "row:0"})
        client.own_pair(0)  # loads the encoder
        found["own_pair_s"] = statistics.median(client.own_pair(k) for k in range(1, PAIRS + 1))
        found["profile_s"] = statistics.median(client.profile(100 * k) for k in (1, 2, 3))
        training = small_training(client)
        everybody = [Visitor(address, k) for k in range(visitors)]
        with ThreadPoolExecutor(visitors) as crowd:
            visits = crowd.map(
                lambda visitor: list(visitor.visit(training, mixed=mixed)), everybody
            )
            every = [request for visit in visits for request in visit]
        kinds = Counter(what for what, _ in every)
        for what in ("drag", "upload", "whole"):
            seconds = [s for kind, s in every if kind == what] or [float("inf")]
            found[f"{what}_p95_s"] = float(np.quantile(seconds, 0.95))
        slowest = max(seconds for _, seconds in every)
        return found | {"slowest_s": slowest, "failed": kinds["failed"]}


def main() -> int:
    """Measure some rounds, print a table, write the record."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeat", type=int, default=5, help="rounds")
    parser.add_argument("--visitors", type=int, default=50)
    parser.add_argument("--mixed", action="store_true", help="visitors do other things, too")
    parser.add_argument("--out", type=Path, default=OUT)
    chosen = parser.parse_args()
    rounds = [measured(chosen.visitors, mixed=chosen.mixed) for _ in range(chosen.repeat)]
    figures = {
        name: {**summed(rounds)[name], "target": target} for name, (_, target) in FIGURES.items()
    }
    write_json(chosen.out, {"machine": machine(), "rounds": len(rounds), "figures": figures})
    for name, figure in figures.items():
        met = "met" if figure["median"] <= figure["target"] else "NOT met"
        print(f"{FIGURES[name][0]:60} {figure['median']:8.3g}  target {figure['target']:g}  {met}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
