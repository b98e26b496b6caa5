"""Make the README's pictures in a real browser: three views of the page, and a drag of p on chirps.

    python -m benchmarks.pictures [--out docs]

Needs Chromium. The drag steps through exact frames without interpolation.
"""

import argparse
import io
import shutil
from pathlib import Path
from typing import Any

from PIL import Image

from benchmarks._page_browser import FLAGS, opened
from benchmarks.page import CHROMIUM, ROOT, started

WIDTH, HEIGHT = 1280, 800
LARGE = {"width": 1440, "height": 900}
STOPS = (*range(0, 101, 5), *range(95, 30, -5))  # hundredths of p: there, and back to p*
MOVE = """value => {
  const slider = document.querySelector('.explore .order');
  slider.value = value;
  slider.dispatchEvent(new Event('input', { bubbles: true }));
}"""


def drag(page: Any, to: Path) -> None:
    """Write the drag of p as an animated WebP, 900 pixels wide."""
    page.wait_for_selector(".explore .map[data-order]")
    frames = []
    for stop in STOPS:
        page.evaluate(MOVE, f"{stop / 100:.2f}")
        page.wait_for_timeout(120)
        shot = Image.open(io.BytesIO(page.screenshot())).convert("RGB")
        frames.append(shot.resize((900, round(900 * shot.height / shot.width))))
    first, *others = frames
    first.save(to, save_all=True, append_images=others, duration=220, loop=0, quality=55, method=6)


def shot(page: Any, to: Path) -> None:
    """Write the window as a PNG of 256 colours, a third as large."""
    seen = Image.open(io.BytesIO(page.screenshot())).convert("RGB")
    seen.quantize(256).save(to, optimize=True)


def chapter(page: Any, name: str, ready: str, to: Path) -> None:
    """Write a chapter of Explore once `ready` is there."""
    page.click(f'.explore [data-chapter="{name}"]')
    page.wait_for_selector(ready, timeout=120_000)
    page.wait_for_timeout(2500)
    shot(page, to)


def own_picture(page: Any, photo: Path, touch: Path, to: Path) -> None:
    """Write the page's results for a visitor's pair."""
    page.click("#view-pair-button, button[role=tab]:has-text('Try a pair')")
    for modality, file in (("vis", photo), ("tac", touch)):
        page.set_input_files(f'.pair .slot[data-modality="{modality}"] input[type=file]', file)
    page.wait_for_timeout(5000)
    shot(page, to)


def main() -> None:
    """Start the page, make the pictures, stop it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=ROOT / "docs")
    chosen = parser.parse_args()
    from playwright.sync_api import sync_playwright

    binary = next((path for name in CHROMIUM if (path := shutil.which(name))), None)
    if binary is None:
        raise SystemExit("Chromium is needed; install it with `apt-get install chromium`.")
    examples = ROOT / "examples" / "pairs"
    photo = sorted(examples.rglob("*_vis.*"))[-1]
    touch = photo.with_name(photo.name.replace("_vis", "_tac"))
    process, address, _ = started()
    try:
        with sync_playwright() as driver:
            browser = driver.chromium.launch(executable_path=binary, args=FLAGS)
            page = opened(browser, address, "?chapter=order&p=0.35")
            page.set_viewport_size(LARGE)
            chapter(page, "order", ".explore .map[data-order]", chosen.out / "page.png")
            all_bars = ".explore .waterfall [data-rung=n20]"
            chapter(page, "failure", all_bars, chosen.out / "failure.png")
            own_picture(page, photo, touch, chosen.out / "own.png")
            page = opened(browser, address, "?chapter=order")
            page.set_viewport_size({"width": WIDTH, "height": HEIGHT})
            page.wait_for_load_state("networkidle")
            drag(page, chosen.out / "drag.webp")
            browser.close()
    finally:
        process.terminate()
        process.wait()


if __name__ == "__main__":
    main()
