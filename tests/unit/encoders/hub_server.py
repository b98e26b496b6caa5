"""A small server that speaks the hub's protocol: model info, file list, files with their hash.

python hub_server.py FOLDER serves FOLDER/<owner>/<name>/* on 127.0.0.1, prints its address, and
prints one line for each request.
"""

import json
import sys
from hashlib import sha256
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from urllib.parse import unquote

SHA = "0123456789abcdef0123456789abcdef01234567"


class Hub(BaseHTTPRequestHandler):
    root: Path

    def do_HEAD(self) -> None:
        self._reply(body=False)

    def do_GET(self) -> None:
        self._reply(body=True)

    def _reply(self, *, body: bool) -> None:
        path = unquote(self.path.split("?")[0]).strip("/")
        parts = path.split("/")
        if parts[:2] == ["api", "models"]:
            self._about("/".join(parts[2:4]), parts[4:5], body)
        elif "resolve" in parts:
            self._file("/".join(parts[:2]), "/".join(parts[4:]), body)
        else:
            self._send(404, b"", body)

    def _about(self, repository: str, what: list[str], body: bool) -> None:
        folder = self.root / repository
        if repository.startswith("private/"):
            self._send(401, b"", body, {"X-Error-Code": "GatedRepo"})
        elif not folder.is_dir():
            self._send(404, b"", body, {"X-Error-Code": "RepoNotFound"})
        elif what == ["tree"]:
            files = [
                {"type": "file", "path": f.name, "size": f.stat().st_size, "oid": SHA}
                for f in sorted(folder.iterdir())
            ]
            self._send(200, json.dumps(files).encode(), body)
        else:
            files = [{"rfilename": f.name} for f in sorted(folder.iterdir())]
            record = {"id": repository, "sha": SHA, "siblings": files, "tags": [], "private": False}
            self._send(200, json.dumps(record).encode(), body)

    def _file(self, repository: str, name: str, body: bool) -> None:
        file = self.root / repository / name
        if not file.is_file():
            self._send(404, b"", body, {"X-Error-Code": "EntryNotFound"})
            return
        content = file.read_bytes()
        headers = {"ETag": f'"{sha256(content).hexdigest()}"', "X-Repo-Commit": SHA}
        self._send(200, content, body, headers)

    def _send(
        self, status: int, content: bytes, body: bool, headers: dict[str, str] | None = None
    ) -> None:
        self.send_response(status)
        for name, value in (headers or {}).items():
            self.send_header(name, value)
        self.send_header("Content-Length", str(len(content)))
        self.end_headers()
        if body:
            self.wfile.write(content)

    def log_message(self, format: str, *arguments: object) -> None:
        print(self.command, self.path, arguments[1] if len(arguments) > 1 else "", flush=True)


if __name__ == "__main__":
    Hub.root = Path(sys.argv[1])
    server = ThreadingHTTPServer(("127.0.0.1", 0), Hub)
    print(f"http://127.0.0.1:{server.server_port}", flush=True)
    server.serve_forever()
