"""Measurements inside Chromium: a dragged mouse, memory, live camera."""

import json
import statistics
import subprocess
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from typing import Any
from urllib.request import urlopen

import numpy as np

from omnivat.head.heads import EXAMPLES
from omnivat.maps.frames import FrameSet, read_frames, write_frames

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
VIEWS = ("explore", "pair", "train")
KEPT_MAPS = ("pca/raw", "pca/frft", "pca/f_hat")  # others would only enlarge the file
SLOT = '.pair .slot[data-modality="tac"]'

# Time from an input event to the second animation frame after it: the first frame draws, and at the
# start of the second the result is on screen. The minimum is one frame at 60 Hz, 16.7 ms.
WATCH = """() => {
  const map = document.querySelector('.explore .map');
  const slider = document.querySelector('.explore .order');
  const seen = window.seen = { waits: [], times: [], stops: 0, last: map.dataset.order, on: true };
  const heard = () => {
    const from = performance.now();
    requestAnimationFrame(() => requestAnimationFrame((at) => seen.waits.push(performance.now() - from)));
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


def opened(browser: Any, address: str, query: str = "", frames: Path | None = None) -> Any:
    """Return a page with a new profile, after its map is drawn."""
    page = browser.new_page(viewport={"width": 1440, "height": 900}, permissions=["camera"])
    page.set_default_timeout(120_000)
    if frames:
        page.route(
            "**/omnivat/frames",
            lambda route: route.fulfill(path=frames, headers={"X-Frames": "fine"}),
        )
    page.goto(address + query, wait_until="commit")
    page.wait_for_selector(MAP)
    return page


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
        "inputs_per_s": len(seen["waits"]) / seconds,
        "stops_per_s": seen["stops"] / seconds,
        "frames_per_s": len(gaps) / seconds,
        **quantiles("wait", seen["waits"]),
        **quantiles("frame", gaps),
    }


def quantiles(name: str, values: Any) -> dict[str, float]:
    """Return the median and the 95th percentile under names of their own."""
    return {
        f"{name}_p50_ms": float(np.quantile(values, 0.5)),
        f"{name}_p95_ms": float(np.quantile(values, 0.95)),
    }


def settled(page: Any, times: int) -> dict[str, float]:
    """Request the predictions of a pair at several p in turn; return milliseconds."""
    waits = page.evaluate(
        """async (times) => {
          const waits = [];
          for (let i = 0; i < times + 2; i++) {
            const from = performance.now();
            const body = JSON.stringify({ vis: `row:${i}`, tac: `row:${i}`, order: (i % 100) / 100 });
            await (await fetch('omnivat/pair', { method: 'POST', body })).json();
            if (i > 1) waits.push(performance.now() - from);
          }
          return waits;
        }""",
        times,
    )
    return quantiles("exact", waits)


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
    return max(resident_mb(one["id"]) for one in found if one["type"] == "renderer")


def resident_mb(pid: int) -> float:
    """Return the resident memory of a process, in MB."""
    status = Path(f"/proc/{pid}/status").read_text(encoding="ascii")
    line = next(line for line in status.splitlines() if line.startswith("VmRSS"))
    return int(line.split()[1]) / 1024


def live(page: Any, pictures: int) -> dict[str, float]:
    """Predict Chromium's test camera, a moving picture, and return the rate."""
    page.evaluate("document.getElementById('view-pair-button').click()")
    page.wait_for_selector(".pair .reading")
    answered: list[dict[str, Any]] = []
    page.on(
        "requestfinished",
        lambda request: answered.append(request.timing) if "/live?" in request.url else None,
    )
    page.click(f"{SLOT} .live")
    while len(answered) < pictures + 5:  # the first ones load the encoder
        page.wait_for_timeout(50)
    told = page.evaluate("""async () => {
          const canvas = new OffscreenCanvas(256, 192);
          canvas.getContext('2d').fillRect(20, 30, 90, 60);
          const body = await canvas.convertToBlob({ type: 'image/jpeg' });
          const found = [];
          for (let i = 0; i < 12; i++) {
            found.push((await (await fetch('omnivat/live?modality=tac&other=row:0', { method: 'POST', body })).json()).ms);
          }
          return found;
        }""")
    page.click(f"{SLOT} .live")
    starts = [timing["startTime"] for timing in answered[5:]]
    return {
        "live_per_s": 1000 * (len(starts) - 1) / (starts[-1] - starts[0]),
        **{f"live_{part}_ms": statistics.median(one[part] for one in told) for part in told[0]},
    }


def measured(
    chromium: Any,
    start: Callable[[], tuple[subprocess.Popen[bytes], str, float]],
    to: Path,
    moves: int,
) -> dict[str, float]:
    """Start a server, measure one visit from cold start to every tab opened, stop it."""
    began = time.perf_counter()
    process, address, answered = start()
    try:
        page = opened(chromium, address)
        found = {"http_200_s": answered, "map_drawn_s": time.perf_counter() - began}
        found["server_first_page_mb"] = resident_mb(process.pid)
        page.wait_for_load_state("networkidle")
        page.close()
        for name, pairs in (("2k", 1000), ("20k", 10_000)):
            page = opened(chromium, address, "?p=0", frames_of(pairs, to / f"{name}.bin"))
            page.wait_for_load_state("networkidle")
            drag(page, moves // 4)  # what runs often is compiled by now
            found |= {f"{name}_{key}": value for key, value in drag(page, moves).items()}
            found[f"{name}_heap_mb"] = heap_mb(page)
            page.close()
        page = opened(chromium, address, frames=to / "2k.bin")
        found |= settled(page, 30)
        every_tab(page)
        found["all_tabs_server_mb"] = resident_mb(process.pid)
        found["all_tabs_heap_mb"] = heap_mb(page)
        found["all_tabs_renderer_mb"] = renderers_mb(chromium)
        found |= live(page, 60)
        found["after_live_server_mb"] = resident_mb(process.pid)
        page.close()
        return found | fifty(address, process.pid)
    finally:
        process.terminate()
        process.wait()


def fifty(address: str, pid: int, visitors: int = 50) -> dict[str, float]:
    """Simulate fifty visitors at once; each loads page, map and a pair's 101 predictions."""
    before = resident_mb(pid)

    def visit(number: int) -> float:
        began = time.perf_counter()
        for path in ("", "omnivat/frames"):
            with urlopen(address + path) as answer:
                answer.read()
        body = json.dumps({"vis": f"row:{number}", "tac": f"row:{number}"}).encode()
        with urlopen(address + "omnivat/pair", data=body) as answer:
            answer.read()
        return time.perf_counter() - began

    with ThreadPoolExecutor(visitors) as crowd:
        seconds = list(crowd.map(visit, range(visitors)))
    return {
        "visitors_p50_s": float(np.quantile(seconds, 0.5)),
        "visitors_p95_s": float(np.quantile(seconds, 0.95)),
        "visitors_added_mb": resident_mb(pid) - before,
    }
