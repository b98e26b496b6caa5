"""Make the README's pictures in a real browser: three views of the page.

    python -m benchmarks.pictures [--out docs]

Needs Chromium.
"""

import argparse
import io
from pathlib import Path
from typing import Any

from PIL import Image

from benchmarks._browser import ROOT, chromium, opened, started

LARGE = {"width": 1440, "height": 900}


def shot(page: Any, to: Path) -> None:
    """Write the window as a WebP, a third as large as a PNG."""
    Image.open(io.BytesIO(page.screenshot())).convert("RGB").save(to, quality=85, method=6)


def chapter(page: Any, name: str, ready: str, to: Path) -> None:
    """Write a chapter of Explore once `ready` is there."""
    page.click(f'.explore .chapters [data-chapter="{name}"]')
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
    examples = ROOT / "examples" / "pairs"
    photo = sorted(examples.glob("TQ-DIGIT-sim/**/*_vis.*"))[-1]
    touch = photo.with_name(photo.name.replace("_vis", "_tac"))
    with started() as (_, address, _), chromium() as browser:
        page = opened(browser, address, "?chapter=analyse")
        page.set_viewport_size(LARGE)
        chapter(page, "gaps", ".explore .tree-of-pair", chosen.out / "page.webp")
        chapter(page, "where", ".explore .places button", chosen.out / "where.webp")
        own_picture(page, photo, touch, chosen.out / "own.webp")


if __name__ == "__main__":
    main()
