"""Families of what an earlier attack by other code broke: each yields a case and whether it
held.
"""

import json
import os
import random
import socket
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from tempfile import TemporaryDirectory
from time import monotonic
from typing import Any

import numpy as np

from benchmarks import _attack_names
from benchmarks._browser import started

RECORDINGS, SLOW_S = 200, 5.0
ADDRESS = "127.0.0.1"
ORIGINS = ("http://evil.example", "null", "http://127.0.0.1:9999", "https://demo.example.evil")
NAMING = (
    "X-Forwarded-Host",
    "X-Gradio-Server",
    "X-Forwarded-Proto",
    "Forwarded",
    "X-Original-Host",
)
EVIL = ("javascript:alert(1)", "evil.example", "[evil", "evil b", "\\evil", "x" * 4000)
ODD: tuple[Any, ...] = (
    None,
    [],
    {},
    "",
    -1,
    0,
    1e30,
    float("inf"),
    float("nan"),
    True,
    "\ud800",
    "../..",
    10**30,
    [[]],
    "x" * 5000,
)
TEMPLATES = (
    "{video_key:{episode_index}}",
    "{episode_index:9999d}",
    "{episode_index.__class__}",
    "{",
    "{0}",
    "/etc/{x}",
)
ODD_NUMBERS = (1e30, -1e30, float("nan"), float("inf"), 1e-40)
Case = tuple[str, bool]  # what was tried, and whether it held


def foreign(app: Callable[[], Any]) -> Iterator[Case]:
    """Yield addresses of the page, read from pages of other sites."""
    from starlette.testclient import TestClient

    from app.routes import FACTS

    with TestClient(app(), base_url="http://demo.example") as client:
        for name in (*FACTS, "frames", "web/shared/page.css"):
            for origin in ORIGINS:
                got = client.get(f"/omnivat/{name}", headers={"origin": origin})
                shared = any(header.startswith("access-control-") for header in got.headers)
                yield f"{name} from {origin}", got.status_code == 403 and not shared


def asked(port: int, path: str, *headers: str) -> bytes:
    """Return the reply to a GET; b"" without one."""
    lines = (
        f"GET {path} HTTP/1.1",
        f"Host: {ADDRESS}:{port}",
        "Connection: close",
        *headers,
        "",
        "",
    )
    got = b""
    with suppress(OSError), socket.create_connection((ADDRESS, port), 20) as link:
        link.sendall("\r\n".join(lines).encode())
        while block := link.recv(1 << 16):
            got += block
    return got


def headers(folder: Path) -> Iterator[Case]:
    """Yield names for the server in headers, addresses of Gradio, and the log after them."""
    log = folder / "log"
    with log.open("w") as handle, started(handle) as (_, address, _):
        port = int(address.rstrip("/").rpartition(":")[2])
        for name in NAMING:
            for value in EVIL:
                for path in ("/", "/config"):
                    got = asked(port, path, f"{name}: {value}")
                    held = got[9:10] in (b"2", b"4") and value.encode() not in got
                    yield f"{path} with {name}: {value[:20]}", held
        for path in (
            "pwa_icon/512",
            "monitoring",
            "gradio_api/info",
            "gradio_api/queue/data?session_hash=x",
        ):
            yield path, asked(port, f"/{path}")[9:12] == b"404"
        said = log.read_text(errors="replace")
        yield f"a log of {len(said)} bytes", len(said) < 200_000 and "Traceback" not in said


def recordings(folder: Path, chance: random.Random) -> Iterator[Case]:
    """Yield spoilt descriptions of a data set of recordings, and pipes and tables in place of
    files.
    """
    from omnivat.data.recordings import clips_of, write_pairs
    from omnivat.kit.errors import OmniVatError

    def spoilt(record: dict[str, Any]) -> dict[str, Any]:
        keys = chance.sample(list(record), chance.randrange(1, 3))
        return {**record, **{key: chance.choice((*ODD, *TEMPLATES)) for key in keys}}

    (folder / "meta").mkdir()
    path = "data/{episode_chunk:03d}/episode_{episode_index:06d}.parquet"
    features = {name: {"dtype": "image"} for name in ("photo", "left.tac", "right.tac")}
    whole = {
        "codebase_version": "v2.1",
        "fps": 10,
        "chunks_size": 1000,
        "data_path": path,
        "features": features,
    }
    for number in range(RECORDINGS):
        episodes = [spoilt({"episode_index": k, "length": 20, "tasks": ["wood"]}) for k in range(3)]
        (folder / "meta" / "info.json").write_text(
            json.dumps(spoilt(whole) if number % 2 else whole)
        )
        (folder / "meta" / "episodes.jsonl").write_text("\n".join(map(json.dumps, episodes)))
        began = monotonic()
        yield (
            f"recordings {number}",
            _ends(lambda: write_pairs(clips_of(folder), folder / "out"), OmniVatError, began),
        )
    if hasattr(os, "mkfifo"):
        os.mkfifo(folder / "pipe.mp4")
        (folder / "videos.csv").write_text(
            "vis,tac,material,end\npipe.mp4,pipe.mp4,wood,inf\npipe.mp4,,wood,1\n"
        )
        table = folder / "videos.csv"
        yield (
            "a pipe for a video",
            _ends(lambda: write_pairs(clips_of(table), folder / "out"), OmniVatError, monotonic()),
        )


def _ends(work: Callable[[], Any], refused: type[Exception], began: float) -> bool:
    """True if work returns or is refused in one sentence, in time."""
    try:
        work()
    except refused as error:
        return str(error).endswith(".") and len(str(error)) < 3000 and monotonic() - began < SLOW_S
    except Exception:
        return False
    return monotonic() - began < SLOW_S


def numbers(folder: Path) -> Iterator[Case]:
    """Yield tables with one odd number; what is taken can be read again."""
    from omnivat.data.foreign import import_embeddings
    from omnivat.data.store import load_embeddings, save_embeddings
    from omnivat.kit.errors import DataError

    names: dict[str, Any] = {
        "domain": np.array(["a", "b"] * 6),
        "material": np.array(["x", "y", "z"] * 4),
    }
    for name in ("vis", "tac"):
        for value in (*ODD_NUMBERS, 0.0, 5e8):
            vectors: dict[str, Any] = {
                key: np.random.default_rng(0).normal(size=(12, 8)).astype(np.float32)
                for key in ("vis", "tac")
            }
            if value == 1e-40:
                vectors[name] *= np.float32(1e-40)
            else:
                vectors[name][7, 3] = value
            np.savez(folder / "t.npz", **vectors, **names)
            taken = True
            try:
                save_embeddings(
                    folder / "t.safetensors", import_embeddings(folder / "t.npz", encoder="e")
                )
                load_embeddings(folder / "t.safetensors")
            except DataError:
                taken = False
            yield f"{name} with {value}", taken == (value not in ODD_NUMBERS and value == value)


def teaching(app: Callable[[], Any]) -> Iterator[Case]:
    """Yield lessons that cost most, and odd ones."""
    from starlette.testclient import TestClient

    many: list[dict[str, Any]] = [
        {"vis": f"row:{k}", "tac": f"row:{k}", "label": f"class {k % 30}"} for k in range(60)
    ]
    with TestClient(app(), base_url=f"http://{ADDRESS}") as client:
        client.post("/omnivat/pair", json={"vis": "row:0"})  # the head is loaded
        for lessons in (many, *([{**one, "label": odd} for one in many[:4]] for odd in ODD[:8])):
            began = monotonic()
            text = json.dumps({"lessons": lessons})
            got = client.post("/omnivat/teach", content=text.encode("utf-8", "surrogatepass"))
            yield (
                f"{len(lessons)} lessons, {lessons[0]['label']!r:.20}",
                got.status_code < 500 and (monotonic() - began < SLOW_S),
            )


def environments(folder: Path) -> Iterator[Case]:
    """Yield commands without a home, with a cache that cannot be written, closed outputs, odd
    file names.
    """
    table = folder / "s.csv"
    table.write_text("domain,material,vis_0,vis_1,tac_0,tac_1\na,b,1,2,3,4\n", encoding="utf-8")
    odd = os.fsencode(folder) + b"/\xff.safetensors"
    command = [sys.executable, "-m", "omnivat"]
    bring = [*command, "import", str(table), "--encoder", "mine", "--out"]
    plain = {
        name: value for name, value in os.environ.items() if name not in ("HOME", "XDG_CACHE_HOME")
    }
    cases: tuple[tuple[str, list[Any], dict[str, str]], ...] = (
        ("a name that cannot be encoded", [*bring, odd], {}),
        ("no home", [*bring, str(folder / "a.safetensors")], {}),
        (
            "a cache in a file",
            [*bring, str(folder / "b.safetensors")],
            {"OMNIVAT_CACHE": str(table / "x")},
        ),
    )
    for what, line, more in cases:
        done = subprocess.run(line, env=plain | more, capture_output=True, check=False)
        yield what, done.returncode == 0 and b"Traceback" not in done.stderr
    for way in (">&-", "> /dev/full"):
        line = ["bash", "-c", f'exec "$@" {way}', "-", *command, "gaps", "--stage", "raw"]
        done = subprocess.run(line, capture_output=True, check=False)
        yield f"a result sent to {way}", done.returncode == 1 and done.stderr.count(b"\n") == 1


def families(
    app: Callable[[], Any], resources: Any, seed: int
) -> Iterator[tuple[str, Iterator[Case]]]:
    """Yield each family's name and cases; `app` makes a guarded application that is also called
    demo.example.
    """
    with TemporaryDirectory(prefix="omnivat-attack-") as name:
        folders = {
            kind: Path(name) / kind
            for kind in ("headers", "recordings", "numbers", "environments", "names")
        }
        for folder in folders.values():
            folder.mkdir()
        yield "foreign", foreign(app)
        yield "headers", headers(folders["headers"])
        yield "recordings", recordings(folders["recordings"], random.Random(seed))
        yield "numbers", numbers(folders["numbers"])
        yield "teaching", teaching(app)
        yield "environments", environments(folders["environments"])
        yield "names", _attack_names.outputs(folders["names"])
        yield "visitors", _attack_names.apart(app, resources)
