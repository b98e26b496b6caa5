"""The page under its content policy, and a page of another site that tries to use the server."""

import threading
from http.server import BaseHTTPRequestHandler, HTTPServer

import pytest

from app.views import VIEWS

from .gestures import READY, open_tab

pytestmark = pytest.mark.browser

TRIES = """async (target) => {
  const tried = {};
  const attempt = async (name, options) => {
    try {
      const answer = await fetch(target + name, options);
      tried[name] = answer.type === "opaque" ? "opaque" : answer.status;
    } catch { tried[name] = "blocked"; }
  };
  await attempt("omnivat/pair", {method: "POST", mode: "no-cors", body: '{"vis": "row:1"}'});
  await attempt("omnivat/about", {});
  await attempt("omnivat/part?name=settings.json", {method: "POST", mode: "no-cors", body: "{}"});
  return tried;
}"""


class Foreign(BaseHTTPRequestHandler):
    """A page of another site."""

    def do_GET(self):
        self.send_response(200)
        self.send_header("Content-Type", "text/html")
        self.end_headers()
        self.wfile.write(b"<h1>another site</h1>")

    def log_message(self, *_):
        pass


@pytest.fixture
def foreign():
    with HTTPServer(("127.0.0.1", 0), Foreign) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://localhost:{server.server_port}/"
        server.shutdown()


def test_every_tab_works_under_the_pages_own_policy(open_page):
    page = open_page("?vis=row:0&tac=row:0")
    page.wait_for_selector(READY["explore"])
    for view in VIEWS:
        open_tab(page, view)
        page.wait_for_selector(READY[view])
    page.wait_for_load_state("networkidle")
    # `open_page` fails for an error on the console, as one of the policy would be


def test_a_script_that_is_put_into_the_page_does_not_run(new_page, address, chromium):
    page = chromium.new_page()
    page.goto(address)
    page.wait_for_selector("#views button[role=tab]")
    page.evaluate("""() => {
      window.stopped = 0;
      document.addEventListener("securitypolicyviolation", () => window.stopped++);
      const script = document.createElement("script");
      script.textContent = "window.ran = true";
      document.body.append(script);
      document.body.insertAdjacentHTML("beforeend", '<img src=x onerror="window.ran = true">');
    }""")
    page.wait_for_function("() => window.stopped >= 2")  # the script, and what the image would do
    assert page.evaluate("() => window.ran") is None
    page.close()


def test_a_page_of_another_site_neither_sends_nor_reads_nor_frames(chromium, address, foreign):
    page = chromium.new_page()
    page.goto(foreign)
    tried = page.evaluate(TRIES, address)
    assert tried["omnivat/about"] in ("blocked", 403)
    assert tried["omnivat/pair"] in ("blocked", "opaque")  # and refused: see test_guard
    with page.expect_event("framenavigated", lambda frame: frame != page.main_frame):
        page.set_content(f'<iframe src="{address}" id="frame"></iframe>')
    inner = page.frames[-1]
    inner.wait_for_load_state()
    assert inner.url.startswith("chrome-error") or not inner.query_selector("#views")
    page.close()
