"""What a visitor sees first: words, the map's share of the window, margins, the smallest letters.

    python -m benchmarks.first_view [--address URL] [--out build/first_view.md] [--shots FOLDER]

Each chapter opens at five sizes in a real Chromium. Targets: at most 120 words (limit 140), a map
of at least 40 % of the window at 1280 x 720 (limit 35 %) and 50 % at 1440 x 900, margins equal, no
letter under 14 px. Words and letters count if they are in the window; the map's own names do not. A
figure and its unit are one word.
"""

import argparse
import shutil
from pathlib import Path
from typing import Any

from benchmarks._page_browser import FLAGS
from benchmarks.page import CHROMIUM, ROOT, started
from omnivat.kit.files import write_text

SIZES = ((1280, 720), (1440, 900), (2560, 1440), (1024, 768), (400, 800))
CHAPTERS = ("touch", "where", "order", "fooled", "analyse")
LOOK = """() => {
  const seen = (e) => {
    const b = e.getBoundingClientRect();
    const shown = e.checkVisibility({ visibilityProperty: true, contentVisibilityAuto: true });
    return shown && b.width > 1 && b.height > 1 && b.bottom > 0 && b.top < innerHeight && b.right > 0 && b.left < innerWidth;
  };
  const texts = [];
  const walk = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  while (walk.nextNode()) {
    const { parentElement: of, textContent: text } = walk.currentNode;
    if (!text.trim() || of.closest('script, style, option, .sr, .visually-hidden')) continue;
    const range = document.createRange();
    range.selectNodeContents(walk.currentNode);
    const b = range.getBoundingClientRect();
    if (seen(of) && b.width > 1 && b.top < innerHeight && b.bottom > 0) texts.push([of, text.trim()]);
  }
  const size = (e) => parseFloat(getComputedStyle(e).fontSize) * (e.ownerSVGElement?.getScreenCTM().a ?? 1);
  const seenOf = (parts) => [...document.querySelectorAll(parts)].find((e) => e.checkVisibility()).getBoundingClientRect();
  const map = seenOf('.explore :is(.map, .twin-pictures)');
  const all = seenOf('.explore > :is(.stage, .touch)');
  const high = Math.min(innerHeight, map.bottom) - Math.max(0, map.top);
  return {
    words: texts.flatMap(([, text]) => text.split(/[ \\n]+/)).length,
    smallest: Math.min(...texts.map(([e]) => size(e))),
    small: texts.filter(([e]) => size(e) < 13.95).map(([, text]) => text).slice(0, 8),
    map: (map.width * high) / (innerWidth * innerHeight),
    left: all.left,
    right: document.documentElement.clientWidth - all.right,
  };
}"""


def looked_at(browser: Any, address: str, shots: Path | None) -> list[dict[str, Any]]:
    """Return what each chapter shows first at each size."""
    found = []
    for width, height in SIZES:
        for chapter in CHAPTERS:
            page = browser.new_page(viewport={"width": width, "height": height})
            page.goto(f"{address}?chapter={chapter}")
            page.wait_for_selector(".explore.ready", timeout=120_000)
            page.wait_for_timeout(2500)
            found.append({"size": f"{width} x {height}", "chapter": chapter, **page.evaluate(LOOK)})
            if shots:
                page.screenshot(path=shots / f"{chapter}-{width}.png")
            page.close()
    return found


def table(figures: list[dict[str, Any]]) -> str:
    """Return the figures as a Markdown table."""
    rows = [
        f"| {one['size']} | {one['chapter']} | {one['words']} | {100 * one['map']:.0f} % | "
        f"{one['left']:.0f}, {one['right']:.0f} | {one['smallest']:.1f} |"
        for one in figures
    ]
    head = (
        "| window | chapter | words | map | margins, px | smallest letters, px |\n| --- | --- | ---"
        " | --- | --- | --- |"
    )
    return "\n".join([head, *rows]) + "\n"


def main() -> None:
    """Open the chapters and write the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--address", help="of a running page; without it, one is started")
    parser.add_argument("--out", type=Path, default=ROOT / "build" / "first_view.md")
    parser.add_argument("--shots", type=Path, help="folder for pictures of each chapter and size")
    chosen = parser.parse_args()
    from playwright.sync_api import sync_playwright

    binary = next((path for name in CHROMIUM if (path := shutil.which(name))), None)
    if binary is None:
        raise SystemExit("Chromium is needed; install it with `apt-get install chromium`.")
    process, address = (None, chosen.address) if chosen.address else started()[:2]
    if chosen.shots:
        chosen.shots.mkdir(parents=True, exist_ok=True)
    try:
        with sync_playwright() as driver:
            browser = driver.chromium.launch(executable_path=binary, args=FLAGS)
            found = looked_at(browser, address, chosen.shots)
            browser.close()
    finally:
        if process:
            process.terminate()
            process.wait()
    chosen.out.parent.mkdir(parents=True, exist_ok=True)
    write_text(chosen.out, table(found))
    print(table(found))
    for one in found:
        if one["small"]:
            print(one["size"], one["chapter"], "small letters:", one["small"])


if __name__ == "__main__":
    main()
