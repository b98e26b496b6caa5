"""Chapter 2, p and the gaps, in a real Chromium, used as a person uses it."""

import numpy as np
import pytest
import torch

from app.shared.places import places
from app.shared.resources import Resources
from omnivat import EXAMPLES, read_frames
from omnivat.maps.projection.neighbours import affine, placed_by
from omnivat.measure.gaps.unit import unit

from .gestures import ANSWERED, choose, go, grab, holds, p_shown, pixels, pull, settle

pytestmark = pytest.mark.browser
GAPS = "?chapter=gaps"
TREE = ".explore .tree-of-pair"
# positions on the map in CSS pixels: the photo, the touch and the nodes of the chosen pair
MARKS = """async () => {
  const { map } = await import(new URL('omnivat/web/explore/maps.js', document.baseURI));
  return map.extras();
}"""
ROW = ".explore .gap-row.{} output"


@pytest.fixture(scope="module")
def frames():
    """Return the shipped frames of the head of the chapters."""
    return read_frames(EXAMPLES / "frames.bin")


@pytest.fixture
def gaps(visit):
    """Return the chapter with its pair and tree."""
    return visit(GAPS, TREE)


def marks(page):
    """Return where the marks of the pair are, once nothing glides."""
    settle(page)
    return np.array(page.evaluate(MARKS))


def figures(page):
    """Return both gaps as they stand beside their bars."""
    return [float(page.inner_text(ROW.format(name))) for name in ("modality_gap", "domain_gap")]


def test_one_click_and_one_drag_move_points_both_gaps_the_pair_and_seven_stars(visited, frames):
    page = visited
    page.click(".explore .chapters [data-chapter=gaps]")
    page.wait_for_selector(TREE)
    before = pixels(page), marks(page), figures(page), page.inner_html(TREE)
    assert before[1].shape == (9, 2) and np.isfinite(before[1]).all()
    box = grab(page)
    pull(page, box, 0.8)
    page.mouse.up()
    after = pixels(page), marks(page), figures(page), page.inner_html(TREE)
    assert all(np.any(new != old) for new, old in zip(after, before, strict=True))
    assert (np.hypot(*(after[1] - before[1]).T) > 1).all()  # each of the nine marks
    stop = int(np.argmin(np.abs(np.array(frames.orders) - float(p_shown(page)))))
    for name, shown in zip(("modality_gap", "domain_gap"), after[2], strict=True):
        assert shown == pytest.approx(frames.curves[f"{name}/f_hat"][stop], abs=0.0051)
    assert page.locator(f"{TREE} polygon").count() == 7
    assert float(page.get_attribute(".explore .map", "data-order")) == float(p_shown(page))


def test_the_answer_follows_the_head_and_a_link_brings_head_and_set_back(gaps):
    words = gaps.inner_text(".explore .stage .figure")
    assert words.startswith("No: the steps")
    options = gaps.eval_on_selector_all(".of-head option", "all => all.map((one) => one.value)")
    assert options == ["", "retrained", "every", "chirps/moved", "chirps/retrained", "chirps/every"]
    said = {words}
    for by in ("retrained", "chirps/moved"):
        gaps.select_option(".explore .of-head", by)
        gaps.wait_for_function(
            "was => document.querySelector('.explore .stage .figure').innerText !== was", arg=words
        )
        settle(gaps)
        words = gaps.inner_text(".explore .stage .figure")
        said.add(words)
        assert f"by={by.replace('/', '%2F')}" in gaps.url
    assert len(said) == 3 and "chirp" in gaps.inner_text(".explore .chosen")
    link = gaps.url
    go(gaps, GAPS)
    go(gaps, link)
    gaps.wait_for_selector(f"{TREE} [aria-label*=chirp]")
    assert gaps.inner_text(".explore .stage .figure") == words


def test_a_step_opens_its_map_and_a_point_becomes_the_pair(gaps):
    steps = gaps.locator(".explore .gap-steps [role=radio]")
    assert steps.count() == 6
    for step in steps.all():
        assert "modality gap 0." in step.get_attribute("aria-label")
    drawn, shown = pixels(gaps), figures(gaps)
    steps.first.click()
    settle(gaps)
    assert pixels(gaps) != drawn and figures(gaps) != shown
    assert "stage=raw" in gaps.url and marks(gaps).shape == (2, 2)  # its nodes are on the last map
    steps.last.click()
    gaps.focus(".explore .map canvas + canvas")
    gaps.keyboard.press("n")
    gaps.keyboard.press("Enter")
    gaps.wait_for_function("location.search.includes('vis=row')")
    settle(gaps)
    assert marks(gaps).shape == (9, 2)
    said = gaps.locator(".explore .announcement")
    gaps.wait_for_function(
        "document.querySelector('.explore .announcement').textContent.includes('pair 0')"
    )
    assert all(word in said.text_content() for word in ("modality gap 0.", "domain gap 0.", "wood"))


def test_a_node_lights_up_in_the_tree_and_on_the_map(gaps):
    where = marks(gaps)[2:]
    box = gaps.locator(".explore .map").bounding_box()
    apart = [
        i
        for i, one in enumerate(where)
        if min(np.hypot(*(one - two)) for j, two in enumerate(where) if j != i) > 30
    ]
    node = apart[0]
    gaps.mouse.move(box["x"] + where[node][0], box["y"] + where[node][1])
    gaps.wait_for_selector(f"{TREE} [data-node='{node}'].lit")
    gaps.mouse.move(box["x"] + 5, box["y"] + 200)
    gaps.wait_for_function("!document.querySelector('.tree-of-pair .lit')")
    dark = gaps.evaluate("document.querySelectorAll('.explore .map canvas')[1].toDataURL()")
    gaps.focus(f"{TREE} [data-node='0']")
    lit = gaps.evaluate("document.querySelectorAll('.explore .map canvas')[1].toDataURL()")
    assert lit != dark
    label = gaps.get_attribute(f"{TREE} [data-node='0']", "aria-label")
    assert label.startswith("Node 1 alone predicts")


# remembers where the marks are in each frame of the screen
WATCH = f"""async () => {{
  window.seen = new Set();
  const look = async () => {{
    window.seen?.add(JSON.stringify(await ({MARKS})()));
    if (window.seen) requestAnimationFrame(look);
  }};
  await look();
}}"""


def test_without_motion_the_points_are_at_the_next_stop_at_once(gaps):
    gaps.emulate_media(reduced_motion="reduce")
    marks(gaps)
    gaps.evaluate(WATCH)
    gaps.focus(".explore .order")
    gaps.keyboard.press("ArrowRight")
    marks(gaps)
    assert gaps.evaluate("[window.seen.size, window.seen = null][0]") == 2
    gaps.emulate_media(reduced_motion="no-preference")


PICTURES = EXAMPLES / "pairs" / "TQ-DIGIT-sim" / "wood"


def send_pair(page):
    """Choose a photo and a touch as files; return their paths."""
    vis = sorted(PICTURES.glob("*_vis.jpg"))[0]
    files = {"vis": vis, "tac": vis.with_name(vis.name.replace("_vis", "_tac"))}
    for modality, file in files.items():
        choose(page, modality, file)
        holds(page, modality, file.name)
        page.wait_for_selector(ANSWERED)
    return files


def expected(files, frames):
    """Return a function of a stop: where the library places two pictures and their nodes there,
    (9, 2), map units.
    """
    resources, rows = Resources(places()), []
    for modality, file in files.items():
        ref, _ = resources.take_image(file.read_bytes(), file.name)
        rows.append(torch.from_numpy(resources.embedding(ref, modality).copy())[None])
    model, pairs = resources.head().model, resources.embeddings()
    images = [torch.from_numpy(np.array(a, np.float32)) for a in (pairs.vis, pairs.tac)]

    @torch.no_grad()
    def at(stop):
        order = frames.orders[stop]
        whole, out = model(*images, order=order), model(*rows, order=order, nodes=True)
        tree = torch.stack(list(out.f_bar.values())).mean(0)
        queries = unit(torch.cat([*out.f_hat.values(), tree + out.nodes[0]]))
        drawn = frames.maps["umap/f_hat"]
        flat = torch.from_numpy(drawn.places(drawn.orders.index(stop))).double()
        points = unit(torch.cat(list(whole.f_hat.values()))).double()
        return placed_by(affine(points, flat), queries, points, flat).numpy()

    return at


def test_two_own_pictures_are_read_at_every_p_and_shown_where_the_library_places_them(
    visit, frames
):
    page = visit("?view=pair", ANSWERED)
    files = send_pair(page)
    if not page.is_visible(".pair .what-if-p .order"):
        page.click(".pair .what-if-p summary")
    seen = []
    for share in (0.1, 0.5, 0.9):
        box = grab(page, share, ".pair .what-if-p .order")
        pull(page, box, share)
        page.mouse.up()
        settle(page)
        seen.append(
            (
                page.inner_text(".pair .at-p"),
                page.inner_html(".pair .tree-now"),
                page.get_attribute(".pair .spectra .cursor", "style"),
                pixels(page, ".pair .still"),
            )
        )
    assert all(len(set(part)) == 3 for part in zip(*seen, strict=True))
    assert "trained on GelSight (TAG) alone" in page.inner_text(".pair .about-p")
    page.click(".pair .on-map [data-send=everyP]")
    page.wait_for_selector(TREE)
    settle(page)
    assert page.url.count("image%3A") == 2
    assert "Your pair" in page.inner_text(".explore .chosen")
    assert "Linear maps" in page.inner_text(".explore .chosen")
    box = grab(page)
    before = marks(page)
    wanted_at = expected(files, frames)
    for share in (0.1, 0.8):
        pull(page, box, share)
        now = marks(page)
        assert (np.hypot(*(now - before).T) > 0.5).sum() > 6  # both images and nodes move
        before = now
        order = float(page.get_attribute(".explore .map", "data-order"))
        wanted = wanted_at(int(np.argmin(np.abs(np.array(frames.orders) - order))))
        found = page.evaluate(
            """async (wanted) => {
                 const url = (name) => new URL(`omnivat/web/${name}`, document.baseURI);
                 const { scene } = await import(url('explore/root.js'));
                 const { map } = await import(url('explore/maps.js'));
                 const { places, nodes } = scene.chosen.journey.maps.umap;
                 const at = scene.stop;
                 return { sent: [places.vis[at], places.tac[at], ...nodes[at]],
                          drawn: wanted.map((place) => map.spot(place)) };
               }""",
            wanted.tolist(),
        )
        np.testing.assert_allclose(found["sent"], wanted, atol=1e-3)
        np.testing.assert_allclose(now, found["drawn"], atol=0.2)  # pixels
    page.mouse.up()
