"""Access to the server: host names, origins, and the page's content policy."""

import pytest
from starlette.applications import Starlette
from starlette.middleware import Middleware
from starlette.responses import HTMLResponse, JSONResponse
from starlette.routing import Route
from starlette.testclient import TestClient

from app.guard import Guard, is_loopback, rules, warning

PAGE = "<html><script>let a = 1;</script><script src='x.js'></script></html>"


async def answer(request):
    return JSONResponse({"method": request.method})


async def page(_):
    return HTMLResponse(PAGE)


def client(rules_of=None, base="http://127.0.0.1:7860"):
    guarded = Starlette(
        routes=[Route("/a", answer, methods=["GET", "POST", "DELETE"]), Route("/", page)],
        middleware=[Middleware(Guard, rules=rules_of or rules("127.0.0.1"))],
    )
    return TestClient(guarded, base_url=base)


@pytest.mark.parametrize("host", ["127.0.0.1:7860", "localhost:7860", "[::1]:7860", "LOCALHOST"])
def test_the_names_of_this_machine_are_served(host):
    assert client().get("/a", headers={"host": host}).status_code == 200


@pytest.mark.parametrize(
    "host",
    ["evil.example", "127.0.0.1.evil.example:7860", "192.168.0.3", "", "localhost@evil.example", "[", "a:b:c"],
)  # fmt: skip
def test_a_name_that_was_bound_to_this_machine_is_refused_in_a_sentence(host):
    got = client().get("/a", headers={"host": host})
    assert got.status_code == 403
    assert "--allow-host" in got.json()["error"]


def test_a_name_that_was_allowed_is_served():
    allowed = client(rules("127.0.0.1", ["demo.example"]))
    assert allowed.get("/a", headers={"host": "demo.example"}).status_code == 200


def test_beyond_loopback_numeric_addresses_are_served_and_foreign_names_are_not():
    open_to_all = client(rules("0.0.0.0"))
    assert open_to_all.get("/a", headers={"host": "192.168.0.3:7860"}).status_code == 200
    assert open_to_all.get("/a", headers={"host": "evil.example"}).status_code == 403


FOREIGN = [
    {"origin": "https://evil.example"},
    {"origin": "null"},
    {"origin": "http://127.0.0.1:9999"},
    {"origin": "http://127.0.0.1:7860.evil.example"},
    {"origin": "http://[", "sec-fetch-site": "cross-site"},
    {"sec-fetch-site": "cross-site"},
    {"sec-fetch-site": "same-site"},
    {"sec-fetch-site": "cross-site", "sec-fetch-mode": "navigate"},
]


@pytest.mark.parametrize("headers", FOREIGN)
@pytest.mark.parametrize("method", ["POST", "DELETE"])
def test_a_page_of_another_site_sends_nothing(method, headers):
    got = client().request(method, "/a", headers=headers)
    assert got.status_code == 403
    assert "another site" in got.json()["error"]


@pytest.mark.parametrize(
    "headers",
    [{}, {"origin": "http://127.0.0.1:7860", "sec-fetch-site": "same-origin"}, {"sec-fetch-site": "none"}],
)  # fmt: skip
def test_the_page_itself_and_a_script_without_a_browser_are_served(headers):
    assert client().post("/a", headers=headers).status_code == 200


def test_behind_a_proxy_with_a_certificate_the_page_is_served():
    behind = client(rules("127.0.0.1", ["demo.example"]), "http://demo.example")
    assert behind.post("/a", headers={"origin": "https://demo.example"}).status_code == 200


def test_a_link_from_another_site_opens_the_page_but_its_scripts_read_nothing():
    link = {"sec-fetch-site": "cross-site", "sec-fetch-mode": "navigate"}
    assert client().get("/", headers=link).status_code == 200
    read = {"sec-fetch-site": "cross-site", "sec-fetch-mode": "cors"}
    assert client().get("/a", headers=read).status_code == 403


def test_only_the_inline_scripts_that_the_page_came_with_run():
    from base64 import b64encode
    from hashlib import sha256

    got = client().get("/")
    policy = got.headers["content-security-policy"]
    assert got.text == PAGE
    assert f"'sha256-{b64encode(sha256(b'let a = 1;').digest()).decode()}'" in policy
    scripts = policy.split("script-src")[1].split(";")[0]
    assert scripts.count("sha256-") == 1
    assert "unsafe-inline" not in scripts


def test_no_page_may_frame_it_unless_asked_for():
    closed, framed = client().get("/"), client(rules("127.0.0.1", framed=True)).get("/")
    assert closed.headers["x-frame-options"] == "DENY"
    assert "frame-ancestors 'none'" in closed.headers["content-security-policy"]
    assert "x-frame-options" not in framed.headers
    assert "frame-ancestors *" in framed.headers["content-security-policy"]


def test_the_owner_of_an_open_server_is_warned_of_what_is_open():
    assert warning("127.0.0.1", 1) == warning("::1", 1) == warning("localhost", 1) == ""
    assert "without a password" in warning("0.0.0.0", 7860)
    assert not is_loopback("0.0.0.0")
