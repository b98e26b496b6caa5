"""Downloads: with consent, into the hub's cache, once; without a network one clear sentence."""

import os
import subprocess
import sys
from types import SimpleNamespace

import huggingface_hub
import pytest

from omnivat.encoders import hub
from omnivat.kit.errors import SettingsError

REPOSITORY = "openai/clip-vit-base-patch16"
FETCH = """
import sys
from omnivat.encoders import hub
print(hub.fetch(sys.argv[1], megabytes=599, download=sys.argv[2]))
"""


@pytest.mark.parametrize(
    ("download", "variables", "sentence"),
    [
        ("yes", {"HF_HUB_OFFLINE": "1"}, "Downloads are off"),
        (
            "yes",
            {"HTTP_PROXY": "http://127.0.0.1:9", "HF_ENDPOINT": "http://hub.invalid"},
            "cannot be reached through the proxy http://127.0.0.1:9",
        ),
    ],
)
def test_what_hinders_a_download_is_one_sentence(tmp_path, download, variables, sentence):
    """In a process of its own, for the hub's client reads its settings when it is imported."""
    kept = {k: v for k, v in os.environ.items() if "proxy" not in k.lower() and k[:3] != "HF_"}
    done = subprocess.run(
        [sys.executable, "-c", FETCH, REPOSITORY, download],
        env={**kept, "HF_HOME": str(tmp_path), **variables},
        capture_output=True,
        text=True,
        stdin=subprocess.DEVNULL,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert sentence in done.stdout and done.stdout.count("\n") == 1


@pytest.mark.parametrize(
    ("download", "sentence"),
    [
        ("ask", "Add --download to fetch openai/clip-vit-base-patch16 (599 MB)"),
        ("no", "Downloads are off"),
    ],
)
def test_without_consent_one_sentence_says_how_to_give_it(download, sentence, monkeypatch):
    monkeypatch.setattr(huggingface_hub, "try_to_load_from_cache", lambda *_: None)
    said = hub.fetch(REPOSITORY, megabytes=599, download=download)
    assert sentence in said and "\n" not in said


@pytest.fixture
def served(monkeypatch, tmp_path):
    """Let the hub offer some files; return what is asked of it."""
    asked = []

    def serve(*files):
        siblings = [SimpleNamespace(rfilename=name) for name in files]
        about = SimpleNamespace(model_info=lambda name: SimpleNamespace(siblings=siblings))
        monkeypatch.setattr(huggingface_hub, "HfApi", lambda: about)
        monkeypatch.setattr(huggingface_hub.constants, "HF_HUB_OFFLINE", False)
        monkeypatch.setattr(huggingface_hub, "try_to_load_from_cache", lambda *_: None)

        def download(name, allow_patterns):
            asked.append((name, allow_patterns))
            return str(tmp_path)

        monkeypatch.setattr(huggingface_hub, "snapshot_download", download)
        return asked

    return serve


def test_settings_come_first_and_one_file_of_weights_last(served, tmp_path):
    asked = served("config.json", "pytorch_model.bin", "model.safetensors")
    assert hub.fetch(REPOSITORY, download="yes") == tmp_path
    small = ["*.json", "*.txt"]
    assert asked == [(REPOSITORY, small), (REPOSITORY, [*small, "model.safetensors"])]


def test_a_model_without_weights_is_no_complete_one(served):
    served("config.json")
    assert "no complete model 'openai/clip" in hub.fetch(REPOSITORY, download="yes")


@pytest.mark.parametrize(
    ("status", "sentence"),
    [
        (401, "The hub refuses a/b without a login"),
        (404, "The hub has no complete model 'a/b'"),
        (503, "replied with status 503; try again later"),
    ],
)
def test_a_refusal_tells_its_status_also_where_another_error_hides_it(status, sentence):
    error, cause = ValueError("hidden"), OSError()
    cause.response = SimpleNamespace(status_code=status)
    error.__cause__ = cause
    assert sentence in hub.explained(error, "a/b")


def test_a_model_in_the_cache_is_taken_without_a_question(monkeypatch, tmp_path):
    place = str(tmp_path / "model.safetensors")
    monkeypatch.setattr(huggingface_hub, "try_to_load_from_cache", lambda *_: place)
    assert hub.fetch(REPOSITORY, download="no") == tmp_path


def test_nothing_is_downloaded_without_consent(monkeypatch):
    for stream in ("stdin", "stderr"):
        monkeypatch.setattr(sys, stream, SimpleNamespace(isatty=lambda: True))
    for reply, agreed in (("y", True), (" YES ", True), ("", False), ("no", False)):
        monkeypatch.setattr("builtins.input", lambda _, reply=reply: reply)
        assert hub._agreed("Download? ") is agreed
    monkeypatch.setattr(sys, "stdin", SimpleNamespace(isatty=lambda: False))
    monkeypatch.setattr("builtins.input", lambda _: "y")
    assert not hub._agreed("Download? ")
    monkeypatch.undo()
    with pytest.raises(SettingsError, match="ask, yes, no"):
        hub.fetch("owner/name", download="maybe")
