"""The whole site in Chromium: an own pair from drop to readings, stalls of the page, a slow line, a slow processor."""

import base64
import json
import os
import re
import signal
import statistics
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

READING = ".pair .reading .said"
DESK = {"viewport": {"width": 1440, "height": 900}, "permissions": ["camera"]}
TRACED = ["toplevel"]
LOOK_MS = 3000  # between two pairs, for which a visitor looks at the first
TOLD = """globalThis.told = []; setInterval(() => {
  const text = document.querySelector('.on-its-way:not([hidden])')?.textContent ?? '';
  if (text.includes('the encoder')) told.push([performance.now(), text]);
}, 20)"""
TICK_S = 0.02  # a slowed process runs for a part of each tick
DROP = """async (files) => {
  const bytes = (text) => Uint8Array.from(atob(text), (one) => one.charCodeAt(0));
  const frame = () => new Promise((resolve) => requestAnimationFrame(resolve));
  const began = performance.now();
  for (const [name, text] of Object.entries(files)) {
    const dataTransfer = new DataTransfer();
    dataTransfer.items.add(new File([bytes(text)], `${name}.jpg`, { type: 'image/jpeg' }));
    const drop = new DragEvent('drop', { dataTransfer, bubbles: true, cancelable: true });
    document.querySelector(`.pair .slot[data-modality=${name}]`).dispatchEvent(drop);
  }
  await new Promise((resolve) => setTimeout(resolve));
  const busy = () => document.querySelector('.pair .slot.busy, .pair .results[aria-busy=true]');
  while (busy() || document.querySelectorAll('.pair .reading .said').length < 3) await frame();
  return performance.now() - began;
}"""
WARM = (  # the map, which waits for the models, is there
    "() => document.querySelector('.pair .on-map canvas') && !document.querySelector('.on-its-way:not([hidden])')"
)


def texts(pair: Mapping[str, bytes]) -> dict[str, str]:
    """Return the files of a pair as text."""
    return {name: base64.b64encode(content).decode() for name, content in pair.items()}


def ready(page: Any, address: str) -> None:
    """Open Try a pair, and wait until its models and its map are there."""
    page.goto(f"{address}?tab=pair")
    page.wait_for_selector(READING)
    page.wait_for_function(WARM)
    page.wait_for_load_state("networkidle")


def processor_ms(pid: int) -> dict[str, float]:
    """Return the processor time of each kind of thread of a process."""
    found: dict[str, float] = {}
    for thread in Path(f"/proc/{pid}/task").iterdir():
        name = (thread / "comm").read_text().strip()
        spent = int((thread / "schedstat").read_text().split()[0]) / 1e6
        found[name] = found.get(name, 0.0) + spent
    return found


def renderer(browser: Any) -> int:
    """Return the process of the page."""
    session = browser.new_browser_cdp_session()
    known = session.send("SystemInfo.getProcessInfo")["processInfo"]
    pids = [int(one["id"]) for one in known if one["type"] == "renderer"]
    return max(pids, key=lambda pid: sum(processor_ms(pid).values()))


@contextmanager
def slowed(pid: int, times: int) -> Iterator[None]:
    """Let a process run for 1 / `times` of the time, with all of its threads."""
    done = threading.Event()

    def hold() -> None:
        while not done.wait(TICK_S / times):
            os.kill(pid, signal.SIGSTOP)
            time.sleep(TICK_S * (1 - 1 / times))
            os.kill(pid, signal.SIGCONT)

    holder = threading.Thread(target=hold)
    if times > 1:
        holder.start()
    try:
        yield
    finally:
        done.set()
        if times > 1:
            holder.join()


def dropped(browser: Any, address: str, pairs: Sequence[Mapping[str, bytes]]) -> dict[str, Any]:
    """Return milliseconds from drop to three readings, of the first pair, later ones, and slowed ones."""
    page = browser.new_page(**DESK)
    page.set_default_timeout(300_000)
    ready(page, address)
    pid = renderer(browser)
    waits, worker, all_threads = [], [], []
    for pair in pairs:
        page.wait_for_timeout(LOOK_MS)
        before = processor_ms(pid)
        waits.append(page.evaluate(DROP, texts(pair)))
        spent = {name: ms - before.get(name, 0.0) for name, ms in processor_ms(pid).items()}
        worker.append(sum(ms for name, ms in spent.items() if name.startswith("Dedicated")))
        all_threads.append(sum(spent.values()))
    with slowed(pid, 4):
        slow = [page.evaluate(DROP, texts(pair)) for pair in pairs[:4]]
    page.close()
    return {
        "first_pair_ms": waits[0],
        "later_pair_ms": statistics.median(waits[1:]),
        "slowed_four_times_ms": statistics.median(slow),
        "processor_ms_of_the_worker": statistics.median(worker),
        "processor_ms_of_all_threads": statistics.median(all_threads),
        "first_pair_processor_ms_of_all_threads": all_threads[0],
    }


def longest(browser: Any, page: Any, action: Callable[[], None]) -> dict[str, float]:
    """Return the longest task of the page's main thread during an action: its milliseconds and processor time."""
    browser.start_tracing(page=page, categories=TRACED)
    action()
    events = json.loads(browser.stop_tracing())["traceEvents"]
    names = {(e["pid"], e["tid"]): e["args"]["name"] for e in events if e["name"] == "thread_name"}
    tasks = [
        e
        for e in events
        if e.get("ph") == "X" and "RunTask" in e["name"] and names[e["pid"], e["tid"]] == "CrRendererMain"
    ]
    return {
        "longest_ms": max(e["dur"] for e in tasks) / 1000,
        "longest_processor_ms": max(e.get("tdur", 0) for e in tasks) / 1000,
    }


def stalls(browser: Any, address: str, pairs: Sequence[Mapping[str, bytes]]) -> dict[str, Any]:
    """Return the longest task of the main thread in what visitors do with own pictures, and Live's rate."""
    page = browser.new_page(**DESK)
    page.set_default_timeout(300_000)
    ready(page, address)
    found: dict[str, Any] = {}

    def taught() -> None:
        for number, pair in enumerate(pairs[:4]):
            page.evaluate(DROP, texts(pair))
            page.click(f".pair .own .labels button >> nth={number % 2}")
            page.wait_for_selector(f".pair .own .chips li >> nth={number}")
        page.click(".pair .own .teach")
        page.wait_for_selector(".pair .own .taught")

    def live() -> None:
        page.click(".pair .cameras > summary")
        page.click(".pair .cameras .start")
        page.wait_for_selector(".pair .cameras .rate:has-text('ms from camera')")
        page.wait_for_timeout(5000)
        told = page.inner_text(".pair .cameras .rate")
        found["live_pairs_per_s"] = float((re.match(r"[\d.]+", told) or ["nan"])[0])
        page.click(".pair .cameras .start")

    with TemporaryDirectory(prefix="omnivat-pictures-") as folder:
        files = []
        for number, content in enumerate([one for pair in pairs for one in pair.values()][:20]):
            files.append(Path(folder) / f"{number}_{('vis', 'tac')[number % 2]}.jpg")
            files[-1].write_bytes(content)

        def profile() -> None:
            page.set_input_files(".pair .sensor input:not([webkitdirectory])[multiple]", files)
            page.wait_for_selector(".pair .sensor .save")

        found["pair"] = longest(browser, page, lambda: page.evaluate(DROP, texts(pairs[0])))
        found["profile of 20 pictures"] = longest(browser, page, profile)
        found["teaching four pairs"] = longest(browser, page, taught)
        found["live"] = longest(browser, page, live)
    page.close()
    return found


def over_line(browser: Any, address: str) -> dict[str, Any]:
    """Return the seconds until a new visitor's first chapter, first prediction and encoder are there, and what
    the page told of the way.
    """
    found: dict[str, Any] = {}
    for query, name, selector in (
        ("", "first_chapter_s", ".explore.ready"),
        ("?tab=pair", "first_prediction_s", READING),
    ):
        context = browser.new_context(**DESK)
        page = context.new_page()
        page.set_default_timeout(300_000)
        page.add_init_script(TOLD)
        began = time.monotonic()
        page.goto(address + query, wait_until="commit")
        page.wait_for_selector(selector)
        found[name] = time.monotonic() - began
        if query:
            page.wait_for_selector(".pair .on-map canvas")
            found["map_there_s"] = time.monotonic() - began
            told = page.evaluate("told")
            found |= {"encoder_there_s": told[-1][0] / 1000, "told": told[len(told) // 2][1]}
        context.close()
    return found
