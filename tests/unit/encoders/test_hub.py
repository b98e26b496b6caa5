"""Downloads: with consent, into the hub's cache, once; without a network one clear sentence.

Each case runs in a process of its own, for the hub's client reads its settings when it is imported.
"""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from omnivat.data.store import load_embeddings
from omnivat.encoders import hub
from omnivat.kit.errors import SettingsError

pytest.importorskip("transformers")
REPOSITORY = "openai/clip-vit-base-patch16"

# The published size of clip-vit-b16 becomes that of the small model which the server has.
COMMAND = """
import sys
from omnivat.encoders import clip
clip.PUBLISHED["clip-vit-b16"] = clip.ImageShape(32, 64, (2,), 24, 96)
from omnivat.cli import main
for more in sys.argv[1].split(","):
    code = main([*sys.argv[2:], *filter(None, [more])])
sys.exit(code)
"""


@pytest.fixture(scope="module")
def served(tmp_path_factory, clips):
    """Give the address of a hub with one model, and the file of its requests."""
    root = tmp_path_factory.mktemp("hub")
    clips.write("transformers folder", root / "files" / REPOSITORY, clips.small_model())
    (root / "files" / REPOSITORY / "pytorch_model.bin").write_bytes(b"not wanted")
    script = Path(__file__).with_name("hub_server.py")
    with (root / "log").open("w") as log:
        server = subprocess.Popen(
            [sys.executable, script, root / "files"], stdout=subprocess.PIPE, stderr=log, text=True
        )
        assert server.stdout is not None
        try:
            yield server.stdout.readline().strip(), root
        finally:
            server.kill()
            server.wait()
            server.stdout.close()


@pytest.fixture
def pairs(tmp_path):
    for name in ("vis", "tac"):
        place = tmp_path / "pairs" / "TAG" / "wood"
        place.mkdir(parents=True, exist_ok=True)
        pixels = np.random.default_rng(0).integers(0, 256, (40, 40, 3), dtype=np.uint8)
        Image.fromarray(pixels).save(place / f"a_{name}.png")
    return tmp_path / "pairs"


def environment(folder, address):
    kept = {k: v for k, v in os.environ.items() if "proxy" not in k.lower() and k[:3] != "HF_"}
    places = {"HF_HOME": str(folder / "hf"), "OMNIVAT_CACHE": str(folder / "cache")}
    return {**kept, **places, "HF_ENDPOINT": address}


def embed(pairs, address, *more):
    """Embed `pairs` once for each of `more`, in one new process whose hub is at `address`."""
    out = str(pairs.parent / "set.safetensors")
    command = ["embed", str(pairs), "--encoder", "clip-vit-b16", "--out", out]
    return subprocess.run(
        [sys.executable, "-c", COMMAND, ",".join(more), *command],
        env=environment(pairs.parent, address),
        capture_output=True,
        text=True,
        stdin=subprocess.DEVNULL,
        check=False,
    )


@pytest.mark.long
@pytest.mark.slow
def test_a_model_is_downloaded_once_and_then_found_in_the_cache_without_a_network(served, pairs):
    address, _ = served
    done = embed(pairs, address, "", "--download")
    assert done.returncode == 0, done.stderr
    assert "Add --download to fetch openai/clip-vit-base-patch16 (599 MB)" in done.stderr
    assert load_embeddings(pairs.parent / "set.safetensors").width == 24
    cached = [file.name for file in (pairs.parent / "hf").rglob("*") if file.is_symlink()]
    assert "model.safetensors" in cached and "tokenizer.json" in cached
    assert "pytorch_model.bin" not in cached  # one file of weights is enough
    again = embed(pairs, "http://127.0.0.1:9", "--offline")
    assert again.returncode == 0, again.stderr


FETCH = """
import sys
from omnivat.encoders import hub
print(hub.fetch(sys.argv[1], megabytes=599, download=sys.argv[2]))
"""


@pytest.mark.parametrize(
    ("repository", "download", "variables", "sentence"),
    [
        (REPOSITORY, "ask", {}, "Add --download to fetch openai/clip-vit-base-patch16 (599 MB)"),
        (REPOSITORY, "no", {}, "Downloads are off"),
        (REPOSITORY, "yes", {"HF_HUB_OFFLINE": "1"}, "Downloads are off"),
        (REPOSITORY, "yes", {"HF_ENDPOINT": "http://127.0.0.1:9"}, ":9 cannot be reached"),
        (
            REPOSITORY,
            "yes",
            {"HTTP_PROXY": "http://127.0.0.1:9", "HF_ENDPOINT": "http://hub.invalid"},
            "cannot be reached through the proxy http://127.0.0.1:9",
        ),
        ("openai/none", "yes", {}, "no complete model 'openai/none'"),
        ("private/none", "yes", {}, "without a login"),
    ],
)
def test_what_hinders_a_download_is_one_sentence(
    served, tmp_path, repository, download, variables, sentence
):
    done = subprocess.run(
        [sys.executable, "-c", FETCH, repository, download],
        env=environment(tmp_path, served[0]) | variables,
        capture_output=True,
        text=True,
        stdin=subprocess.DEVNULL,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert sentence in done.stdout and done.stdout.count("\n") == 1


def test_nothing_is_downloaded_without_consent(monkeypatch, tmp_path):
    asked = []

    class Terminal:
        def isatty(self):
            return True

    for stream in ("stdin", "stderr"):
        monkeypatch.setattr(sys, stream, Terminal())
    assert hub._agreed("Download? ", lambda question: asked.append(question) or "y")
    assert not hub._agreed("Download? ", lambda question: "")
    assert asked == ["Download? "]
    monkeypatch.undo()
    with pytest.raises(SettingsError, match="ask, yes, no"):
        hub.fetch("owner/name", download="maybe")
