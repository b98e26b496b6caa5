"""The page as a folder, served by a plain file server, in a real Chromium."""

import threading
from collections.abc import Iterator
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any
from urllib.parse import quote

import pytest

from app.places import shipped_places
from app.site import export_site
from app.site_models import files_in
from omnivat.errors import OmniVatError

pytestmark = pytest.mark.browser
FOLDER = "Kurs é 100% #1"


class Quiet(SimpleHTTPRequestHandler):
    """`python -m http.server` without its log."""

    def log_message(self, *_: Any) -> None:
        """Write nothing."""


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[str, Path]]:
    """Return the address of the chirps' site in a folder of an odd name, and the folder."""
    root = tmp_path_factory.mktemp("served")
    out = root / "lab" / FOLDER
    try:
        export_site(shipped_places("chirps"), out, sets=())
    except OmniVatError as error:  # no npm here, or no network: the runtime cannot be fetched
        pytest.skip(str(error))
    server = ThreadingHTTPServer(("127.0.0.1", 0), partial(Quiet, directory=str(root)))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    yield f"http://127.0.0.1:{server.server_port}/lab/{quote(FOLDER)}/", out
    server.shutdown()
    server.server_close()


def test_a_plain_file_server_is_enough_for_p_tree_compare_and_a_pair_by_its_address(
    chromium: Any, site: tuple[str, Path]
) -> None:
    address, folder = site
    page = chromium.new_page(viewport={"width": 1440, "height": 900})
    problems: list[str] = []
    sizes: list[int] = []
    page.on("pageerror", lambda error: problems.append(str(error)))
    page.on("console", lambda said: said.type == "error" and problems.append(said.text))
    page.on(
        "request", lambda r: r.url.startswith((address, "data:", "blob:")) or problems.append(r.url)
    )
    page.on("response", lambda r: sizes.append(int(r.headers.get("content-length") or 0)))
    page.set_default_timeout(60_000)

    page.goto(address)
    page.wait_for_selector(".explore.ready")
    assert sum(sizes) < 3e6
    before = page.inner_text(".explore .figure")
    for _ in range(4):
        page.press(".explore .order", "ArrowRight")
    page.wait_for_selector(f".explore .figure:not(:text-is('{before}'))")

    page.click("#view-tree-button")
    page.wait_for_selector(".tree .tree-view .disc")
    page.wait_for_selector(".tree .where-note:has-text('pairs')")
    page.click("#view-compare-button")
    page.wait_for_selector(".compare .sides canvas >> nth=0")
    page.wait_for_selector(".compare .scores td", state="attached")
    page.click("#view-train-button")
    page.wait_for_selector(".train .problem:has-text('python app.py')")

    picture = next(
        file for file in files_in(folder) if "-example-" in file.name and "vis" in file.name
    )
    page.goto(f"{address}?tab=pair&vis=data/{picture.name}&tac=https://else.where/a.png")
    page.wait_for_selector(".pair .reading[data-reading=vis] .said")
    assert "not on this page's host" in page.inner_text(".pair .problem")
    assert picture.name in page.url
    page.close()
    assert problems == []
