"""What an earlier attack by other code broke, tried again: nine falls, each with a count."""

import csv
import os
import socket
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from tempfile import TemporaryDirectory
from time import monotonic, sleep
from typing import Any

from benchmarks import _attack_names

STREAMS, SESSIONS, SMALL, HEADS = 1100, 50, 250, 10  # how many of each are sent
LOG_BYTES = 200_000  # that the server may log meanwhile
ADDRESS = "127.0.0.1"
ORIGINS = ("http://evil.example", "null", "http://127.0.0.1:9999", "https://demo.example.evil")
Case = tuple[str, bool]  # what was tried, and whether it held


def foreign(app: Callable[[], Any], resources: Any) -> Iterator[Case]:
    """Yield each address of the page and of Gradio, read from pages of other sites."""
    from starlette.testclient import TestClient

    from app.routes import FACTS

    with TestClient(app(), base_url="http://demo.example") as client:
        for name in (*FACTS, "frames", "thumbnails.json", "web/shared/page.css"):
            for origin in ORIGINS:
                for method in ("GET", "HEAD", "OPTIONS"):
                    headers = {"origin": origin}
                    got = client.request(method, f"/omnivat/{name}", headers=headers)
                    shared = any(header.startswith("access-control-") for header in got.headers)
                    yield f"{method} {name} from {origin}", got.status_code == 403 and not shared
            twice = [("origin", "http://demo.example"), ("origin", "http://evil.example")]
            got = client.get(f"/omnivat/{name}", headers=twice)
            yield f"{name} from two origins", got.status_code == 403


@contextmanager
def served(folder: Path) -> Iterator[tuple[int, Path]]:
    """Yield the port and the log of a server with 1,024 descriptors."""
    with socket.socket() as probe:
        probe.bind((ADDRESS, 0))
        port = probe.getsockname()[1]
    log = folder / "log"
    line = f'ulimit -n 1024; exec "$0" app.py --no-browser --port {port}'
    with log.open("w") as handle:
        process = subprocess.Popen(["bash", "-c", line, sys.executable], stdout=handle, stderr=subprocess.STDOUT)
    try:
        until = monotonic() + 120
        while asked(port, "/theme.css") != 200 and monotonic() < until:
            sleep(0.2)
        yield port, log
    finally:
        process.terminate()
        process.wait()


def asked(port: int, path: str, link: socket.socket | None = None) -> int:
    """Return the status of a GET; 0 without a reply, or with `link` given, which stays open."""
    text = f"GET {path} HTTP/1.1\r\nHost: {ADDRESS}:{port}\r\n\r\n".encode()
    if link is not None:
        link.sendall(text)
        return 0
    with suppress(OSError, ValueError), socket.create_connection((ADDRESS, port), 20) as own:
        own.sendall(text)
        return int((own.recv(64) + b"  0").split()[1])
    return 0


def streams(folder: Path) -> Iterator[Case]:
    """Yield event streams that stay open beyond the descriptors, unknown sessions, and the log."""
    ways = ("heartbeat/x", "dev/reload")
    with served(folder) as (port, log):
        links = []
        for number in range(STREAMS):
            with suppress(OSError):
                link = socket.create_connection((ADDRESS, port), 5)
                links.append(link)
                asked(port, f"/gradio_api/{ways[number % 2]}", link)
        yield (f"the page beside {STREAMS} streams", asked(port, "/omnivat/web/shared/page.css") == 200)
        for link in links:
            link.close()
        for number in range(SESSIONS):
            path = f"/gradio_api/queue/data?session_hash=x{number}"
            yield f"unknown session {number}", asked(port, path) == 404
        said = log.read_text(errors="replace")
        yield f"a log of {len(said)} bytes", len(said) < LOG_BYTES and "Traceback" not in said


def visitors(app: Callable[[], Any], resources: Any) -> Iterator[Case]:
    """Yield loads and trainings of a visitor beside one who takes all that there is."""
    from starlette.testclient import TestClient

    names = ("weights.safetensors", "settings.json", "metrics.json")
    files = {name: (resources.where.head / name).read_bytes() for name in names}
    shared = app()
    hog, other = (TestClient(shared, f"http://{ADDRESS}", client=(f"10.0.0.{k}", 1)) for k in "12")
    for number in range(SMALL):
        hog.post("/omnivat/part?name=settings.json", content=f"{number:025}".encode())
    beside = ""
    for number in range(HEADS):
        changed = files | {"metrics.json": files["metrics.json"] + b" " * number}
        parts = {}
        for name, content in changed.items():
            got = other.post(f"/omnivat/part?name={name}", content=content)
            parts[name] = got.json().get("part", "")
        asked = {"parts": parts, "compare": True}
        got = other.post(f"/omnivat/load?set={beside}", json=asked)
        loaded = got.status_code == 200
        beside = got.json().get("set", beside)
        about = other.get(f"/omnivat/heads?set={beside}")
        held = loaded and about.status_code == 200 and len(about.json()) == number + 2
        yield f"head {number + 1} compared beside {SMALL} small files of another", held
    source = resources.head().source
    runs = []
    for number in range(12):
        asked = {"source": source, "width": 16, "epochs": 100, "visitor": f"name {number}"}
        runs.append(hog.post("/omnivat/train", json=asked).json().get("run"))
    asked["visitor"] = "the thirteenth"
    got = other.post("/omnivat/train", json=asked)
    runs.append(got.json().get("run"))
    yield "the training of a thirteenth visitor", got.status_code == 200
    state = other.post("/omnivat/training", json={"run": runs[-1]}).json()
    yield "its place after that of twelve names of one address", state.get("place", 99) <= 1
    for run in runs:
        hog.post("/omnivat/training/cancel", json={"run": run})


def outputs(folder: Path) -> Iterator[Case]:
    """Yield tables with hostile names, closed outputs, odd file names and exported layers."""
    import torch

    from omnivat.fractional import FractionalTransform
    from omnivat.kit.files import write_csv

    hostile = ["=1+2", "+1+2", "-1+2", "@a", "\tx", "\rx", "-1.5"]
    write_csv(folder / "t.csv", hostile, [hostile])
    with (folder / "t.csv").open(newline="", encoding="utf-8") as handle:
        for row in csv.reader(handle):
            for cell in row:
                yield f"the cell {cell!r}", cell == "-1.5" or cell.startswith("'")
    table = folder / "s.csv"
    table.write_text("domain,material,vis_0,vis_1,tac_0,tac_1\na,b,1,2,3,4\n", encoding="utf-8")
    odd = os.fsencode(folder) + b"/\xff.safetensors"
    command = [sys.executable, "-m", "omnivat"]
    done = subprocess.run(
        [*command, "import", str(table), "--encoder", "mine", "--out", odd], capture_output=True, check=False
    )
    yield "a name that cannot be encoded", done.returncode == 0 and b"Traceback" not in done.stderr
    for way in (">&-", "> /dev/full"):
        line = ["bash", "-c", f'exec "$@" {way}', "-", *command, "gaps", "--stage", "raw"]
        done = subprocess.run(line, capture_output=True, check=False)
        held = done.returncode == 1 and done.stderr.count(b"\n") == 1
        yield f"a result sent to {way}", held
    x, layer = torch.randn(5, 64), FractionalTransform(0.3, planar=True)
    with suppress(Exception):
        program = torch.export.export(layer, (x,), strict=False).module()
        yield "an exported layer", bool(torch.allclose(program(2 * x), layer(2 * x), atol=1e-5))
        return
    yield "an exported layer", False


def falls(app: Callable[[], Any], resources: Any) -> Iterator[Case]:
    """Yield every case; `app` makes a guarded application that is also called demo.example."""
    with TemporaryDirectory(prefix="omnivat-attack-") as name:
        yield from foreign(app, resources)
        yield from visitors(app, resources)
        yield from streams(Path(name))
        yield from outputs(Path(name))
        (inner := Path(name) / "names").mkdir()
        yield from _attack_names.outputs(inner)
        yield from _attack_names.apart(app, resources)
