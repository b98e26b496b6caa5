"""The repository as a hosted demo: its environment, a read-only disk, its memory."""

import json
import os
import signal
import socket
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path
from urllib.request import Request, urlopen

import pytest

from app.serving.preflight import keeps_nothing, parser
from app.train.plan import NUMBERS

from .conftest import until

ROOT = Path(__file__).resolve().parents[2]
SPACE = {
    "GRADIO_SERVER_NAME": "0.0.0.0",
    "GRADIO_SERVER_PORT": "7999",
    "SPACE_ID": "me/demo",
    "SPACE_HOST": "me-demo.example",
}
# written into the server's interpreter: notes whatever is opened for writing outside its folder
WATCH = """
import os, sys
_told = os.open(os.environ["WATCHED"], os.O_WRONLY | os.O_CREAT | os.O_APPEND)
_free = (os.path.realpath(os.environ["TMPDIR"]), "/dev/", "/proc/")
def _watch(event, given):
    if event == "open":
        path, mode, flags = given
        writes = (flags or 0) & (os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_APPEND)
    elif event in ("os.mkdir", "os.rename", "os.remove", "os.truncate", "os.symlink"):
        path, writes = given[1 if event == "os.rename" else 0], True
        folder = given[-1]  # names may be relative to an open folder
        held = event in ("os.mkdir", "os.rename", "os.remove")
        if held and isinstance(folder, int) and folder >= 0:
            path = os.path.join(os.readlink(f"/proc/self/fd/{folder}"), os.fsdecode(path))
    else:
        return
    if writes and isinstance(path, (str, bytes)):
        path = os.path.realpath(os.fsdecode(path))
        if not path.startswith(_free):
            os.write(_told, f"{event} {path}\\n".encode())
sys.addaudithook(_watch)
"""


def test_a_service_says_where_to_listen_and_by_which_name_it_calls():
    chosen = parser(SPACE).parse_args([])
    assert (chosen.host, chosen.port) == ("0.0.0.0", 7999)
    assert chosen.allow_host == ["me-demo.example"]
    assert chosen.allow_framing
    assert chosen.no_browser
    assert keeps_nothing(SPACE)


def test_arguments_are_above_the_environment_and_without_a_service_nothing_is_open():
    chosen = parser(SPACE).parse_args(["--host", "127.0.0.1", "--port", "8001"])
    assert (chosen.host, chosen.port) == ("127.0.0.1", 8001)
    chosen = parser({}).parse_args([])
    assert (chosen.host, chosen.port, chosen.allow_host) == ("127.0.0.1", None, [])
    assert not (chosen.allow_framing or chosen.no_browser or keeps_nothing({}))
    assert not keeps_nothing({**SPACE, "OMNIVAT_CACHE": "/data"})


def test_a_port_that_is_none_is_refused(capsys):
    with pytest.raises(SystemExit):
        parser({**SPACE, "GRADIO_SERVER_PORT": "many"}).parse_args([])
    assert "'many'; give a whole number, 1 to 65535" in capsys.readouterr().err


class Demo:
    """`python app.py` started by a service, with its writes recorded."""

    def __init__(self, place):
        self.tmp, self.told = place / "tmp", place / "writes"
        self.tmp.mkdir()
        (place / "watch").mkdir()
        (place / "watch" / "sitecustomize.py").write_text(WATCH, encoding="utf-8")
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            self.port = probe.getsockname()[1]
        kept = {name: os.environ[name] for name in ("PATH", "LANG") if name in os.environ}
        environ = kept | SPACE
        environ |= {
            "GRADIO_SERVER_PORT": str(self.port),
            "HOME": "/nowhere",
            "TMPDIR": str(self.tmp),
            "WATCHED": str(self.told),
            "PYTHONPATH": str(place / "watch"),
            "PYTHONDONTWRITEBYTECODE": "1",
            "OMP_NUM_THREADS": "1",
        }
        self.log = (place / "log").open("w+", encoding="utf-8")
        self.process = subprocess.Popen(
            [sys.executable, "app.py"], cwd=ROOT, env=environ, stdout=self.log, stderr=self.log
        )

    def ask(self, path, question=None):
        """Return the reply to a request with the service's host name; a question may be bytes."""
        raw = question is None or isinstance(question, bytes)
        content = question if raw else json.dumps(question).encode()
        kind = "application/octet-stream" if raw else "application/json"
        headers = {"Host": "me-demo.example", "Content-Type": kind}
        request = Request(f"http://127.0.0.1:{self.port}/{path}", data=content, headers=headers)
        with urlopen(request, timeout=120) as answer:
            return bytes(answer.read())

    def page(self):
        """Return the page; None until the server is ready."""
        assert self.process.poll() is None, Path(self.log.name).read_text(encoding="utf-8")
        with suppress(OSError):
            return self.ask("")

    def peak_bytes(self):
        """Return the peak memory of the process."""
        status = Path(f"/proc/{self.process.pid}/status").read_text(encoding="utf-8")
        return int(status.split("VmHWM:")[1].split()[0]) * 1024

    def outside(self):
        """Return the files written elsewhere; Gradio may write one seed where it is installed."""
        told = self.told.read_text(encoding="utf-8").splitlines()
        return [line for line in told if not line.endswith("/gradio/hash_seed.txt")]

    def stop(self):
        """Stop as a service does."""
        self.process.send_signal(signal.SIGTERM)
        self.process.wait(timeout=240)
        self.log.seek(0)
        assert "Traceback" not in self.log.read()
        self.log.close()


@pytest.fixture
def demo(tmp_path):
    found = Demo(tmp_path)
    try:
        yield found
    finally:
        found.process.kill()


def event(demo, number, *values):
    """Return what an event of Gradio's components changes."""
    asked = {"data": values, "fn_index": number, "session_hash": "a"}
    return json.loads(demo.ask("gradio_api/run/predict", asked))["data"]


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="memory is read from /proc")
def test_a_hosted_demo_writes_to_its_temporary_folder_alone_and_stays_below_a_gigabyte(demo, png):
    assert b"OmniVaT" in until(demo.page)
    sent = json.loads(demo.ask("omnivat/image?name=a.png", png()))
    for path, question in (
        ("omnivat/pair", {"vis": sent["ref"], "tac": None}),
        ("omnivat/pair", {"vis": "row:0", "tac": "row:0"}),
        ("omnivat/votes", {}),
    ):
        demo.ask(path, question)
    settings = {"source": "TAG-sim", "order": "gradient", "width": 16}
    numbers = {name: row[-1] for name, row in NUMBERS.items()} | {"epochs": 5}
    _, begin, look, *_ = (one["id"] for one in json.loads(demo.ask("config"))["dependencies"])
    seen = event(demo, begin, None, 1280, "domain", *settings.values(), *numbers.values(), False)
    (kept,) = (one for one in seen if isinstance(one, dict) and "runs" in one)

    def ended():
        time.sleep(0.2)
        seen = json.dumps(event(demo, look, kept, 1280, "domain"))
        return any(word in seen for word in ("Done", "Cancelled", "problem")) and seen

    assert "Done: 5 epochs." in until(ended)
    assert demo.peak_bytes() < 1_000_000_000
    demo.stop()
    assert demo.outside() == []
    assert not list(demo.tmp.glob("omnivat-*"))
