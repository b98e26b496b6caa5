"""The page as a folder, served by a plain file server, in a real Chromium."""

import base64
import json
from contextlib import contextmanager
from io import BytesIO
from shutil import copyfile
from urllib.parse import quote

import pytest
import torch
from PIL import Image

from app.explore.tab import unseen
from app.pair.tab import attention, predicted
from app.shared.familiar import familiar
from app.shared.places import places, shipped_places
from app.shared.resources import Resources
from app.site.folder import export_site, whole_files
from app.site.models import files_in, pack, write_set
from benchmarks.site import served
from omnivat import (
    load_embeddings,
    load_encoder,
    load_head,
    measured,
    modality_gap,
    predict_embeddings,
    read_frames,
)
from omnivat.cli import main
from omnivat.kit.errors import OmniVatError

pytestmark = pytest.mark.browser
COUNT = """() => setInterval(async () => {
  const [name] = await caches.keys();
  globalThis.kept = name ? (await (await caches.open(name)).keys()).length : 0;
}, 100)"""
FOLDER = "Kurs é 100% #1"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Return the chirps' site, in a folder of an odd name inside the one that is served."""
    root = tmp_path_factory.mktemp("served")
    out = root / "lab" / FOLDER
    try:
        export_site(shipped_places("chirps"), out, sets=())
    except OmniVatError as error:  # no npm here, or no network: the runtime cannot be fetched
        pytest.skip(str(error))
    return out


@contextmanager
def site(folder):
    """Yield the site's address."""
    with served(folder.parents[1]) as address:
        yield f"{address}lab/{quote(FOLDER)}/"


def visit(context):
    """Return a page, and a list of its errors."""
    page = context.new_page()
    problems = []
    page.on("pageerror", lambda error: problems.append(str(error)))
    page.on("console", lambda said: said.type == "error" and problems.append(said.text))
    return page, problems


def test_a_plain_file_server_is_enough_for_p_nodes_a_second_map_and_a_pair_by_its_address(
    desktop, folder
):
    with site(folder) as address:
        chapters_analyse_and_a_pair(desktop, address, folder)


def chapters_analyse_and_a_pair(context, address, folder):
    page, problems = visit(context)
    sizes, asked = [], []
    page.on("request", lambda r: asked.append(r.url))
    page.on(
        "request", lambda r: r.url.startswith((address, "data:", "blob:")) or problems.append(r.url)
    )
    page.on("response", lambda r: sizes.append(int(r.headers.get("content-length") or 0)))

    page.goto(address)
    page.wait_for_selector(".explore.ready")
    assert sum(sizes) < 3e6
    page.wait_for_selector(".explore .twin .said")
    page.click('.explore .chapters [data-chapter="order"]')
    page.wait_for_selector(".explore .stage .figure b")
    before = page.inner_text(".explore .stage .figure")
    for _ in range(4):
        page.press(".explore .order", "ArrowRight")
    page.wait_for_selector(f".explore .stage .figure:not(:text-is('{before}'))")

    page.goto(f"{address}?chapter=analyse&pin=3&beside=1&head2=method:nearest_mean")
    assert page.evaluate("document.scrollingElement.scrollWidth <= innerWidth")
    page.click(".explore [data-panel=nodes] summary")
    page.wait_for_selector(".explore .nodes .disc >> nth=6")
    page.wait_for_selector(".explore .changed:has-text('predictions change')")
    page.press("#view-explore-button", "ArrowLeft")
    page.wait_for_selector("#view-train-button:focus")
    page.wait_for_selector("#view-train .problem:has-text('python app.py')")

    picture = next(
        file for file in files_in(folder) if "-example-" in file.name and "vis" in file.name
    )
    page.goto(f"{address}?view=pair&vis=data/{picture.name}&tac=https://else.where/a.png")
    page.wait_for_selector(".pair .reading[data-reading=vis] .said")
    assert "not on this page's host" in page.inner_text(".pair .problem")
    assert picture.name in page.url
    page.wait_for_selector("body:not(.fetching)")
    encoder = next(i for i, url in enumerate(asked) if "/encoder-" in url)
    assert sum("-example-" in url for url in asked[:encoder]) <= 32  # the shelf shows 15 pairs
    page.wait_for_selector(".gallery button:nth-child(40) img >> nth=0", state="visible")
    page.close()
    assert problems == []


def test_a_first_own_pair_needs_less_than_30_mb_and_a_site_of_both_sets_less_than_60(
    folder, tmp_path, monkeypatch
):
    def as_large(file, head):  # its weights, as an export takes seconds
        copyfile(head.path / "weights.safetensors", file)

    monkeypatch.setattr("omnivat.head.portable.write_head", as_large)
    resources = Resources(places())
    write_set(resources, tmp_path / "sensors")
    for file in files_in(tmp_path):
        pack(file)

    def megabytes(files):
        return sum(file.stat().st_size for file in files) / 1e6

    def models(file):
        return file.relative_to(folder).parts[0].startswith(("web", "models"))

    # scripts, runtime and programs, and the chirps' models
    page = megabytes(filter(models, files_in(folder)))
    own = megabytes(files_in(tmp_path))
    # of the head that reads no own picture
    later = megabytes(tmp_path.rglob("familiarity.safetensors.gz"))
    facts = whole_files(resources, lambda _: None)
    seen = megabytes(facts[name] for name in ("/frames", "/thumbnails.webp"))
    assert page + own - later + seen < 30
    assert megabytes(files_in(folder)) + own + megabytes({*facts.values()}) < 60


def test_after_one_visit_the_site_predicts_an_own_pair_without_a_network(chromium, folder):
    kept = sum(len(file.relative_to(folder).parts) > 1 for file in files_in(folder))
    pictures = [file for file in files_in(folder) if "-example-" in file.name]
    context = chromium.new_context()
    with site(folder) as address:
        page, problems = visit(context)
        page.goto(address)
        page.wait_for_selector(".explore.ready")
        page.evaluate(COUNT)
        page.wait_for_function("count => globalThis.kept === count", arg=kept + 1)  # and the page
        page.close()
        assert problems == []
    page, problems = visit(context)  # there is no server now
    page.goto(f"{address}?view=pair&p=0.3")
    for modality in ("vis", "tac"):
        picture = next(file for file in pictures if modality in file.name)
        page.set_input_files(f".slot[data-modality={modality}] input", picture)
        page.wait_for_selector(f".slot[data-modality={modality}] img[src^='blob:']")
    for reading in ("fused", "vis", "tac"):
        page.wait_for_selector(f".pair .reading[data-reading={reading}] .said")
    assert page.evaluate("crossOriginIsolated")
    context.close()
    assert problems == []


FIGURES = """async ([web, p, ...pictures]) => {
  const shared = (name) => import(new URL(`${web}/shared/${name}.js`, document.baseURI));
  const [{ ask, json, hold }, { fetchFrames }, { values }] =
    await Promise.all(["api", "frames", "measures"].map(shared));
  const [vis, tac] = await Promise.all(pictures.map(async (text) => {
    const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
    return hold(new Blob([bytes]), "a picture");
  }));
  const { frames } = await fetchFrames(() => {});
  const gap = values(frames, "modality_gap", "f_hat")[frames.orders.indexOf(p)];
  const more = await Promise.all([ask("familiar", { vis, tac }), ask("attention", { vis, tac })]);
  return [await json("unseen"), await ask("pair", { vis, tac }), gap, ...more];
}"""


def accuracies_of(record):
    return {row["domain"]: row["scores"]["fused"]["accuracy"] for row in record["domains"]}


def cosines(image):
    return [near["cosine"] for near in image["nearest"]]


def test_python_the_commands_the_page_and_the_site_give_the_same_figures(desktop, folder, capsys):
    """Accuracy in each unseen domain, probabilities of two pictures, the modality gap at F̂; and of
    the last two the nearest pairs and the attention.
    """
    where = shipped_places("chirps")
    head, embeddings = load_head(where.head), load_embeddings(where.embeddings)
    resources, encoder = Resources(where), load_encoder("strip")
    files = [*next(iter(resources.examples().values())).values()]
    pictures = [file.read_bytes() for file in files]
    with torch.inference_mode():
        photos, touches = torch.from_numpy(embeddings.vis), torch.from_numpy(embeddings.tac)
        hats = head.model(photos, touches).f_hat
        rows = [encoder.embed(encoder.preprocess(Image.open(BytesIO(p)))[None]) for p in pictures]
    python = [
        accuracies_of(measured(head, embeddings)),
        [*predict_embeddings(head, *rows)[0]["probabilities"].values()],
        float(modality_gap(hats["vis"], hats["tac"])),
    ]

    def command(name, *more):
        assert main([name, "--head", str(where.head), "--json", *map(str, more)]) == 0
        return json.loads(capsys.readouterr().out)

    commands = [
        accuracies_of(command("evaluate", "--embeddings", where.embeddings)),
        [*command("predict", *files)["probabilities"].values()],
        command("gaps", "--embeddings", where.embeddings)["modality_gap"]["all"],
    ]

    def on_screen(unseen, pair, gap):
        accuracies = {row["name"]: row["answers/fused"]["share"] for row in unseen["domains"]}
        return [accuracies, pair["exact"]["readings"]["fused"], gap]

    vis, tac = (str(resources.take_image(content, "a picture")[0]) for content in pictures)
    frames = read_frames(where.frames)
    gaps = dict(zip(frames.orders, frames.curves["modality_gap/f_hat"], strict=True))
    asked = {"vis": vis, "tac": tac}
    reply = predicted(resources, asked)
    page = on_screen(unseen(resources), reply, float(gaps[head.model.order]))

    with site(folder) as address:
        tab, problems = visit(desktop)
        tab.goto(f"{address}?view=pair")
        tab.wait_for_selector(".pair .reading .said")
        encoded = [base64.b64encode(content).decode() for content in pictures]
        web = next(folder.glob("web-*")).name
        *found, looked, attended = tab.evaluate(FIGURES, [web, head.model.order, *encoded])
        in_browser = on_screen(*found)
    assert problems == []
    for accuracies, probabilities, gap in (commands, page, in_browser):
        for name, accuracy in python[0].items():
            assert accuracies[name] == pytest.approx(accuracy, abs=1e-6)
        assert probabilities == pytest.approx(python[1], abs=0.001)
        assert gap == pytest.approx(python[2], abs=1e-4)
    for image, wanted in familiar(resources, asked)["images"].items():
        assert cosines(looked["images"][image]) == pytest.approx(cosines(wanted), abs=0.01)
    assert attended["scale"] == pytest.approx(attention(resources, asked)["scale"], rel=0.01)
