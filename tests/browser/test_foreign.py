"""The page under its content policy, and a page of another site that tries to use the server."""

import pytest

from benchmarks.site import served

from .conftest import running

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
  for (const way of ["omnivat/pairs", "omnivat/frames", "omnivat/thumbnails.json", "config"])
    for (const credentials of ["omit", "include"]) await attempt(way, {credentials});
  const opened = (stream) => new Promise((done) => {
    stream.onopen = () => done("open");
    stream.onerror = () => done("blocked");
  });
  for (const way of ["gradio_api/heartbeat/x", "omnivat/about"]) {
    tried["stream " + way] = await opened(new EventSource(target + way));
    tried["socket " + way] = await opened(new WebSocket(target.replace("http", "ws") + way));
  }
  return tried;
}"""


@pytest.fixture
def foreign(tmp_path):
    """Return the address of a page of another site."""
    (tmp_path / "index.html").write_text("<h1>another site</h1>", encoding="utf-8")
    with served(tmp_path) as address:
        yield address


def test_a_script_that_is_put_into_the_page_does_not_run(desktop, address):
    page = desktop.new_page()
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


@pytest.fixture(scope="module")
def by_name(tmp_path_factory):
    """A server that is also called demo.example, on another loopback address, and framed."""
    more = ("--allow-host", "demo.example", "--host", "127.0.0.2", "--allow-framing")
    with running(tmp_path_factory.mktemp("by-name"), "127.0.0.2", more) as server:
        yield server


def test_a_server_with_a_name_of_its_own_gives_foreign_pages_nothing(chromium, by_name, foreign):
    """For plain http and such a name, a browser leaves Sec-Fetch-Site out."""
    target = f"http://demo.example:{by_name.port}/"
    page = chromium.new_page()
    page.goto(target)
    assert page.evaluate("fetch('omnivat/about').then((got) => got.status)") == 200
    page.goto(foreign.replace("localhost", "127.0.0.1"))
    tried = [page.evaluate(TRIES, target)]
    page.set_content('<iframe sandbox="allow-scripts" srcdoc="<p>x"></iframe>')
    tried.append(page.frames[-1].evaluate(TRIES, target))  # of the origin null
    page.close()
    for one in tried:
        assert set(one.values()) <= {"blocked", "opaque"}, one  # opaque: nothing can be read
        assert len(one) == 11


def test_a_page_of_another_site_neither_sends_nor_reads_nor_frames(chromium, address, foreign):
    page = chromium.new_page()
    page.goto(foreign)
    tried = page.evaluate(TRIES, address)
    read = {way: got for way, got in tried.items() if got not in ("blocked", 403)}
    assert set(read) <= {"omnivat/pair", "omnivat/part?name=settings.json"}  # opaque, and refused
    with page.expect_event("framenavigated", lambda frame: frame != page.main_frame):
        page.set_content(f'<iframe src="{address}" id="frame"></iframe>')
    inner = page.frames[-1]
    inner.wait_for_load_state()
    assert inner.url.startswith("chrome-error") or not inner.query_selector("#views")
    page.close()
