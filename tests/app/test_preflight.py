"""Wrong arguments of the page's command: one sentence each, before anything is loaded."""

import signal
import socket
import subprocess
import sys
import time
from pathlib import Path
from urllib.request import urlopen

import pytest

from app.preflight import parser
from app.server import main

ROOT = Path(__file__).resolve().parents[2]


PORT, PAIRS = "a number from 1 to 65535", "one from 1 to 50,000"


@pytest.mark.parametrize(
    ("name", "value", "wanted"),
    [
        *(("--port", text, PORT) for text in ("0", "-1", "99999", "eight", "٣", "9" * 5000)),
        *(("--sample", text, PAIRS) for text in ("0", "-1", "50001", "many", "9" * 5000)),
    ],
)
def test_what_is_no_such_number_is_refused_by_the_command_line(name, value, wanted, capsys):
    with pytest.raises(SystemExit) as caught:
        parser().parse_args([name, value])
    assert caught.value.code == 2
    assert wanted in capsys.readouterr().err


def refusal(capsys, *arguments):
    assert main(["--no-browser", *map(str, arguments)]) == 1
    said = capsys.readouterr().err
    assert said.startswith("app.py: ")
    assert said.count("\n") == 1
    return said


def test_a_port_in_use_is_refused_in_a_sentence(capsys):
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        port = other.getsockname()[1]
        assert f"port {port} (Address already in use)" in refusal(capsys, "--port", port)


@pytest.mark.parametrize("host", ["nonsense.invalid", "a" * 300, "..", "1.2.3.4"])
def test_a_host_that_is_not_this_machine_is_refused_in_a_sentence(capsys, host):
    assert "--host" in refusal(capsys, "--host", host)


def test_a_head_or_set_that_is_not_there_is_refused_in_a_sentence(capsys, tmp_path):
    assert "No head at" in refusal(capsys, "--head", tmp_path / "none")
    assert "No head at" in refusal(capsys, "--compare", tmp_path)
    assert "No embeddings file" in refusal(capsys, "--embeddings", tmp_path / "none")


@pytest.mark.slow
@pytest.mark.parametrize("how", [signal.SIGTERM, signal.SIGINT])
def test_a_server_that_is_told_to_stop_leaves_no_folder(how, tmp_path, monkeypatch):
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    process = subprocess.Popen(
        [sys.executable, "app.py", "--no-browser", "--port", str(port)],
        cwd=ROOT,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    )
    try:
        wait_for(port)
        send_file(port)
        assert [path.name for path in tmp_path.glob("omnivat-*")] != []
        process.send_signal(how)
        _, said = process.communicate(timeout=120)
    finally:
        process.kill()
        process.communicate()
    assert list(tmp_path.glob("omnivat-*")) == []
    assert "Traceback" not in said


def wait_for(port):
    until = time.monotonic() + 120
    while time.monotonic() < until:
        try:
            with urlopen(f"http://127.0.0.1:{port}/omnivat/examples", timeout=60):
                return
        except OSError:
            time.sleep(0.2)
    raise AssertionError("the server did not start")


def send_file(port):
    address = f"http://127.0.0.1:{port}/omnivat/part?name=settings.json"
    with urlopen(address, data=b"{}", timeout=60) as answer:
        assert answer.status == 200
