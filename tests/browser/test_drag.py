"""Dragging p: handled in the browser, exact at every stop, during any other activity."""

from dataclasses import replace
from urllib.parse import parse_qsl, urlsplit

import pytest

from app.shared.frame_parts import part_of
from omnivat.head.heads import EXAMPLES, default_embeddings, default_head
from omnivat.maps.frames import read_frames, write_frames

from .gestures import MAP, grab, open_tab, p_shown, pixels, pull, settle

pytestmark = pytest.mark.browser

STOPS = (37, 100)  # between whole orders, and at one
STAGES = ("relu", "f_hat")
READ = """async ({ stops, stages }) => {
  const { fetchFrames } = await import(new URL('omnivat/web/shared/frames.js', document.baseURI));
  const { featuresOf } = await import(new URL('omnivat/web/shared/stages.js', document.baseURI));
  const { frames } = await fetchFrames(() => {});
  const maps = stages.map((stage) => frames.meta.maps[`pca/${featuresOf(stage)}`].array);
  for (const part of [...maps, 'confidence']) await frames.load(part);
  const place = (map, point) => {
    const [[x0, y0], [x1, y1]] = map.bounds;
    return [x0 + map.points[2 * point] / 65535 * (x1 - x0),
      y0 + map.points[2 * point + 1] / 65535 * (y1 - y0)];
  };
  return stops.map((stop) => ({
    order: frames.orders[stop],
    prediction: [...frames.prediction.subarray(stop * frames.pairs, (stop + 1) * frames.pairs)],
    confidence: [...frames.confidence.subarray(stop * frames.pairs, (stop + 1) * frames.pairs)],
    gap: frames.meta.curves['modality_gap/f_hat'][stop],
    maps: Object.fromEntries(stages.map((stage) => {
      const map = frames.positions('pca', stage, stop);
      return [stage, { drawn: map.drawn, places: Array.from({ length: 2 * frames.pairs }, (_,
        i) => place(map, i)) }];
    })),
  }));
}"""


def test_a_drag_asks_nothing_of_the_server_and_the_figures_are_those_of_its_stop(visit):
    frames = read_frames(EXAMPLES / "frames.bin")
    page = visit("?mode=moved&map=pca&vis=row:0&tac=row:0", MAP)
    for view, shown in (("pair", ".reading"), ("explore", ".map")):
        open_tab(page, view)
        page.wait_for_selector(f".{view} {shown}")
        if view != "explore":  # the place on the map comes last
            page.wait_for_selector(f".{view} .where-note:has-text('Click a point')")
    page.wait_for_load_state("networkidle")
    asked = []
    page.on("request", lambda request: asked.append(request.url))
    before = pixels(page)
    box = grab(page)
    for share in (0.9, 0.1, 0.6):
        pull(page, box, share, steps=15)
    assert pixels(page) != before
    page.mouse.up()
    page.wait_for_function("location.search.includes('p=0.')")
    assert asked == []
    gaps = {
        f"{p:.2f}": gap
        for p, gap in zip(frames.orders, frames.curves["modality_gap/f_hat"], strict=True)
    }
    shown = page.inner_text(".explore .curves figure[data-name=modality_gap] output")
    assert shown == f"{gaps[p_shown(page)]:.3f}"


def test_every_stop_is_what_the_library_computes_now(visit):
    """The browser's own decoding against the head run again, not against the file."""
    import torch

    from omnivat.data.store import load_embeddings
    from omnivat.head.checkpoint import load_head
    from omnivat.maps.frames.builder import stacked
    from omnivat.maps.projection import pca
    from omnivat.maps.projection.torch_umap import aligned
    from omnivat.maps.sweep import walk

    page = visit("?chapter=analyse", MAP)
    decoded = page.evaluate(READ, {"stops": STOPS, "stages": STAGES})
    frames = read_frames(EXAMPLES / "frames.bin")
    head, embeddings = load_head(default_head()), load_embeddings(default_embeddings())
    orders = [frames.orders[stop] for stop in STOPS]
    with torch.inference_mode():
        for found in walk(head.model, embeddings, orders, stages=STAGES, predictions=True):
            seen = decoded[found.index]
            assert seen["order"] == found.order
            sure, answer = found.probabilities["fused"].max(1)
            close = torch.tensor(seen["confidence"]) / 255 - sure
            assert close.abs().max() <= 0.5 / 255 + 1e-4
            ties = sure < 0.5 + 1e-3  # only there may rounding change which class is first
            assert ((torch.tensor(seen["prediction"]) == answer) | ties).all()
            for stage in STAGES:
                map_ = seen["maps"][stage]
                assert map_["drawn"] == STOPS[found.index]
                exact = pca.project(stacked(found.features[stage])).double()
                drawn = torch.tensor(map_["places"], dtype=torch.float64)
                off = (aligned(exact, drawn) - drawn).norm(dim=1).max()
                assert off <= 2 * frames.maps[f"pca/{stage}"].max_error


def thinned(frames, every):
    """Return the same set at fewer stops, like the first, coarse frames."""
    kept = list(range(0, len(frames.orders), every))
    maps = {}
    for name, one in frames.maps.items():
        at = [i for i, stop in enumerate(one.orders) if stop in kept]
        orders = tuple(kept.index(one.orders[i]) for i in at)
        maps[name] = replace(one, points=one.points[at], orders=orders)
    return replace(
        frames,
        orders=tuple(frames.orders[i] for i in kept),
        prediction=frames.prediction[kept],
        confidence=frames.confidence[kept],
        maps=maps,
        curves={
            name: [values[i] for i in kept] if len(values) == len(frames.orders) else values
            for name, values in frames.curves.items()
        },
    )


COARSE = [f"{stop / 10:.2f}" for stop in range(11)]


def test_finer_frames_take_the_place_of_coarse_ones_in_the_middle_of_a_drag(
    new_page, address, tmp_path
):
    write_frames(tmp_path / "coarse.bin", thinned(read_frames(EXAMPLES / "frames.bin"), 10))
    page = new_page()
    ready = []

    def answer(route):
        if "progress" in route.request.url:
            step = None if ready else {"done": 40, "total": 101, "text": "map at order 0.40"}
            route.fulfill(status=202, json={"step": step, "ready": True})
        elif ready:
            route.fallback()
        else:
            wanted = dict(parse_qsl(urlsplit(route.request.url).query))
            part = part_of(tmp_path / "coarse.bin", wanted["part"], int(wanted.get("from", 0)))
            route.fulfill(body=part, headers={"X-Frames": "coarse"})

    page.route("**/omnivat/frames*", answer)
    page.route(
        "**/omnivat/modes", lambda route: route.fulfill(json={"modes": ["moved"], "sets": []})
    )
    page.goto(address + "?mode=moved&map=pca&p=0.2", wait_until="commit")
    page.wait_for_selector(MAP)
    page.wait_for_selector("#omnivat-first", state="detached")
    box = grab(page, 0.2)
    pull(page, box, 0.43)
    assert p_shown(page) == "0.40" in COARSE
    page.wait_for_selector(".explore .wait:has-text('40 of 101')")
    ready.append(True)
    page.wait_for_selector(".explore .wait", state="hidden")
    for at in 50 * (0.66, 0.64):  # until the finer stops are those of the drag
        pull(page, box, at, steps=5)
        settle(page)
        pixels(page)
        if p_shown(page) not in COARSE:
            break
    assert p_shown(page) not in COARSE
    page.mouse.up()
    assert page.get_attribute(MAP, "data-order") == str(float(p_shown(page)))


AT_REST = """() => new Promise((done) => {
  let [before, still] = [-1, 0];
  const look = () => {
    still = scrollY === before ? still + 1 : 0;
    before = scrollY;
    still > 20 ? done() : requestAnimationFrame(look);
  };
  look();
})"""


def test_one_finger_scrolls_the_page_or_drags_p_and_two_pan_and_pinch_the_map(open_page):
    page = open_page("?mode=moved", MAP, size=(400, 800), has_touch=True, is_mobile=True)
    client = page.context.new_cdp_session(page)

    def swipe(*ways):
        for kind, part in [("Start", 0), *(("Move", k / 8) for k in range(1, 9)), ("End", None)]:
            fingers = [
                {"x": x + part * dx, "y": y + part * dy, "id": i}
                for i, (x, y, dx, dy) in enumerate(ways)
                if part is not None
            ]
            event = {"type": f"touch{kind}", "touchPoints": fingers}
            client.send("Input.dispatchTouchEvent", event)
        page.evaluate(AT_REST)  # a finger that leaves moving lets the page glide

    def middle(of):
        page.locator(f".explore {of}").scroll_into_view_if_needed()
        box = page.locator(f".explore {of}").bounding_box()
        return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2, box

    x, y, _ = middle(".map")
    still, scrolled = pixels(page), page.evaluate("scrollY")
    swipe((x, y, 0, -120))
    assert page.evaluate("scrollY") > scrolled + 40
    assert pixels(page) == still
    x, y, _ = middle(".map")
    scrolled = page.evaluate("scrollY")
    swipe((x - 30, y, 60, 20), (x + 30, y, 60, 20))
    panned = pixels(page)
    assert panned != still
    swipe((x - 30, y, -60, 0), (x + 30, y, 60, 0))
    assert pixels(page) != panned
    assert page.evaluate("scrollY") == scrolled  # the map took the gesture, not the page
    _, y, slider = middle(".order")
    before = float(p_shown(page))
    swipe((slider["x"] + slider["width"] * before, y, slider["width"] * (0.9 - before), 0))
    assert float(p_shown(page)) > 0.8
