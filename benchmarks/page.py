"""Measure the page in a real Chromium: the drag, cold start, memory. `python benchmarks/page.py`

The drag moves a real mouse along the slider, one move every display frame. From each `input` event
to the second animation frame after it is the input-to-pixels time; frames are counted where the map
shows another stop than before. Prints JSON with the machine; give --repeat for the spread.
"""

import argparse
import json
import os
import platform
import shutil
import socket
import statistics
import subprocess
import sys
import time
from pathlib import Path
from typing import Any
from urllib.request import urlopen

ROOT = Path(__file__).resolve().parent.parent
CHROMIUM = ("chromium", "chromium-browser", "google-chrome")
FLAGS = ["--no-sandbox", "--disable-gpu", "--disable-background-networking", "--no-first-run"]
WATCH = """() => {
  const map = document.querySelector('.explore .map');
  window.measured = { waits: [], shown: new Set(), frames: 0, last: null };
  document.querySelector('.explore .order').addEventListener('input', () => {
    const from = performance.now();
    requestAnimationFrame(() => requestAnimationFrame(() => {
      window.measured.waits.push(performance.now() - from);
    }));
  });
  const look = () => {
    if (map.dataset.order !== window.measured.last) {
      window.measured.last = map.dataset.order;
      window.measured.frames += 1;
    }
    requestAnimationFrame(look);
  };
  look();
}"""


def free_port() -> int:
    """Return a port that nothing listens on."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def started(arguments: list[str]) -> tuple[subprocess.Popen[bytes], str, float]:
    """Start the page; return the process, its address, and seconds until it answered."""
    port = free_port()
    began = time.perf_counter()
    process = subprocess.Popen(
        [sys.executable, "app.py", "--no-browser", "--port", str(port), *arguments],
        cwd=ROOT,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    address = f"http://127.0.0.1:{port}/"
    while True:
        if process.poll() is not None:
            raise SystemExit("The page did not start; run `python app.py` to see why.")
        try:
            with urlopen(address, timeout=60):
                return process, address, time.perf_counter() - began
        except OSError:
            time.sleep(0.02)


def resident_mb(process: subprocess.Popen[bytes]) -> float:
    """Return the resident memory of the server, in MB."""
    status = Path(f"/proc/{process.pid}/status").read_text(encoding="ascii")
    line = next(line for line in status.splitlines() if line.startswith("VmRSS"))
    return int(line.split()[1]) / 1024


def drag(page: Any, moves: int) -> dict[str, float]:
    """Drag the slider there and back; return frames a second and milliseconds to pixels."""
    page.evaluate(WATCH)
    box = page.locator(".explore .order").bounding_box()
    middle = box["y"] + box["height"] / 2
    page.mouse.move(box["x"] + 10, middle)
    page.mouse.down()
    began = time.perf_counter()
    for step in range(moves):
        share = abs((step / moves * 4) % 2 - 1)
        page.mouse.move(box["x"] + 10 + (1 - share) * (box["width"] - 20), middle)
    seconds = time.perf_counter() - began
    page.mouse.up()
    measured = page.evaluate("() => ({ waits: measured.waits, frames: measured.frames })")
    waits = sorted(measured["waits"])
    return {
        "inputs": len(waits),
        "frames_per_s": measured["frames"] / seconds,
        "p50_ms": statistics.median(waits),
        "p95_ms": waits[int(0.95 * (len(waits) - 1))],
    }


def measure(browser: Any, arguments: list[str], moves: int) -> dict[str, Any]:
    """Start a server, measure one visit, stop it."""
    process, address, first_answer = started(arguments)
    try:
        began = time.perf_counter()
        page = browser.new_page(viewport={"width": 1440, "height": 900})
        page.goto(address)
        page.wait_for_selector(".explore .map[data-order]", timeout=120_000)
        visible = first_answer + time.perf_counter() - began
        at_start = resident_mb(process)
        result = {
            "http_200_s": first_answer,
            "map_visible_s": visible,
            "server_mb_first_page": at_start,
            **drag(page, moves),
        }
        for view in ("pair", "tree", "data"):
            page.click(f"#view-{view}-button")
            page.wait_for_selector(f".ov.{view}")
        page.wait_for_function("document.querySelector('.pair .bars table')", timeout=120_000)
        result["server_mb_all_tabs"] = resident_mb(process)
        result["browser_heap_mb"] = (
            page.evaluate("performance.memory ? performance.memory.usedJSHeapSize : 0") / 1e6
        )
        page.close()
        return result
    finally:
        process.terminate()
        process.wait()


def picture(browser: Any, arguments: list[str], to: Path) -> None:
    """Save the first page as a picture: the map, the curves and one pinned pair."""
    process, address, _ = started(arguments)
    try:
        page = browser.new_page(viewport={"width": 1440, "height": 900})
        page.goto(address + "?pin=67")
        page.wait_for_selector(".explore .map[data-order]", timeout=120_000)
        page.wait_for_load_state("networkidle")
        page.screenshot(path=to)
        page.close()
    finally:
        process.terminate()
        process.wait()


def main() -> None:
    """Measure some visits and print medians with their spread as JSON."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeat", type=int, default=3, help="visits")
    parser.add_argument("--moves", type=int, default=400, help="mouse moves of a drag")
    parser.add_argument("--picture", type=Path, help="only save a picture of the first page there")
    parser.add_argument("rest", nargs="*", help="arguments for app.py, after --")
    chosen = parser.parse_args()
    from playwright.sync_api import sync_playwright

    binary = next((path for name in CHROMIUM if (path := shutil.which(name))), None)
    if binary is None:
        raise SystemExit("Chromium is needed; install it with `apt-get install chromium`.")
    with sync_playwright() as player:
        browser = player.chromium.launch(executable_path=binary, args=FLAGS)
        if chosen.picture:
            picture(browser, chosen.rest, chosen.picture)
            browser.close()
            return
        visits = [measure(browser, chosen.rest, chosen.moves) for _ in range(chosen.repeat)]
        version = browser.version
        browser.close()
    figures = {
        name: {
            "median": round(statistics.median(visit[name] for visit in visits), 2),
            "least": round(min(visit[name] for visit in visits), 2),
            "most": round(max(visit[name] for visit in visits), 2),
        }
        for name in visits[0]
    }
    machine = {
        "machine": platform.machine(),
        "cores": os.cpu_count(),
        "load": os.getloadavg()[0],
        "python": platform.python_version(),
        "chromium": version,
    }
    print(json.dumps({"machine": machine, "visits": len(visits), "figures": figures}, indent=2))


if __name__ == "__main__":
    main()
