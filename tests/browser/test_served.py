"""What the server serves and accepts, over plain HTTP, in a real process."""

import json
from concurrent.futures import ThreadPoolExecutor
from http.client import HTTPConnection
from pathlib import Path
from urllib.parse import quote, urlsplit

import pytest

pytestmark = pytest.mark.browser

ROOT = Path(__file__).resolve().parents[2]
OUTSIDE = [  # files that lie on the server and are nobody's business
    ROOT / "app.py",
    ROOT / "app/serving/server.py",
    ROOT / "requirements.txt",
    ROOT / "examples/simulated.csv",
    Path("/etc/passwd"),
]
DOORS = [  # where Gradio and we serve files
    "gradio_api/file=",
    "gradio_api/file/",
    "file=",
    "gradio_api/proxy=file://",
    "static/",
    "assets/",
    "svelte/",
    "omnivat/web/",
    "omnivat/example/",
    "gradio_api/custom_component/x/server/",
    "",
]
UPWARDS = ["", "/", "../", "../../../../../../../../../../", "..%2f", "%2e%2e/", "....//", "..\\"]


def asked(address, method, path, body=None, kind=""):
    """Return status and body; the path is sent unchanged, with dots."""
    parts = urlsplit(address)
    connection = HTTPConnection(str(parts.hostname), parts.port, timeout=150)
    try:
        connection.request(method, path, body, {"Content-Type": kind} if kind else {})
        answer = connection.getresponse()
        return answer.status, answer.read()
    finally:
        connection.close()


def ways(file):
    """Yield paths that an attacker might try."""
    for door in DOORS:
        for up in UPWARDS:
            for name in (str(file).lstrip("/"), file.name, f"{file.parent.name}/{file.name}"):
                yield f"/{door}{up}{quote(name)}"


def test_no_path_gives_a_file_that_the_page_does_not_need(address):
    tried = 0
    for file in OUTSIDE:
        secret = file.read_bytes()[:60]
        for path in ways(file):
            status, body = asked(address, "GET", path)
            assert secret not in body, path
            assert status != 500, path
            tried += 1
    assert tried > 500


def test_fifty_visitors_at_once_are_all_answered_and_each_what_it_asked(address):
    def answer(row):
        body = json.dumps({"vis": f"row:{row}", "tac": f"row:{row}", "order": 0.3}).encode()
        status, text = asked(address, "POST", "/omnivat/pair", body, "application/json")
        assert status == 200, text
        found = json.loads(text)["exact"]["readings"]["fused"]
        return found

    rows = [7 * (visitor % 25) for visitor in range(50)]
    with ThreadPoolExecutor(50) as crowd:
        together = list(crowd.map(answer, rows))
    alone = {row: answer(row) for row in set(rows)}
    assert together == [alone[row] for row in rows]
    assert len({json.dumps(one) for one in together}) == 25


def test_the_page_is_packed_and_names_every_script_that_its_first_view_loads(new_page, address):
    page = new_page()
    reply = page.goto(address)
    page.wait_for_selector(".explore.ready")
    named = [part.split(">")[0].lstrip("< ") for part in reply.header_value("link").split(",")]
    loaded = page.evaluate("performance.getEntriesByType('resource').map((one) => one.name)")
    scripts = {one.removeprefix(address) for one in loaded if "/omnivat/web/explore/" in one}
    assert (
        {one for one in scripts if one.endswith(".js")}
        <= set(named)
        <= {one.removeprefix(address) for one in loaded}
    )
    assert reply.header_value("content-encoding") == "gzip"
    assert page.request.get(f"{address}omnivat/twins").headers["content-encoding"] == "gzip"
