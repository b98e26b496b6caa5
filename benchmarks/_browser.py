"""A page that was started, and a real Chromium to open it in: shared by the benchmarks."""

import shutil
import socket
import statistics
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from urllib.parse import parse_qsl, urlsplit
from urllib.request import urlopen

from app.shared.frame_parts import part_of

ROOT = Path(__file__).resolve().parent.parent
NAMES = ("chromium", "chromium-headless-shell", "chromium-browser", "google-chrome")
FLAGS = [
    "--no-sandbox",
    "--disable-gpu",
    "--disable-background-networking",
    "--disable-component-update",
    "--no-first-run",
    "--enable-precise-memory-info",
    "--js-flags=--expose-gc",
    "--use-fake-device-for-media-stream",
    "--use-fake-ui-for-media-stream",
]
MAP = ".explore .map[data-order]"


@contextmanager
def chromium() -> Iterator[Any]:
    """Yield a Chromium."""
    from playwright.sync_api import sync_playwright

    binary = next((path for name in NAMES if (path := shutil.which(name))), None)
    if binary is None:
        raise SystemExit("Chromium is needed; install it with `apt-get install chromium`.")
    with sync_playwright() as player:
        browser = player.chromium.launch(executable_path=binary, args=FLAGS)
        yield browser
        browser.close()


def opened(browser: Any, address: str, query: str = "", frames: Path | None = None) -> Any:
    """Return a page with a new profile, after its map is drawn."""
    page = browser.new_page(viewport={"width": 1440, "height": 900}, permissions=["camera"])
    page.set_default_timeout(120_000)
    if frames:
        page.route("**/omnivat/frames?part=*", lambda route: route.fulfill(**reply(route, frames)))
    page.goto(address + query, wait_until="commit")
    page.wait_for_selector(MAP)
    return page


def reply(route: Any, frames: Path) -> dict[str, Any]:
    """Return the part of a frames file that a request names."""
    query = dict(parse_qsl(urlsplit(route.request.url).query))
    content = part_of(frames, query["part"], int(query.get("from", 0)))
    return {"body": content, "headers": {"X-Frames": "fine"}}


@contextmanager
def started(log: Any = subprocess.DEVNULL) -> Iterator[tuple[int, str, float]]:
    """Start the page; yield its process id, its address, and the seconds until its first reply.

    log  a file for what it writes
    """
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = int(probe.getsockname()[1])
    began = time.perf_counter()
    process = subprocess.Popen(
        [sys.executable, "app.py", "--no-browser", "--port", str(port)],
        cwd=ROOT,
        stdout=log,
        stderr=log,
    )
    address = f"http://127.0.0.1:{port}/"
    try:
        yield process.pid, address, _first_reply(process, address) - began
    finally:
        process.terminate()
        process.wait()


def _first_reply(process: subprocess.Popen[bytes], address: str) -> float:
    while process.poll() is None:
        try:
            with urlopen(address, timeout=60):
                return time.perf_counter()
        except OSError:
            time.sleep(0.02)
    raise SystemExit("The page did not start; run `python app.py` to see why.")


def summed(rounds: Sequence[Mapping[str, float]]) -> dict[str, dict[str, float]]:
    """Return the median, least and most of each figure over rounds."""
    ways: dict[str, Callable[[list[float]], float]] = {
        "median": statistics.median,
        "least": min,
        "most": max,
    }
    return {
        name: {way: round(of([figures[name] for figures in rounds]), 3) for way, of in ways.items()}
        for name in rounds[0]
    }


def resident_mb(pid: int, name: str = "VmRSS") -> float:
    """Return the resident memory of a process, in MB; the most that it had by "VmHWM"."""
    status = Path(f"/proc/{pid}/status").read_text(encoding="ascii")
    line = next(line for line in status.splitlines() if line.startswith(name))
    return int(line.split()[1]) / 1024
