"""Access to the server: host names, origins, and the page's content policy."""

import pytest
from starlette.applications import Starlette
from starlette.middleware import Middleware
from starlette.responses import HTMLResponse, JSONResponse
from starlette.routing import Route
from starlette.testclient import TestClient
from starlette.websockets import WebSocketDisconnect

from app.guard import Guard, alone, is_loopback, rules, warning

PAGE = "<html><script>let a = 1;</script><script src='x.js'></script></html>"


async def answer(request):
    return JSONResponse({"method": request.method})


async def page(_):
    return HTMLResponse(PAGE)


def client(rules_of=None, base="http://127.0.0.1:7860"):
    guarded = Starlette(
        routes=[Route("/omnivat/a", answer, methods=["GET", "POST", "DELETE"]), Route("/", page)],
        middleware=[Middleware(Guard, rules=rules_of or rules("127.0.0.1"))],
    )
    return TestClient(guarded, base_url=base)


@pytest.mark.parametrize("host", ["127.0.0.1:7860", "localhost:7860", "[::1]:7860", "LOCALHOST"])
def test_the_names_of_this_machine_are_served(host):
    assert client().get("/omnivat/a", headers={"host": host}).status_code == 200


@pytest.mark.parametrize(
    "host",
    ["evil.example", "127.0.0.1.evil.example:7860", "192.168.0.3", "", "localhost@evil.example", "[", "a:b:c"],
)  # fmt: skip
def test_a_name_that_was_bound_to_this_machine_is_refused_in_a_sentence(host):
    got = client().get("/omnivat/a", headers={"host": host})
    assert got.status_code == 403
    assert "--allow-host" in got.json()["error"]


def test_a_name_that_was_allowed_is_served():
    allowed = client(rules("127.0.0.1", ["demo.example"]))
    assert allowed.get("/omnivat/a", headers={"host": "demo.example"}).status_code == 200


def test_beyond_loopback_numeric_addresses_are_served_and_foreign_names_are_not():
    open_to_all = client(rules("0.0.0.0"))
    assert open_to_all.get("/omnivat/a", headers={"host": "192.168.0.3:7860"}).status_code == 200
    assert open_to_all.get("/omnivat/a", headers={"host": "evil.example"}).status_code == 403


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
@pytest.mark.parametrize("method", ["GET", "HEAD", "OPTIONS", "POST", "DELETE"])
def test_a_page_of_another_site_neither_sends_nor_reads(method, headers):
    if method in ("GET", "HEAD") and headers.get("sec-fetch-mode") == "navigate":
        return  # a link
    got = client().request(method, "/omnivat/a", headers=headers)
    assert got.status_code == 403
    assert method == "HEAD" or "another site" in got.json()["error"]


@pytest.mark.parametrize("origin", ["http://evil.example", "http://127.0.0.1:7860", "null"])
def test_under_a_name_for_which_browsers_leave_the_site_out_the_origin_alone_is_refused(origin):
    named = client(rules("127.0.0.1", ["demo.example"]), "http://demo.example")
    assert named.get("/omnivat/a", headers={"origin": origin}).status_code == 403
    own = {"origin": "http://demo.example"}
    assert named.get("/omnivat/a", headers=own).status_code == 200


def test_of_several_origins_each_has_to_be_the_pages_own():
    named = client(rules("127.0.0.1", ["demo.example"]), "http://demo.example")
    own, other = ("origin", "http://demo.example"), ("origin", "http://evil.example")
    statuses = [
        named.get("/omnivat/a", headers=sent).status_code
        for sent in ([own, own], [own, other], [other, own])
    ]
    assert statuses == [200, 403, 403]


CLOSED = ["heartbeat/x", "dev/reload", "queue/data?session_hash=x", "info", "upload", "file=app.py"]


@pytest.mark.parametrize(
    "path", [f"/gradio_api/{name}" for name in CLOSED] + ["/monitoring", "/a", "/pwa_icon/512"]
)
def test_what_the_page_does_not_use_is_not_there(path):
    got = client().get(path)
    assert (got.status_code, got.json()["error"][-1]) == (404, ".")


@pytest.mark.parametrize("name", ["X-Forwarded-Host", "X-Gradio-Server", "Forwarded"])
def test_a_header_that_names_the_server_never_reaches_its_page(name):
    async def sent(request):
        return JSONResponse(sorted(request.headers))

    guarded = Starlette(
        routes=[Route("/omnivat/a", sent)], middleware=[Middleware(Guard, rules=rules("127.0.0.1"))]
    )
    found = TestClient(guarded, base_url="http://127.0.0.1:7860").get(
        "/omnivat/a", headers={name: "javascript:1"}
    )
    assert name.lower() not in found.json() and "host" in found.json()


def test_there_is_no_websocket():
    with (
        pytest.raises(WebSocketDisconnect),
        client().websocket_connect("ws://127.0.0.1:7860/omnivat/a"),
    ):
        pass


@pytest.mark.parametrize("lifespan", [None, alone])
def test_gradio_adds_no_headers_for_pages_of_other_sites(lifespan):
    from gradio.route_utils import CustomCORSMiddleware

    guarded = Middleware(Guard, rules=rules("127.0.0.1", ["demo.example"]))
    app = Starlette(routes=[Route("/", page)], middleware=[guarded], lifespan=lifespan)
    app.add_middleware(CustomCORSMiddleware)
    with TestClient(app, base_url="http://demo.example") as named:
        got = named.get("/", headers={"origin": "http://evil.example"})
    assert got.status_code == 403
    assert ("access-control-allow-origin" in got.headers) is (lifespan is None)


@pytest.mark.parametrize(
    "headers",
    [{}, {"origin": "http://127.0.0.1:7860", "sec-fetch-site": "same-origin"}, {"sec-fetch-site": "none"}],
)  # fmt: skip
def test_the_page_itself_and_a_script_without_a_browser_are_served(headers):
    assert client().post("/omnivat/a", headers=headers).status_code == 200


def test_behind_a_proxy_with_a_certificate_the_page_is_served():
    behind = client(rules("127.0.0.1", ["demo.example"]), "http://demo.example")
    assert behind.post("/omnivat/a", headers={"origin": "https://demo.example"}).status_code == 200


def test_a_link_from_another_site_opens_the_page_but_its_scripts_read_nothing():
    link = {"sec-fetch-site": "cross-site", "sec-fetch-mode": "navigate"}
    assert client().get("/", headers=link).status_code == 200
    read = {"sec-fetch-site": "cross-site", "sec-fetch-mode": "cors"}
    assert client().get("/omnivat/a", headers=read).status_code == 403


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
