"""A headless Firefox, driven by its own protocol (Marionette): lines of JSON over a local socket."""

import json
import shutil
import socket
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

NAMES = ("firefox-esr", "firefox")
START_S, STEP_S, WAIT_S = 120, 0.05, 600
RUN = """window.eval(`globalThis.found = null; (${arguments[0]})(${arguments[1]}).then(
  (value) => { found = JSON.stringify({ value }); }, (error) => { found = JSON.stringify({ error: String(error) }); })`)"""
READ = "return window.found"


class Firefox:
    """A page in Firefox, with the two methods of a page of Playwright that a benchmark needs."""

    def __init__(self, port: int) -> None:
        self.line = socket.create_connection(("127.0.0.1", port))
        self.line.settimeout(WAIT_S)
        self.last, self.rest = 0, b""
        self._message()  # its greeting
        self._command("WebDriver:NewSession", {})

    def goto(self, address: str) -> None:
        """Open an address."""
        self._command("WebDriver:Navigate", {"url": address})

    def evaluate(self, script: str, argument: Any = None) -> Any:
        """Return what an async function of JavaScript makes of a plain value."""
        args = [script, json.dumps(argument)]
        self._command("WebDriver:ExecuteScript", {"script": RUN, "args": args})
        deadline = time.monotonic() + WAIT_S
        while time.monotonic() < deadline:
            found = self._command("WebDriver:ExecuteScript", {"script": READ, "args": []})["value"]
            if found is not None:
                reply = json.loads(found)
                if "error" in reply:
                    raise RuntimeError(reply["error"])
                return reply.get("value")
            time.sleep(STEP_S)
        raise TimeoutError(f"Firefox gave no reply within {WAIT_S} s.")

    def _command(self, name: str, parameters: dict[str, Any]) -> Any:
        self.last += 1
        text = json.dumps([0, self.last, name, parameters]).encode()
        self.line.sendall(b"%d:%s" % (len(text), text))
        _, _, error, value = self._message()
        if error:
            raise RuntimeError(f"{name}: {error['message']}")
        return value

    def _message(self) -> Any:
        while b":" not in self.rest:
            self._more()
        length, self.rest = self.rest.split(b":", 1)
        while len(self.rest) < int(length):
            self._more()
        text, self.rest = self.rest[: int(length)], self.rest[int(length) :]
        return json.loads(text)

    def _more(self) -> None:
        piece = self.line.recv(65536)
        if not piece:
            raise ConnectionError("Firefox has ended.")
        self.rest += piece


@contextmanager
def firefox() -> Iterator[Firefox]:
    """Yield a page of a new Firefox with an empty profile. Raises FileNotFoundError if there is none."""
    binary = next((path for name in NAMES if (path := shutil.which(name))), None)
    if binary is None:
        raise FileNotFoundError("No Firefox was found; install it with `apt-get install firefox-esr`.")
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    with TemporaryDirectory(prefix="omnivat-firefox-") as profile:
        settings = f'user_pref("marionette.port", {port});\n'
        (Path(profile) / "user.js").write_text(settings, encoding="ascii")
        command = [binary, "--headless", "--no-remote", "--marionette", "--profile", profile]
        process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        try:
            yield _connected(port, process)
        finally:
            process.terminate()
            process.wait()


def _connected(port: int, process: "subprocess.Popen[bytes]") -> Firefox:
    deadline = time.monotonic() + START_S
    while process.poll() is None and time.monotonic() < deadline:
        try:
            return Firefox(port)
        except ConnectionRefusedError:
            time.sleep(STEP_S)
    raise RuntimeError("Firefox did not start.")
