"""Measure the page in a real Chromium: drag, memory, a camera.

    python -m benchmarks.page [--repeat 3] [--out docs/benchmarks/page.json]

Each round starts a server and makes one whole visit, in a Chromium without a GPU at 1440 x 900.
Figures are medians of the rounds, with minimum and maximum. The mouse events are real: the slider
is dragged to both ends twice, and each move is sent when the one before is handled. *Input to
pixels* ends with the first frame on screen, so 16.7 ms is the least at 60 Hz. Maps are those of the
examples, repeated with a little noise. The camera is Chromium's moving picture, 640 x 480.
"""

import argparse
import time
from dataclasses import replace
from importlib.metadata import version
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from benchmarks._browser import ROOT, chromium, opened, resident_mb, started, summed
from benchmarks._machine import machine
from omnivat.head.heads import EXAMPLES
from omnivat.kit.files import write_json
from omnivat.maps.frames import FrameSet, read_frames, write_frames

VIEWS = ("explore", "pair", "train")
KEPT_MAPS = ("pca/raw", "pca/frft", "pca/f_hat")  # others would only enlarge the file
LIVE = ".pair .cameras [data-send=camerasSwitched]"

# Time from an input event to the second animation frame after it: the first frame draws, and at the
# start of the second the result is on screen. The minimum is one frame at 60 Hz, 16.7 ms.
WATCH = """() => {
  const map = document.querySelector('.explore .map');
  const slider = document.querySelector('.explore .order');
  const seen = window.seen = { waits: [], times: [], stops: 0, last: map.dataset.order, on: true };
  const heard = () => {
    const from = performance.now();
    const painted = () => seen.waits.push(performance.now() - from);
    requestAnimationFrame(() => requestAnimationFrame(painted));
  };
  slider.addEventListener('input', heard);
  const look = (at) => {
    seen.times.push(at);
    if (map.dataset.order !== seen.last) { seen.last = map.dataset.order; seen.stops += 1; }
    if (seen.on) requestAnimationFrame(look);
    else slider.removeEventListener('input', heard);
  };
  requestAnimationFrame(look);
}"""
READ = (
    "() => { seen.on = false; return { waits: seen.waits, times: seen.times, stops: seen.stops }; }"
)
HEAP = "() => { gc(); return performance.memory.usedJSHeapSize / 1e6; }"

# figure -> what it is, and its target: "≤" or "≥" a number, or none
FIGURES: dict[str, tuple[str, str]] = {
    "map_drawn_s": ("process start to first map drawn, s", ""),
    "2k_frames_per_s": ("2,000 points: frames a second", "≥ 47"),
    "2k_stops_per_s": ("2,000 points: stops of p shown a second", ""),
    "2k_wait_p50_ms": ("2,000 points: input to pixels, median, ms", "≤ 17"),
    "2k_wait_p95_ms": ("2,000 points: input to pixels, 95th percentile, ms", "≤ 20"),
    "2k_heap_mb": ("2,000 points: JavaScript heap after a collection, MB", "≤ 15"),
    "20k_frames_per_s": ("20,000 points: frames a second", ""),
    "20k_wait_p95_ms": ("20,000 points: input to pixels, 95th percentile, ms", "≤ 33"),
    "20k_heap_mb": ("20,000 points: JavaScript heap after a collection, MB", ""),
    "all_tabs_heap_mb": ("every tab opened: JavaScript heap, MB", "≤ 15"),
    "all_tabs_renderer_mb": ("every tab opened: renderer process, MB", ""),
    "all_tabs_server_mb": ("every tab opened: server, MB", "≤ 650"),
    "after_live_server_mb": ("server with the encoder loaded, MB", "≤ 650"),
    "live_per_s": ("camera pictures predicted a second", "≥ 15"),
}


def frames_of(pairs: int, to: Path) -> Path:
    """Write a frames file of `pairs` pairs: those of the examples, repeated with a little noise.

    Positions beyond the examples' 1,440 pairs are random; they cost the same to draw.
    """
    frames = read_frames(EXAMPLES / "frames.bin")
    rows = np.arange(pairs) % frames.pairs
    random = np.random.default_rng(0)

    def spread(points: Any) -> Any:
        both = points.reshape(len(points), 2, frames.pairs, 2)[:, :, rows]
        noise = (
            random.normal(scale=900, size=both.shape[1:])
            * (np.arange(pairs) >= frames.pairs)[:, None]
        )
        moved = np.clip(both + noise, 0, 65535).astype(np.uint16)
        return moved.reshape(len(points), 2 * pairs, 2)

    larger: FrameSet = replace(
        frames,
        domain=frames.domain[rows],
        label=frames.label[rows],
        prediction=frames.prediction[:, rows],
        confidence=frames.confidence[:, rows],
        maps={n: replace(frames.maps[n], points=spread(frames.maps[n].points)) for n in KEPT_MAPS},
    )
    write_frames(to, larger)
    return to


def drag(page: Any, moves: int) -> dict[str, float]:
    """Drag the slider to both ends twice, one move for each animation frame; return the timings."""
    box = page.locator(".explore .order").bounding_box()
    middle, left, right = box["y"] + box["height"] / 2, box["x"] + 12, box["x"] + box["width"] - 12
    page.mouse.move(left, middle)
    page.mouse.down()
    page.evaluate(WATCH)
    for end in (right, left, right, left):
        page.mouse.move(end, middle, steps=moves // 4)
    seen = page.evaluate(READ)
    page.mouse.up()
    seconds = (seen["times"][-1] - seen["times"][0]) / 1000
    gaps = np.diff(seen["times"])
    return {
        "stops_per_s": seen["stops"] / seconds,
        "frames_per_s": len(gaps) / seconds,
        "wait_p50_ms": float(np.quantile(seen["waits"], 0.5)),
        "wait_p95_ms": float(np.quantile(seen["waits"], 0.95)),
    }


def every_tab(page: Any) -> None:
    """Open each tab and wait until it is complete."""
    for view in VIEWS[1:]:
        page.evaluate("id => document.getElementById(id).click()", f"view-{view}-button")
        page.wait_for_selector(f".ov.{view}:visible")
        page.wait_for_load_state("networkidle")


def heap_mb(page: Any) -> float:
    """Return the used JavaScript heap after a collection, array buffers included, in MB."""
    return float(page.evaluate(HEAP))


def renderers_mb(chromium: Any) -> float:
    """Return the resident memory of the largest renderer process of this browser, in MB."""
    session = chromium.new_browser_cdp_session()
    found = session.send("SystemInfo.getProcessInfo")["processInfo"]
    return max(resident_mb(process["id"]) for process in found if process["type"] == "renderer")


def live(page: Any, pictures: int) -> float:
    """Predict Chromium's test camera, a moving picture; return how many a second."""
    page.evaluate("document.getElementById('view-pair-button').click()")
    page.wait_for_selector(".pair .reading")
    page.click(".pair .cameras > summary")
    answered: list[dict[str, Any]] = []
    page.on(
        "requestfinished",
        lambda request: answered.append(request.timing) if "/live?" in request.url else None,
    )
    page.click(LIVE)
    while len(answered) < pictures + 5:  # the first ones load the encoder
        page.wait_for_timeout(50)
    page.click(LIVE)
    starts = [timing["startTime"] for timing in answered[5:]]
    return float(1000 * (len(starts) - 1) / (starts[-1] - starts[0]))


def measured(chromium: Any, to: Path, moves: int) -> dict[str, float]:
    """Start a server, measure one visit from cold start to every tab opened, stop it."""
    began = time.perf_counter()
    with started() as (process, address, _):
        page = opened(chromium, address, "?chapter=analyse")
        figures = {"map_drawn_s": time.perf_counter() - began}
        page.wait_for_load_state("networkidle")
        page.close()
        for name, pairs in (("2k", 1000), ("20k", 10_000)):
            page = opened(
                chromium, address, "?chapter=analyse&p=0", frames_of(pairs, to / f"{name}.bin")
            )
            page.wait_for_load_state("networkidle")
            drag(page, moves // 4)  # what runs often is compiled by now
            figures |= {f"{name}_{key}": value for key, value in drag(page, moves).items()}
            figures[f"{name}_heap_mb"] = heap_mb(page)
            page.close()
        page = opened(chromium, address, "?chapter=analyse", frames=to / "2k.bin")
        every_tab(page)
        figures["all_tabs_server_mb"] = resident_mb(process)
        figures["all_tabs_heap_mb"] = heap_mb(page)
        figures["all_tabs_renderer_mb"] = renderers_mb(chromium)
        figures["live_per_s"] = live(page, 60)
        figures["after_live_server_mb"] = resident_mb(process)
        page.close()
        return figures


def met(target: str, median: float) -> str:
    """Return whether a median reaches a target, in words."""
    if not target:
        return ""
    sign, _, limit = target.partition(" ")
    good = median <= float(limit) if sign == "≤" else median >= float(limit)
    return f"target {target}  {'met' if good else 'NOT met'}"


def main() -> None:
    """Measure some rounds; write the record and print its table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeat", type=int, default=3, help="rounds")
    parser.add_argument("--moves", type=int, default=400, help="mouse moves of a drag")
    parser.add_argument("--out", type=Path, default=ROOT / "docs/benchmarks/page.json")
    chosen = parser.parse_args()
    with chromium() as browser, TemporaryDirectory() as folder:
        rounds = [measured(browser, Path(folder), chosen.moves) for _ in range(chosen.repeat)]
        about = {"gradio": version("gradio"), "chromium": browser.version, "rounds": len(rounds)}
    figures = summed(rounds)
    write_json(chosen.out, machine() | about | {"figures": figures})
    for name, (what, target) in FIGURES.items():
        figure = figures[name]
        spread = f"{figure['median']:8.3g} ({figure['least']:.3g} to {figure['most']:.3g})"
        print(f"{what:60} {spread:28} {met(target, figure['median'])}")


if __name__ == "__main__":
    main()
