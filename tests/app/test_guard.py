"""Access to the server: host names, origins, and the page's content policy."""

from base64 import b64encode
from hashlib import sha256

import pytest
from starlette.applications import Starlette
from starlette.middleware import Middleware
from starlette.responses import HTMLResponse, JSONResponse
from starlette.routing import Route
from starlette.testclient import TestClient
from starlette.websockets import WebSocketDisconnect

from app.serving.guard import Guard, alone, is_loopback, rules, warning

PAGE = "<html><script>let a = 1;</script><script src='x.js'></script></html>"
DEMO = rules("127.0.0.1", ["demo.example"])


async def answer(request):
    return JSONResponse({"method": request.method, "headers": sorted(request.headers)})


async def page(_):
    return HTMLResponse(PAGE)


def client(rules_of=None, base="http://127.0.0.1:7860"):
    guarded = Starlette(
        routes=[Route("/omnivat/a", answer, methods=["GET", "POST", "DELETE"]), Route("/", page)],
        middleware=[Middleware(Guard, rules=rules_of or rules("127.0.0.1"))],
    )
    return TestClient(guarded, base_url=base)


HOSTS = [
    *((None, host, 200) for host in ("127.0.0.1:7860", "localhost:7860", "[::1]:7860")),
    (None, "LOCALHOST", 200),
    *((None, host, 403) for host in ("127.0.0.1.evil.example:7860", "192.168.0.3")),
    *((None, host, 403) for host in ("", "localhost@evil.example", "[")),
    *(
        (rules("127.0.0.1", ["*.example.net"]), host, status)
        for host, status in {
            "b.a.EXAMPLE.net:443": 200,
            "evilexample.net": 403,
            "a.example.net.evil.example": 403,
        }.items()
    ),
    (rules("0.0.0.0"), "192.168.0.3:7860", 200),  # numeric addresses, beyond loopback
    (rules("0.0.0.0"), "evil.example", 403),
]  # fmt: skip


@pytest.mark.parametrize(("rules_of", "host", "status"), HOSTS)
def test_names_of_this_machine_and_allowed_ones_are_served_and_no_others(rules_of, host, status):
    got = client(rules_of).get("/omnivat/a", headers={"host": host})
    assert got.status_code == status
    assert status == 200 or "--allow-host" in got.json()["error"]


OWN, OTHER = ("origin", "http://demo.example"), ("origin", "http://evil.example")


@pytest.mark.parametrize(
    ("method", "path", "headers", "status"),
    [
        ("POST", "/omnivat/a", [], 200),  # a script without a browser
        ("POST", "/omnivat/a", [OWN, ("sec-fetch-site", "same-origin")], 200),
        ("POST", "/omnivat/a", [("origin", "https://demo.example")], 200),  # behind a proxy
        # for such a name browsers leave the site out: the origin alone is refused
        ("GET", "/omnivat/a", [OTHER], 403),
        *(
            ("POST", "/omnivat/a", [("origin", one)], 403)
            for one in ("null", "http://demo.example:9999", "http://demo.example.evil", "http://[")
        ),
        ("OPTIONS", "/omnivat/a", [("sec-fetch-site", "same-site")], 403),
        ("POST", "/", [("sec-fetch-site", "cross-site"), ("sec-fetch-mode", "navigate")], 403),
        ("GET", "/omnivat/a", [OWN, OWN], 200),
        ("GET", "/omnivat/a", [OWN, OTHER], 403),
        # a link from another site opens the page, and its scripts read nothing
        ("GET", "/", [("sec-fetch-site", "cross-site"), ("sec-fetch-mode", "navigate")], 200),
    ],
)
def test_the_page_itself_is_served_and_pages_of_others_are_not(method, path, headers, status):
    named = client(DEMO, "http://demo.example")
    got = named.request(method, path, headers=headers)
    assert got.status_code == status and (status == 200 or "another site" in got.text)


CLOSED = ["heartbeat/x", "queue/data?session_hash=x", "upload", "file=app.py"]


@pytest.mark.parametrize("path", [f"/gradio_api/{name}" for name in CLOSED] + ["/monitoring"])
def test_what_the_page_does_not_use_is_not_there(path):
    got = client().get(path)
    assert (got.status_code, got.json()["error"][-1]) == (404, ".")


def test_an_event_of_gradios_components_is_small_or_is_refused():
    sent = client()
    unread = sent.post("/gradio_api/run/predict", content=b"x" * 10_000)
    assert unread.status_code == 404 and "reload the page" in unread.json()["error"]
    for content in (b"x" * 10_001, iter([b"x"])):  # one without a stated length
        assert sent.post("/gradio_api/run/predict", content=content).status_code == 413


@pytest.mark.parametrize("name", ["X-Forwarded-Host", "X-Gradio-Server"])
def test_a_header_that_names_the_server_never_reaches_its_page(name):
    sent = client().get("/omnivat/a", headers={name: "javascript:1"}).json()["headers"]
    assert name.lower() not in sent and "host" in sent


def test_there_is_no_websocket():
    opened = client().websocket_connect("ws://127.0.0.1:7860/omnivat/a")
    with pytest.raises(WebSocketDisconnect), opened:
        pass


@pytest.mark.parametrize("lifespan", [None, alone])
def test_gradio_adds_no_headers_for_pages_of_other_sites(lifespan):
    from gradio.route_utils import CustomCORSMiddleware

    guarded = Middleware(Guard, rules=DEMO)
    app = Starlette(routes=[Route("/", page)], middleware=[guarded], lifespan=lifespan)
    app.add_middleware(CustomCORSMiddleware)
    with TestClient(app, base_url="http://demo.example") as named:
        got = named.get("/", headers={"origin": "http://evil.example"})
    assert got.status_code == 403
    assert ("access-control-allow-origin" in got.headers) is (lifespan is None)


def test_inline_scripts_that_the_page_came_with_or_has_more_than_gradios_run_and_no_others():
    more = {b"</html>": "<script>let b = 2;</script>", b"missing": "nothing"}
    guarded = Middleware(Guard, rules=rules("127.0.0.1"), added=more)
    app = Starlette(routes=[Route("/", page)], middleware=[guarded])
    got = TestClient(app, base_url="http://127.0.0.1:7860").get("/")
    assert got.text == PAGE.replace("</html>", "<script>let b = 2;</script></html>")
    scripts = got.headers["content-security-policy"].split("script-src")[1].split(";")[0]
    own = b64encode(sha256(b"let a = 1;").digest()).decode()
    assert f"'sha256-{own}'" in scripts and scripts.count("sha256-") == 2
    assert "unsafe-inline" not in scripts
    assert int(got.headers["content-length"]) == len(got.content)


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
