"""Starting the page: loaded modules, address, Gradio's settings."""

import socket
import subprocess
import sys
from pathlib import Path

import pytest

from app.serving.preflight import parser
from app.serving.server import LINES

ROOT = Path(__file__).resolve().parents[2]


def interpreter(code, *arguments):
    """Run code in a fresh interpreter beside the page's sources; return what it printed."""
    command = [sys.executable, "-c", code, *arguments]
    return subprocess.run(
        command, cwd=ROOT, capture_output=True, text=True, timeout=600, check=False
    )


RUNNING = """
import gc, inspect, json, sys, urllib.request
from http.client import HTTPConnection
from types import SimpleNamespace
from urllib.parse import urlsplit
from app.serving.guard import EVENTS
from app.serving.server import LINES, main


def create_window(title, address, **size):
    for path in ("", "web/explore/explore.js", "web/shared/page.css", "examples"):
        path = path and f"omnivat/{path}"
        with urllib.request.urlopen(address + path) as answer:
            assert answer.status == 200 and answer.read()
    heavy = {"torch", "umap", "plotly", "transformers", "sklearn", "scipy", "pandas"}
    print("LOADED", *sorted((heavy | {"mcp"}) & set(sys.modules)))

    from gradio.queueing import Queue
    (queue,) = {one.sleep_when_free for one in gc.get_objects() if isinstance(one, Queue)}
    looks = "sleep(self.sleep_when_free)" in inspect.getsource(Queue.start_processing)
    print("IDLE", looks and queue)

    client = HTTPConnection(urlsplit(address).netloc)

    def sent(content):
        client.request("POST", EVENTS, content, {"Content-Type": "application/json"})
        reply = client.getresponse()
        return reply.status, json.loads(reply.read())

    client.request("GET", "/config")
    begin = json.loads(client.getresponse().read())["dependencies"][1]
    event = {"data": [None] * len(begin["inputs"]), "fn_index": begin["id"], "session_hash": "a"}
    odd = [None, "", [], {}, [None], -1, 1e308, float("nan"), chr(0xD800), 2**70, [[[]]], "../x"]
    bodies = [b"", b"{", b"[]", b"null", bytes([255])]
    bodies += [json.dumps({**event, key: one}).encode() for key in event for one in odd]
    unlisted = json.dumps({**event, "data": ["", 1, *["x"] * 13]}).encode()
    replies = [sent(body) for body in [*bodies, *[unlisted] * (2 * LINES + 9)]]
    assert all(status == 200 or 400 <= status < 500 for status, _ in replies), replies
    refused = [told["error"] for status, told in replies if status != 200]
    assert all(one.endswith(".") and "reload" in one for one in refused), refused
    print("REFUSED", len(refused) > LINES)
    print("SEEN", title)


window = SimpleNamespace(create_window=create_window, start=lambda: print("STARTED"))
sys.modules["webview"] = window
assert main(["--desktop", "--port", sys.argv[1]]) == 0

from omnivat.head.checkpoint import load_head
from omnivat.head.heads import default_head
load_head(default_head())
print("LOADED", *sorted({"torch", "sympy"} & set(sys.modules)))

import pandas
from gradio import caching, component_meta
assert caching.pd.DataFrame is pandas.DataFrame
assert component_meta.create_or_modify_pyi.__name__ == "<lambda>"
"""


@pytest.mark.slow
def test_a_page_in_a_window_loads_nothing_heavy_and_refuses_events_that_gradio_cannot_read():
    """In a separate process, because a stopped server leaves an event loop."""
    with socket.socket() as probe:  # other tests may take the first free port at the same time
        probe.bind(("127.0.0.1", 0))
        port = str(probe.getsockname()[1])
    done = interpreter(RUNNING, port)
    assert done.returncode == 0, done.stderr[-3000:]
    words = ("LOADED", "IDLE", "REFUSED", "SEEN", "STARTED")
    said = [one for one in done.stdout.splitlines() if one.startswith(words)]
    # a head loads no algebra
    assert said == [
        "LOADED",
        "IDLE 0.05",
        "REFUSED True",
        "SEEN OmniVaT",
        "STARTED",
        "LOADED torch",
    ]
    assert 0 < done.stderr.count("Value: 'x'") <= 2 * LINES  # two minutes at most


STOPPED = """
import os, runpy, signal, sys

class Finder:  # sends the signal while the page loads
    def find_spec(self, name, *_):
        if name == "app.serving.guard":
            os.kill(os.getpid(), signal.SIGINT)

sys.meta_path.insert(0, Finder())
signal.signal(signal.SIGINT, signal.default_int_handler)  # in the background it is ignored
runpy.run_path("app.py", run_name="__main__")
"""


def test_a_page_that_is_stopped_while_it_loads_ends_in_a_sentence():
    done = interpreter(STOPPED)
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "Stopped.\n")


def test_without_pywebview_the_desktop_window_is_refused_in_a_sentence(monkeypatch, capsys):
    from app.serving.server import main

    monkeypatch.setitem(sys.modules, "webview", None)
    assert main(["--desktop"]) == 1
    said = capsys.readouterr().err
    assert (
        said
        == "app.py: webview is needed for --desktop. Install it with `pip install pywebview`.\n"
    )


def test_the_server_starts_with_connections_that_have_limits(resources, monkeypatch):
    import uvicorn

    from app.serving.server import launch
    from app.shared.connections import Connection
    from app.shared.visitor_sets import VisitorSets

    class Page:
        def launch(self, **_):
            return uvicorn.Config(lambda: None, port=1)

    for table in ("HTTP_PROTOCOLS", "WS_PROTOCOLS"):
        monkeypatch.setattr(uvicorn.config, table, dict(getattr(uvicorn.config, table)))
    found = launch(Page(), VisitorSets(resources), parser().parse_args([]))
    found.load()
    assert (found.http_protocol_class, found.ws_protocol_class) == (Connection, None)
