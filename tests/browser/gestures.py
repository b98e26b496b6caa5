"""Shared by journeys: gestures, pictures to upload, and the state of the map."""

from io import BytesIO

import numpy as np
from PIL import Image

MAP = ".explore .map[data-order]"
ANSWERED = ".pair .results[aria-busy=false] .reading"
MOVED = "?chapter=analyse&mode=moved"  # the workbench, frames of one head at every stop
TOOLS = "?chapter=analyse"
TOUCH, WHERE = "?chapter=touch", "?chapter=where"
COLOURS = {"runOnly": ["color-contrast"]}  # what alone differs between light and dark
SLOT = '.pair .slot[data-modality="{}"]'
READY = {  # what each tab shows once it is there
    "explore": ".ov.explore.ready",
    "pair": ANSWERED,
    "train": "#train-charts .js-plotly-plot",
}


def settle(page):
    """Wait until every reply of the server, and what follows from it, has come to the page."""
    page.wait_for_selector("body[data-ready]")


def go(page, query):
    """Go to another address of the page without loading it again, as the browser's Back does."""
    page.evaluate(
        "to => { history.pushState(null, '', to); dispatchEvent(new PopStateEvent('popstate')); }",
        query,
    )
    settle(page)


def plan(page, epochs):
    """Set Train here to a small head that no text guides."""
    page.wait_for_selector("#view-train .go:enabled")
    page.click("#view-train .advanced > button")
    page.get_by_label("D, width").click()
    page.get_by_role("option", name="16", exact=True).click()
    page.fill("#train-epochs input", str(epochs))
    page.uncheck("#train-lang input")


def texture(seed):
    """Return a picture as a file to upload."""
    random = np.random.default_rng(seed)
    with BytesIO() as handle:
        Image.fromarray(random.integers(0, 255, (96, 96, 3), dtype=np.uint8)).save(handle, "PNG")
        return {"name": f"{seed}.png", "mimeType": "image/png", "buffer": handle.getvalue()}


def choose(page, modality, file):
    """Choose a file as photo or touch."""
    page.set_input_files(f"{SLOT.format(modality)} input[type=file]", file)


def holds(page, modality, words):
    """Wait until a slot says this of its picture."""
    page.wait_for_selector(f"{SLOT.format(modality)} .what:has-text({words!r})")


def send(page, modality, seed):
    """Choose a picture of noise as photo or touch and wait for its prediction."""
    choose(page, modality, texture(seed))
    holds(page, modality, f"{seed}.png")
    page.wait_for_selector(ANSWERED)


def pixels(page, of=".explore .map"):
    """Return the map's points as they are drawn now, once drawing has settled."""
    return page.evaluate(
        """of => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() =>
             done(document.querySelector(of + ' canvas').toDataURL()))))""",
        of,
    )


def place_of_a_point(page):
    """Return the position of some point on the page: hover until the card shows a pair."""
    box = page.locator(".explore .map").bounding_box()
    for share in np.linspace(0.3, 0.7, 9):
        for height in np.linspace(0.3, 0.7, 9):
            at = box["x"] + share * box["width"], box["y"] + height * box["height"]
            page.mouse.move(*at)
            if "Pair" in page.inner_text(".explore .card h3"):
                return at
    raise AssertionError("no point was found on the map")


def grab(page, share=0.5, of=".explore .order"):
    """Press the mouse on the slider at a share of its length; return its box."""
    page.locator(of).scroll_into_view_if_needed()
    box = page.locator(of).bounding_box()
    page.mouse.move(box["x"] + share * box["width"], box["y"] + box["height"] / 2)
    page.mouse.down()
    return box


def pull(page, box, share, steps=8):
    """Move the pressed mouse along the slider to a share of its length."""
    page.mouse.move(box["x"] + share * box["width"], box["y"] + box["height"] / 2, steps=steps)


def open_tab(page, view):
    """Open a tab of the page at any width."""
    button = f"#view-{view}-button"
    page.wait_for_selector(button, state="attached")  # Explore is there before Gradio's tabs are
    page.eval_on_selector(button, "button => button.click()")
    page.wait_for_selector(f".ov.{view}:visible")


def p_shown(page):
    """Return the p that Explore shows, in figures."""
    return page.inner_text(".explore .order-value")


def faults(page, options=None, of="html"):
    """Return the axe audit's findings for a part of the page as it is now."""
    from axe_playwright_python.base import AXE_SCRIPT

    if not page.evaluate("'axe' in window"):
        page.evaluate(AXE_SCRIPT)
    found = page.evaluate(
        """async ([of, options]) => {
          const moving = document.getAnimations().filter((one) => one instanceof CSSTransition);
          await Promise.allSettled(moving.map((one) => one.finished));
          return axe.run(document.querySelector(of), options);
        }""",
        [of, options or {}],
    )
    return [
        f"{fault['id']}: {fault['help']}: {node['target']}"
        for fault in found["violations"]
        for node in fault["nodes"]
    ]
