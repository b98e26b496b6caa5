"""One real Chromium and one real server for all journeys."""

import json
import os
import shutil
import socket
import subprocess
import sys
import time
from contextlib import contextmanager, suppress
from pathlib import Path
from urllib.request import Request, urlopen

import pytest

from .fake_sensor import FakeSensor
from .gestures import go

ROOT = Path(__file__).resolve().parents[2]
# the shell is Chromium without its own window, and takes 40 % less of the processor
BROWSERS = ("chromium-headless-shell", "chromium", "chromium-browser", "google-chrome")
FLAGS = [
    "--no-sandbox",
    "--disable-gpu",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--no-first-run",
    "--use-fake-device-for-media-stream",
    "--use-fake-ui-for-media-stream",
    "--host-resolver-rules=MAP demo.example 127.0.0.2",
]
PANELS = """localStorage['omnivat-panels'] ??= JSON.stringify(Object.fromEntries(
  ['card', 'grid', 'domains', 'confusion', 'filters', 'curves', 'raw', 'step', 'toy']
    .map((name) => [name, true])))"""
PATIENCE_MS = 150_000  # a journey fails by what it reads, not by the time
DESK = {"viewport": {"width": 1440, "height": 900}}


def patient(make):
    """Return a maker of pages or profiles that wait as long as a busy machine takes."""

    def made(**options):
        target = make(**options)
        target.set_default_timeout(PATIENCE_MS)
        return target

    return made


OPEN = []  # pages of the test that runs
SHOWN = """() => [location.search, 'ready' in document.body.dataset ? 'ready' : 'not ready',
  ...[...document.querySelectorAll('h4, .wait, .hint, .problem, .status, .announcement')]
    .map((one) => one.innerText.trim()).filter(Boolean)].join('\\n').slice(0, 3000)"""


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item, call):
    """Add to the report of a failed journey what its pages show and which replies are missing."""
    report = yield
    if report.when == "call" and report.failed:
        for page in OPEN:
            with suppress(Exception):  # of a page that is closed or has crashed
                shown = [page.evaluate(SHOWN), "without a reply:", *page.unanswered]
                report.sections.append(("page", "\n".join(shown)))
    return report


@pytest.fixture(autouse=True)
def no_page_of_another_test():
    """Forget the pages of the test before."""
    OPEN.clear()


def missing(what):
    """Skip without a browser; in CI, fail."""
    if os.environ.get("CI"):
        pytest.fail(f"{what}; CI has to run the browser tests.")
    pytest.skip(f"{what}; install it with `apt-get install chromium`.")


@pytest.fixture(scope="session")
def sensor(tmp_path_factory):
    """Return what Chromium's fake camera sees."""
    return FakeSensor(tmp_path_factory.mktemp("sensor") / "frames.y4m")


@pytest.fixture(scope="session")
def chromium(sensor):
    """Return a running Chromium."""
    binary = next((path for name in BROWSERS if (path := shutil.which(name))), None)
    if binary is None:
        missing("No Chromium was found")
    playwright = pytest.importorskip("playwright.sync_api")
    with playwright.sync_playwright() as player:
        flags = [*FLAGS, f"--use-file-for-fake-video-capture={sensor.file}"]
        browser = player.chromium.launch(executable_path=binary, args=flags)
        for name in ("new_page", "new_context"):
            setattr(browser, name, patient(getattr(browser, name)))
        yield browser
        browser.close()


@pytest.fixture(scope="session")
def desktop(chromium):
    """Return the browser profile that most journeys share, so that scripts are fetched once."""
    context = chromium.new_context(**DESK)
    yield context
    context.close()


class Server:
    """`python app.py` on the project's own data, run in `folder`; it can be stopped and
    started again.
    """

    def __init__(self, folder, host="127.0.0.1", more=()):
        with socket.socket() as probe:
            probe.bind((host, 0))
            self.port = probe.getsockname()[1]
        self.address = f"http://{host}:{self.port}/"
        self.folder, self.more, self.script = folder, more, ROOT / "app.py"
        self.process = None

    def start(self):
        """Start and wait until the page answers."""
        with (self.folder / "log").open("a") as log:
            self.process = subprocess.Popen(
                [
                    sys.executable,
                    str(self.script),
                    "--no-browser",
                    "--port",
                    str(self.port),
                    *self.more,
                ],
                cwd=self.folder,
                env=os.environ | {"XDG_CACHE_HOME": str(self.folder), "PYTHONPATH": str(ROOT)},
                stdout=log,
                stderr=subprocess.STDOUT,
            )
        deadline = time.monotonic() + 180
        while True:
            try:
                with urlopen(self.address, timeout=30):
                    return
            except OSError:
                if self.process.poll() is not None or time.monotonic() > deadline:
                    pytest.fail(f"The page did not start:\n{self.log()}")
                time.sleep(0.05)

    def stop(self):
        """Stop at once, as a crash would."""
        if self.process:
            self.process.kill()
            self.process.wait()

    def log(self):
        """Return what the server has written."""
        return (self.folder / "log").read_text(encoding="utf-8")


@contextmanager
def running(*place, **more):
    """Start a server; it must not log a traceback."""
    server = Server(*place, **more)
    try:
        server.start()
        yield server
        assert "Traceback" not in server.log(), server.log()
    finally:
        server.stop()


@pytest.fixture(scope="session")
def server(tmp_path_factory):
    """Return one server for all journeys."""
    with running(tmp_path_factory.mktemp("server")) as server:
        yield server


@pytest.fixture(scope="session")
def address(server):
    """Return the page's address."""
    return server.address


@pytest.fixture
def posted(address):
    """Return a function that sends content to a path; it returns the server's reply, without the
    page.
    """

    def post(path, content):
        with urlopen(Request(f"{address}omnivat/{path}", data=content)) as reply:
            return json.load(reply)

    return post


@pytest.fixture
def loaded(posted):
    """Return a function that loads files of a head or set, as visitors do; it returns the name of
    what they make together, `?set=`.
    """

    def load(*files):
        parts = {one.name: posted(f"part?name={one.name}", one.read_bytes()) for one in files}
        parts = {name: reply["part"] for name, reply in parts.items()}
        return posted("load", json.dumps({"parts": parts}).encode())["set"]

    return load


def note(problems, said):
    """Record script errors; a refused request also counts as one, and is expected."""
    if said.type == "error" and not said.text.startswith("Failed to load resource"):
        problems.append(f"console: {said.text}")


def watched(page, address, problems):
    """Return the page; `problems` then gets failed scripts and requests that leave the machine.

    Whoever waits for an element also waits until nothing is on its way to the page, so that no
    journey reads too early; except where the journey itself holds replies back by `page.route`.
    """
    find, route = page.wait_for_selector, page.route

    def settled(selector, **options):
        found = find(selector, **options)
        if not page.held:
            find("body[data-ready]")
        return found

    def hold(*arguments, **options):
        page.held = True
        route(*arguments, **options)

    page.held, page.wait_for_selector, page.route = False, settled, hold
    page.unanswered = []
    page.on("request", lambda request: page.unanswered.append(request.url))
    for end in ("requestfinished", "requestfailed"):
        page.on(end, lambda request: page.unanswered.remove(request.url))
    OPEN.append(page)
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
    page.add_init_script(PANELS)  # journeys look into every panel of the workbench
    return page


def forget(page, address):
    """Forget what another journey left in the browser, such as its trainings."""
    kept = {"origin": address.rstrip("/"), "storageTypes": "local_storage"}
    page.context.new_cdp_session(page).send("Storage.clearDataForOrigin", kept)


@pytest.fixture
def new_page(chromium, desktop, address):
    """Return a maker of empty pages; afterwards checks that nothing went wrong unseen.

    Options, but not a size of the window (width, height), give the page a profile of its own.
    """
    pages = []
    problems = []

    def made(size=None, **options):
        page = chromium.new_page(**{**DESK, **options}) if options else desktop.new_page()
        if size:
            page.set_viewport_size(dict(zip(("width", "height"), size, strict=True)))
        if not pages:
            forget(page, address)
        pages.append(watched(page, address, problems))
        return page

    yield made
    for page in pages:
        page.close()
    assert problems == []


@pytest.fixture(scope="module")
def one_page(desktop, address):
    """Return the page of a file."""
    problems = []
    page = watched(desktop.new_page(), address, problems)
    forget(page, address)
    page.goto(address, wait_until="commit")
    page.wait_for_selector(".ov.explore.ready")
    yield page
    page.close()
    assert problems == []


@pytest.fixture
def visited(one_page):
    """Return one page for the journeys of a file, which go from address to address in it; with the
    window of a desk, whatever the journey before made of it.
    """
    one_page.held = False
    one_page.set_viewport_size(DESK["viewport"])
    one_page.emulate_media(media="screen", forced_colors="none")
    return one_page


@pytest.fixture
def visit(visited):
    """Return a function that goes to an address in the page of the file, and waits for what it
    shows.
    """

    def went(query, shows="body"):
        go(visited, query)
        visited.wait_for_selector(shows)
        return visited

    return went


@pytest.fixture
def open_page(new_page, address):
    """Return a function that opens the page in a tab of its own, and waits for what it shows."""

    def opened(query="", shows=None, **options):
        page = new_page(**options)
        page.goto(address + query, wait_until="commit")
        if shows:
            page.wait_for_selector(shows)
        return page

    return opened
