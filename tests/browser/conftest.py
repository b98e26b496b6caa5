"""A real Chromium and a real server, one of each for all journeys."""

import os
import shutil
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.request import urlopen

import pytest

ROOT = Path(__file__).resolve().parents[2]
BROWSERS = ("chromium", "chromium-browser", "google-chrome")
FLAGS = [
    "--no-sandbox",
    "--disable-gpu",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--no-first-run",
]


def missing(what: str) -> None:
    """Skip where a person has no browser; fail in CI, where one has to be."""
    if os.environ.get("CI"):
        pytest.fail(f"{what}; CI has to run the browser tests.")
    pytest.skip(f"{what}; install it with `apt-get install chromium`.")


@pytest.fixture(scope="session")
def chromium() -> Iterator[Any]:
    """Return a running Chromium."""
    binary = next((path for name in BROWSERS if (path := shutil.which(name))), None)
    if binary is None:
        missing("No Chromium was found")
    playwright = pytest.importorskip("playwright.sync_api")
    with playwright.sync_playwright() as player:
        browser = player.chromium.launch(executable_path=binary, args=FLAGS)
        yield browser
        browser.close()


@pytest.fixture(scope="session")
def address(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """Start `python app.py` on the project's own data; return its address."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    folder = tmp_path_factory.mktemp("server")
    log = (folder / "log").open("w+")
    server = subprocess.Popen(
        [sys.executable, "app.py", "--no-browser", "--port", str(port)],
        cwd=ROOT,
        env=os.environ | {"XDG_CACHE_HOME": str(folder)},
        stdout=log,
        stderr=subprocess.STDOUT,
    )
    try:
        url = f"http://127.0.0.1:{port}/"
        deadline = time.monotonic() + 90
        while True:
            try:
                with urlopen(url, timeout=30):
                    break
            except OSError:
                if server.poll() is not None or time.monotonic() > deadline:
                    log.seek(0)
                    pytest.fail(f"The page did not start:\n{log.read()}")
                time.sleep(0.05)
        yield url
        log.seek(0)
        assert "Traceback" not in log.read(), "the server logged a traceback during the journeys"
    finally:
        server.terminate()
        server.wait()
        log.close()


def note(problems: list[str], said: Any) -> None:
    """Keep what a script reports as an error; a refused request is one too, and expected."""
    if said.type == "error" and not said.text.startswith("Failed to load resource"):
        problems.append(f"console: {said.text}")


@pytest.fixture
def open_page(chromium: Any, address: str) -> Iterator[Any]:
    """Return a function that opens the page; afterwards checks that nothing went wrong unseen.

    Scripts must not fail, and no request may leave this machine.
    """
    pages, problems = [], []

    def opened(query: str = "", **options: Any) -> Any:
        page = chromium.new_page(**{"viewport": {"width": 1440, "height": 900}, **options})
        page.on("pageerror", lambda error: problems.append(f"script failed: {error}"))
        page.on("console", lambda said: note(problems, said))
        page.on(
            "request",
            lambda request: (
                None
                if request.url.startswith((address, "data:", "blob:"))
                else problems.append(f"outside request: {request.url}")
            ),
        )
        page.set_default_timeout(60_000)
        page.goto(address + query)
        pages.append(page)
        return page

    yield opened
    for page in pages:
        page.close()
    assert problems == []
