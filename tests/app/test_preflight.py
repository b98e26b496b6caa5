"""Wrong arguments of the page's command: one sentence each, before anything is loaded."""

import socket
from pathlib import Path

import pytest

from app.serving.preflight import find_files, parser
from app.serving.server import main

ROOT = Path(__file__).resolve().parents[2]


PORT, PAIRS = "a whole number, 1 to 65535", "a whole number, 1 to 50000"


@pytest.mark.parametrize(
    ("name", "value", "wanted"),
    [
        *(("--port", text, PORT) for text in ("0", "65536", "9" * 5000)),
        *(("--sample", text, PAIRS) for text in ("50001", "many")),
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


@pytest.mark.parametrize("host", ["nonsense.invalid", "..", "1.2.3.4"])
def test_a_host_that_is_not_this_machine_is_refused_in_a_sentence(capsys, host):
    assert "--host" in refusal(capsys, "--host", host)


def test_a_head_or_set_that_is_not_there_is_refused_in_a_sentence(capsys, tmp_path):
    assert "No head at" in refusal(capsys, "--head", tmp_path / "none")
    assert "No head at" in refusal(capsys, "--compare", tmp_path)
    assert "No embeddings file" in refusal(capsys, "--embeddings", tmp_path / "none")


def test_a_folder_that_try_wrote_is_its_head_with_its_set_unless_another_is_named(tmp_path):
    for name in ("head/settings.json", "set.safetensors", "other.safetensors"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).touch()
    for more, shown in (
        ((), "set"),
        (("--embeddings", str(tmp_path / "other.safetensors")), "other"),
    ):
        chosen = parser().parse_args(["--head", str(tmp_path), *more])
        find_files(chosen)
        assert (chosen.head, chosen.embeddings.stem) == (tmp_path / "head", shown)
    chosen = parser().parse_args(["--head", str(tmp_path / "head")])
    find_files(chosen)
    assert chosen.embeddings is None
