"""Memory that a visitor of half an hour leaves in the server.

    python -m benchmarks.visitor [--minutes 30] [--trainings 2]

The visitor goes through every chapter, drags p by keys, opens steps, heads and the second map,
reads own pairs with every panel open, shows them at every p, and trains heads. Printed after each
part: resident memory of the server, and a minute after the last, what the visit left and its peak.
"""

import argparse
import time
from collections.abc import Sequence
from io import BytesIO
from random import Random
from typing import Any

import numpy as np
from PIL import Image

from benchmarks._browser import chromium, opened, resident_mb, started

CHAPTERS = ("touch", "gaps", "where", "order", "fooled", "analyse")
WITH_P = ("gaps", "order", "analyse")
REST_S = 60  # the server gives memory back a moment after its work


def picture(random: Random) -> dict[str, Any]:
    """Return a file of noise, as Playwright takes it."""
    noise = np.random.default_rng(random.randrange(1 << 30)).integers(0, 255, (256, 256, 3))
    held = BytesIO()
    Image.fromarray(noise.astype(np.uint8)).save(held, "PNG")
    return {"name": "own.png", "mimeType": "image/png", "buffer": held.getvalue()}


def chapters(page: Any, random: Random) -> None:
    """Visit each chapter, and play with what it has."""
    for name in CHAPTERS:
        page.click(f'.explore .chapters [data-chapter="{name}"]')
        page.wait_for_selector(f'.explore.ready[data-chapter="{name}"]')
        if name in WITH_P:
            page.focus(".explore .order")
            for _ in range(14):
                page.keyboard.press("ArrowRight")
                page.wait_for_timeout(60)
        if name == "gaps":
            heads = page.locator(".of-head option").evaluate_all("all => all.map((o) => o.value)")
            page.locator(".gap-steps button").nth(random.randrange(6)).click()
            page.select_option(".of-head", random.choice(heads))
            page.wait_for_timeout(2500)
            page.select_option(".of-head", "")
        if name == "analyse":
            page.click(".explore .second")
            page.wait_for_timeout(3000)
            page.click(".explore .second")
        page.wait_for_timeout(4000)


def own_pairs(page: Any, random: Random) -> None:
    """Read three own pairs with every panel open, and show the last at every p."""
    page.click("#view-pair-button")
    files = page.locator(".pair .slot input[type=file]")
    for _ in range(3):
        for slot in (0, 1):
            files.nth(slot).set_input_files(picture(random))
        page.wait_for_selector("body[data-ready]")
        page.evaluate(
            "document.querySelectorAll('.pair details').forEach((one) => { one.open = true; })"
        )
        page.wait_for_timeout(5000)
        page.wait_for_selector("body[data-ready]")
    page.get_by_role("button", name="Show it at every p").click()
    page.wait_for_selector(".explore.ready[data-chapter=gaps]")
    page.wait_for_timeout(4000)


def trained(page: Any) -> None:
    """Train a head with the settings that are there."""
    page.click("#view-train-button")
    page.wait_for_selector("#view-train .go:enabled")
    page.click("#view-train .go")
    page.wait_for_selector("#train-charts .js-plotly-plot")
    page.wait_for_selector("#view-train .status:has-text('Done')", timeout=600_000)
    page.click("#view-explore-button")
    page.wait_for_selector(".explore.ready")


def main(arguments: Sequence[str] | None = None) -> None:
    """Visit, and print the memory."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--minutes", type=float, default=30)
    parser.add_argument("--trainings", type=int, default=2)
    options = parser.parse_args(arguments)
    random, began, rounds = Random(3), time.monotonic(), 0
    with started() as (pid, address, _), chromium() as browser:

        def tell(words: str) -> None:
            spent = (time.monotonic() - began) / 60
            print(f"{spent:5.1f} min  {words:16} {resident_mb(pid):.0f} MB", flush=True)

        page = opened(browser, address, "?chapter=order")
        tell("first page")
        while time.monotonic() - began < 60 * options.minutes:
            rounds += 1
            chapters(page, random)
            tell(f"chapters {rounds}")
            own_pairs(page, random)
            tell(f"own pairs {rounds}")
            if rounds % 2 == 0 and rounds <= 2 * options.trainings:
                trained(page)
                tell(f"training {rounds // 2}")
        time.sleep(REST_S)
        tell("left")
        print(f"peak {resident_mb(pid, 'VmHWM'):.0f} MB")


if __name__ == "__main__":
    main()
