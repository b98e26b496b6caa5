"""Measure the page in a real Chromium: drag, cold start, memory, visitors, a camera.

    python -m benchmarks.page [--repeat 3] [--out docs/benchmarks/page]

Each round starts a server and makes one whole visit. Figures are medians of the rounds, with
minimum and maximum. Writes a page and a JSON. `--picture FILE` only saves a picture of Explore.
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
from importlib.metadata import version
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any
from urllib.request import urlopen

from benchmarks._page_browser import FLAGS, measured, opened

ROOT = Path(__file__).resolve().parent.parent
CHROMIUM = ("chromium", "chromium-browser", "google-chrome")

# figure -> description, unit, and target (an upper limit, or a lower one with "≥")
FIGURES: dict[str, tuple[str, str]] = {
    "http_200_s": ("process start to first page served, s", "≤ 4"),
    "map_drawn_s": ("process start to first map drawn, s", ""),
    "server_first_page_mb": ("server, first page shown, MB", "≤ 350"),
    "2k_inputs_per_s": ("2,000 points: moves that reach the slider a second", ""),
    "2k_stops_per_s": ("2,000 points: stops of p shown a second", ""),
    "2k_frames_per_s": ("2,000 points: frames a second", "≥ 47"),
    "2k_frame_p50_ms": ("2,000 points: time between frames, median, ms", ""),
    "2k_frame_p95_ms": ("2,000 points: time between frames, 95th percentile, ms", ""),
    "2k_wait_p50_ms": ("2,000 points: input to pixels, median, ms", "≤ 17"),
    "2k_wait_p95_ms": ("2,000 points: input to pixels, 95th percentile, ms", "≤ 20"),
    "20k_stops_per_s": ("20,000 points: stops of p shown a second", ""),
    "20k_frame_p50_ms": ("20,000 points: time between frames, median, ms", ""),
    "20k_frame_p95_ms": ("20,000 points: time between frames, 95th percentile, ms", ""),
    "20k_wait_p50_ms": ("20,000 points: input to pixels, median, ms", ""),
    "20k_wait_p95_ms": ("20,000 points: input to pixels, 95th percentile, ms", "≤ 33"),
    "exact_p50_ms": (
        "a pair at 101 stops and one exact p, requested by the page, median, ms",
        "≤ 150",
    ),
    "exact_p95_ms": ("the same, 95th percentile, ms", ""),
    "2k_heap_mb": ("JavaScript heap after a collection, 2,000 points, MB", "≤ 15"),
    "20k_heap_mb": ("JavaScript heap after a collection, 20,000 points, MB", ""),
    "all_tabs_heap_mb": ("JavaScript heap, every tab opened, MB", "≤ 15"),
    "all_tabs_renderer_mb": ("renderer process, every tab opened, MB", ""),
    "all_tabs_server_mb": ("server, every tab opened, MB", "≤ 650"),
    "after_live_server_mb": ("server with the encoder loaded, MB", "≤ 650"),
    "live_per_s": ("camera pictures predicted a second", "≥ 15"),
    "live_read_ms": ("of one picture: decode and prepare, ms", ""),
    "live_encoder_ms": ("of one picture: encoder, ms", ""),
    "live_head_ms": ("of one picture: head, ms", ""),
    "visitors_p50_s": ("fifty visitors at once: page, map and a pair's predictions, median, s", ""),
    "visitors_p95_s": ("the same, 95th percentile, s", ""),
    "visitors_added_mb": ("memory that fifty visitors add to the server, MB", ""),
}
NOTES = """One round is one server and one visit, in a Chromium without a GPU at 1440 × 900. The mouse events are real. The mouse is
pressed on the slider and moved to both ends twice. Each move is sent when the browser has handled the one before. This limits the stops shown a
second, so compare them with the moves that reach the slider. *Input to pixels* is the time from the slider's `input` event to the start of the second
animation frame after it; by then the first one is on the screen. At 60 Hz it cannot be less than 16.7 ms. The maps of 2,000 and 20,000 points are
those of the examples, cut or repeated with a little noise. The rest of the page is there while the mouse moves. The camera is Chromium's moving test
picture, 640 × 480; each prediction takes the encoder and the whole head."""


def free_port() -> int:
    """Return a free port."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def started() -> tuple[subprocess.Popen[bytes], str, float]:
    """Start the page; return the process, its address, and the seconds until its first reply."""
    port = free_port()
    began = time.perf_counter()
    process = subprocess.Popen(
        [sys.executable, "app.py", "--no-browser", "--port", str(port)],
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


def picture(browser: Any, to: Path) -> None:
    """Save the first page as a picture: the maps, the curves and one pinned pair."""
    process, address, _ = started()
    try:
        page = opened(browser, address, "?pin=67")
        page.wait_for_load_state("networkidle")
        page.screenshot(path=to)
    finally:
        process.terminate()
        process.wait()


def report(rounds: list[dict[str, float]], browser: str) -> dict[str, Any]:
    """Return the figures: median, minimum and maximum of each, with the machine."""
    return {
        "machine": f"{os.cpu_count()}-core {platform.machine()} CPU",
        "load": round(os.getloadavg()[0], 2),
        "python": platform.python_version(),
        "gradio": version("gradio"),
        "torch": version("torch"),
        "chromium": browser,
        "rounds": len(rounds),
        "figures": {
            name: {
                "median": round(statistics.median(one[name] for one in rounds), 2),
                "least": round(min(one[name] for one in rounds), 2),
                "most": round(max(one[name] for one in rounds), 2),
            }
            for name in FIGURES
        },
    }


def kept(target: str, median: float) -> str:
    """Return "yes" or "no" for a target."""
    if not target:
        return ""
    sign, _, limit = target.partition(" ")
    good = median <= float(limit) if sign == "≤" else median >= float(limit)
    return "yes" if good else "**no**"


def written(report: dict[str, Any]) -> str:
    """Return the report as a page."""
    lines = [
        "# The page: drag, start, memory",
        "",
        "`python -m benchmarks.page`",
        "",
        (
            f"{report['machine']}, shared, load {report['load']}, no GPU; Chromium"
            f" {report['chromium']}, Python {report['python']}, gradio {report['gradio']}, torch"
            f" {report['torch']}. Median of {report['rounds']} rounds (least to most)."
        ),
        "",
        "| what | figure | target | met |",
        "| --- | --- | --- | --- |",
    ]
    for name, (what, target) in FIGURES.items():
        one = report["figures"][name]
        spread = f"{one['median']:.3g} ({one['least']:.3g} to {one['most']:.3g})"
        lines.append(f"| {what} | {spread} | {target} | {kept(target, one['median'])} |")
    return "\n".join([*lines, "", NOTES]) + "\n"


def main() -> None:
    """Measure some rounds; write the record and print its table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeat", type=int, default=3, help="rounds")
    parser.add_argument("--moves", type=int, default=400, help="mouse moves of a drag")
    parser.add_argument("--out", type=Path, default=ROOT / "docs/benchmarks/page")
    parser.add_argument("--picture", type=Path, help="only save a picture of the first page there")
    chosen = parser.parse_args()
    from playwright.sync_api import sync_playwright

    binary = next((path for name in CHROMIUM if (path := shutil.which(name))), None)
    if binary is None:
        raise SystemExit("Chromium is needed; install it with `apt-get install chromium`.")
    with sync_playwright() as player, TemporaryDirectory() as folder:
        browser = player.chromium.launch(executable_path=binary, args=FLAGS)
        if chosen.picture:
            picture(browser, chosen.picture)
            return
        rounds = []
        for number in range(chosen.repeat):
            rounds.append(measured(browser, started, Path(folder), chosen.moves))
            print(f"round {number + 1} of {chosen.repeat} done", file=sys.stderr)
        found = report(rounds, browser.version)
    chosen.out.parent.mkdir(parents=True, exist_ok=True)
    text = json.dumps(found, indent=1, ensure_ascii=False) + "\n"
    chosen.out.with_suffix(".json").write_text(text, encoding="utf-8")
    print(written(found))


if __name__ == "__main__":
    main()
