"""`hf:OWNER/NAME` with the client of the model hub, against a hub on this machine."""

import hashlib
import json
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from threading import Thread
from typing import ClassVar
from urllib.parse import unquote

import numpy as np
import pytest

from omnivat.cli import main
from omnivat.data.readers import read_pairs
from tests.unit.data.test_stored import written_by_datasets

hub = pytest.importorskip("huggingface_hub")


class Hub(BaseHTTPRequestHandler):
    """The replies of the hub that a download of a data set needs."""

    commits: ClassVar[dict[str, Path]] = {}  # revision -> folder
    stated: ClassVar[dict[str, object]] = {}  # of a commit, in place of the true facts
    down = ""  # a part of the paths that fail

    def log_message(self, *_):
        """Write no log."""

    def do_HEAD(self):
        self.do_GET()

    def do_GET(self):
        path = unquote(self.path.partition("?")[0])
        if self.down and self.down in path:
            return self._sent(400, b"{}")
        if "lab/gated" in path:
            return self._sent(403, b"{}", {"X-Error-Code": "GatedRepo"})
        if "lab/press" not in path:
            return self._sent(404, b"{}", {"X-Error-Code": "RepoNotFound"})
        asked = path.partition("lab/press/")[2] or "revision/main"
        kind, _, rest = asked.partition("/")
        revision, _, name = rest.partition("/")
        folder = self.commits.get(revision)
        if folder is None:
            return self._sent(404, b"{}", {"X-Error-Code": "RevisionNotFound"})
        commit = hashlib.sha1(folder.name.encode()).hexdigest()
        self.commits[commit] = folder
        files = sorted(p for p in folder.rglob("*") if p.is_file())
        if kind == "revision":
            return self._sent(
                200, json.dumps({"id": "lab/press", "sha": commit, **self.stated}).encode()
            )
        if kind == "tree":
            rows = [
                {
                    "type": "file",
                    "path": p.relative_to(folder).as_posix(),
                    "size": p.stat().st_size,
                    "oid": hashlib.sha1(p.read_bytes()).hexdigest(),
                }
                for p in files
            ]
            return self._sent(200, json.dumps(rows).encode())
        content = (folder / name).read_bytes()
        tags = {"ETag": f'"{hashlib.sha1(content).hexdigest()}"', "X-Repo-Commit": commit}
        return self._sent(200, content, tags)

    def _sent(self, status, content, headers=()):
        self.send_response(status)
        for name, value in {**dict(headers), "Content-Length": str(len(content))}.items():
            self.send_header(name, value)
        self.end_headers()
        if self.command == "GET":
            self.wfile.write(content)


@pytest.fixture
def served(tmp_path, monkeypatch):
    """Serve two commits of lab/press, of which the second renames the file of the first."""
    for name, shard in (("one", "train-00000-of-00001"), ("two", "train-00000-of-00002")):
        written_by_datasets(tmp_path / "hub" / name / "data" / f"{shard}.parquet")
    commits = {"main": tmp_path / "hub" / "one", "v2": tmp_path / "hub" / "two"}
    monkeypatch.setattr(Hub, "commits", commits)
    server = ThreadingHTTPServer(("127.0.0.1", 0), Hub)
    Thread(target=server.serve_forever, daemon=True).start()
    place = f"http://127.0.0.1:{server.server_port}"
    own = hub.constants.ENDPOINT
    template = hub.constants.HUGGINGFACE_CO_URL_TEMPLATE
    monkeypatch.setattr(hub.constants, "ENDPOINT", place)
    monkeypatch.setattr(hub.constants, "HUGGINGFACE_CO_URL_TEMPLATE", template.replace(own, place))
    monkeypatch.setattr(hub.constants, "DEFAULT_ETAG_TIMEOUT", 2)
    monkeypatch.setenv("OMNIVAT_CACHE", str(tmp_path / "cache"))
    monkeypatch.setenv("NO_PROXY", "127.0.0.1")
    yield server
    server.shutdown()
    server.server_close()


def brought(name, out):
    return main(["import", name, "--out", str(out), "--vis", "wrist"])


def test_a_data_set_arrives_and_a_new_commit_of_it_leaves_no_old_files(served, tmp_path):
    for name in ("hf:lab/press", "hf:lab/press@v2"):
        out = tmp_path / name[-2:]
        assert brought(name, out) == 0
        found = read_pairs(out).pairs
        assert {(p.domain, p.split, p.object) for p in found} == {
            ("press", "train", "mug"),
            ("press", "train", "fork"),
        }
        assert len(found) == 4 and np.unique([p.material for p in found]).size == 2


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("hf:lab/none", "there is none of that name, or it is private: check the name"),
        ("hf:lab/gated", "accept its terms on its page, and log in with `hf auth login`"),
        ("hf:lab/press@v9", "it has no such revision: check what follows the @"),
        ("hf:press", "write it as hf:OWNER/NAME"),
    ],
)
def test_a_set_that_does_not_arrive_is_one_sentence(served, tmp_path, capsys, name, words):
    assert brought(name, tmp_path / "out") == 1
    told = capsys.readouterr().err
    assert words in told and "Traceback" not in told and not (tmp_path / "out").exists()


@pytest.mark.parametrize("commit", [None, 5, "", "../../../../x"])
def test_a_commit_that_is_none_is_one_sentence_and_names_no_folder(
    served, tmp_path, capsys, monkeypatch, commit
):
    monkeypatch.setattr(Hub, "stated", {"sha": commit})
    before = sorted(tmp_path.rglob("*"))
    assert brought("hf:lab/press", tmp_path / "out") == 1
    told = capsys.readouterr().err
    assert "states no commit" in told and told.count("\n") == 1
    assert sorted(tmp_path.rglob("*")) == before


def test_what_arrived_in_part_is_not_taken_for_the_whole(served, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(Hub, "down", "/resolve/")
    assert brought("hf:lab/press", tmp_path / "out") == 1
    assert "check the name and the network" in capsys.readouterr().err
    served.shutdown()
    served.server_close()
    assert brought("hf:lab/press", tmp_path / "out") == 1
    assert "check the name and the network" in capsys.readouterr().err
