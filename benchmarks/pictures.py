"""Make the README's pictures in a real browser: the page, a drag of p on chirps, and three close-ups.

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


def close_up(page: Any, selector: str, to: Path) -> None:
    """Write the picture of one element."""
    page.wait_for_selector(selector, state="visible")
    page.locator(selector).first.screenshot(path=to)


def strangers(page: Any, to: Path) -> None:
    """Write the bars of every unseen domain."""
    page.click('.explore [data-part="strangers"]')
    page.wait_for_timeout(1500)
    close_up(page, ".explore .board .left", to)


def own_picture(page: Any, photo: Path, touch: Path, to: Path) -> None:
    """Write the page's results for a visitor's pair."""
    page.click("#view-pair-button, button[role=tab]:has-text('Try a pair')")
    for modality, file in (("vis", photo), ("tac", touch)):
        page.set_input_files(f'.pair .slot[data-modality="{modality}"] input[type=file]', file)
    page.wait_for_timeout(5000)
    page.screenshot(path=to)


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
            page = opened(browser, address, "?pin=67")
            page.set_viewport_size({"width": WIDTH, "height": HEIGHT})
            page.wait_for_load_state("networkidle")
            page.screenshot(path=chosen.out / "page.png")
            strangers(page, chosen.out / "strangers.png")
            own_picture(page, photo, touch, chosen.out / "own.png")
            page = opened(browser, address, "?set=chirps&colour=class")
            page.set_viewport_size({"width": WIDTH, "height": HEIGHT})
            page.wait_for_load_state("networkidle")
            drag(page, chosen.out / "drag.webp")
            browser.close()
    finally:
        process.terminate()
        process.wait()


if __name__ == "__main__":
    main()
