"""Fetching sets of others: whole, truncated, changed, interrupted, from local bare repositories."""

import csv
import json
import os
import shutil
import subprocess
import zlib
from dataclasses import replace
from io import BytesIO
from types import SimpleNamespace
from zipfile import ZipFile

import numpy as np
import pytest
from PIL import Image

from omnivat.cli import main
from omnivat.data import fetching
from omnivat.data.fetching import fetch, fetched_sets, repository
from omnivat.data.fetching.repository import Repository
from omnivat.data.images import read_image
from omnivat.data.readers import read_pairs
from omnivat.kit.errors import (
    DataError,
    MissingNameError,
    MissingPackageError,
    SettingsError,
    WriteError,
)
from omnivat.study import trial

pytestmark = pytest.mark.skipif(shutil.which("git") is None, reason="needs Git")
NAME, COUNT = "digit-parts", 6


def git(folder, *arguments):
    names = {
        f"GIT_{who}_{what}": "a@b.c"
        for who in ("AUTHOR", "COMMITTER")
        for what in ("NAME", "EMAIL")
    }
    done = subprocess.run(
        ["git", "-C", str(folder), *arguments],
        check=True,
        capture_output=True,
        text=True,
        env=os.environ | names,
    )
    return done.stdout.strip()


@pytest.fixture
def server(tmp_path, monkeypatch):
    """A bare repository in the layout of the set, and the table with its commit."""
    work, bare = tmp_path / "work", tmp_path / "server"
    random = np.random.default_rng(0)
    for k in range(COUNT):
        file = work / "data" / f"part_{k % 2}" / f"interaction_{k:04d}.jpg"
        file.parent.mkdir(parents=True, exist_ok=True)
        Image.fromarray(random.integers(0, 255, (32, 32, 3), dtype=np.uint8)).save(file)
    (work / "data" / "part_0" / "interaction_0099.jpg").symlink_to("/etc/passwd")
    git(tmp_path, "init", "-q", str(work))
    git(work, "add", ".")
    git(work, "commit", "-qm", "files")
    git(tmp_path, "clone", "-q", "--bare", str(work), str(bare))
    for name in ("allowFilter", "allowAnySHA1InWant"):
        git(bare, "config", f"uploadpack.{name}", "true")
    pin(monkeypatch, git(work, "rev-parse", "HEAD"))
    return bare


def pin(monkeypatch, commit):
    table = {name: replace(one, commit=commit) for name, one in fetched_sets().items()}
    monkeypatch.setattr(fetching, "fetched_sets", lambda: table)


def unpacked(server):
    """Return the loose blobs of the pictures in the server, to damage them."""
    for pack in list((server / "objects" / "pack").glob("*.pack")):
        moved = pack.rename(server / pack.name)
        with moved.open("rb") as content:
            subprocess.run(
                ["git", "-C", str(server), "unpack-objects", "-q"], check=True, stdin=content
            )
    names = [
        line.split()[2]
        for line in git(server, "ls-tree", "-r", "HEAD").splitlines()
        if "jpg" in line
    ]
    return [server / "objects" / name[:2] / name[2:] for name in names]


def left(folder):
    return sorted(path.name for path in folder.parent.iterdir() if "out" in path.name)


def test_a_set_arrives_as_a_folder_of_pairs_with_its_terms(server, tmp_path):
    out = fetch(NAME, tmp_path / "out", source=str(server))
    pairs = read_pairs(out)
    assert len(pairs.pairs) == COUNT and pairs.materials() == ("part 0", "part 1")
    assert {pair.vis for pair in pairs.pairs} == {pair.tac for pair in pairs.pairs}, "touch alone"
    rows = list(csv.DictReader((out / "pairs.csv").read_text().splitlines()))
    original = git(server, "cat-file", "-s", f"HEAD:{rows[0]['tac_from']}")
    assert (out / rows[0]["tac"]).stat().st_size == int(original)
    words = (out / "TERMS.txt").read_text()
    assert fetched_sets()[NAME].terms_from in words and str(server) in words
    assert json.loads((out / "fetched.json").read_text())["pairs"] == COUNT
    assert left(out) == ["out"], "the clone goes when the folder is complete"


def test_another_folder_is_never_replaced(server, tmp_path):
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "mine.txt").write_text("mine")
    with pytest.raises(WriteError, match="name a new folder"):
        fetch(NAME, tmp_path / "out", source=str(server))
    assert (tmp_path / "out" / "mine.txt").read_text() == "mine"


def test_an_interrupted_fetch_leaves_no_folder_and_goes_on_later(server, tmp_path, monkeypatch):
    monkeypatch.setattr(repository, "BATCH", 2)
    steps = []

    def stop(step):
        steps.append(step)
        if step.done == 4:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        fetch(NAME, tmp_path / "out", source=str(server), on_step=stop)
    assert left(tmp_path / "out") == [".out.part"]
    for name in ("config.lock", "shallow.lock"):  # as a killed Git leaves them
        (tmp_path / ".out.part" / "repository" / name).touch()
    steps.clear()
    fetch(NAME, tmp_path / "out", source=str(server), on_step=steps.append)
    assert [step.done for step in steps if step.text == "files"] == [4], "four files had arrived"
    assert len(read_pairs(tmp_path / "out").pairs) == COUNT


PLANTED = """
[core]
    repositoryformatversion = 0
    bare = true
    fsmonitor = touch {ran}
[protocol "ext"]
    allow = always
[url "ext::touch {ran} "]
    insteadOf = file://
[alias]
    fetch = !touch {ran}
"""


def plant(clone, ran):
    """Write a clone whose settings, hooks, attributes and links run or reach something else."""
    git(clone.parent.parent, "init", "-q", "--bare", str(clone))
    (clone / "config").write_text(PLANTED.format(ran=ran))
    hook = clone / "hooks" / "reference-transaction"
    hook.parent.mkdir(exist_ok=True)
    hook.write_text(f"#!/bin/sh\ntouch {ran}\n")
    hook.chmod(0o755)
    (clone / "info").mkdir(exist_ok=True)
    (clone / "info" / "attributes").write_text("* filter=x\n")


def test_a_planted_folder_runs_nothing_and_the_set_arrives(server, tmp_path):
    clone, ran = tmp_path / ".out.part" / "repository", tmp_path / "ran"
    clone.mkdir(parents=True)
    plant(clone, ran)
    away = tmp_path / "away"
    away.mkdir()
    (tmp_path / ".out.part" / "unpacked").symlink_to(away)
    fetch(NAME, tmp_path / "out", source=str(server))
    assert len(read_pairs(tmp_path / "out").pairs) == COUNT
    assert not ran.exists() and away.is_dir() and not list(away.iterdir())


@pytest.mark.parametrize("source", ["ext::touch ran", "ssh://127.0.0.1/x", "http://127.0.0.1:9/x"])
def test_a_transport_other_than_https_and_file_is_refused(tmp_path, monkeypatch, source):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(DataError, match="only https and files of this machine"):
        fetch(NAME, tmp_path / "out", source=source)
    assert not (tmp_path / "ran").exists()


def test_a_damaged_unfinished_folder_is_fetched_anew(server, tmp_path, monkeypatch):
    def stop(step):
        if step.done == 4:
            raise KeyboardInterrupt

    monkeypatch.setattr(repository, "BATCH", 2)
    with pytest.raises(KeyboardInterrupt):
        fetch(NAME, tmp_path / "out", source=str(server), on_step=stop)
    objects = tmp_path / ".out.part" / "repository" / "objects"
    name = git(server, "rev-parse", "HEAD:data/part_0/interaction_0000.jpg")
    for pack in objects.glob("pack/*"):
        pack.unlink()
    (objects / name[:2]).mkdir()
    (objects / name[:2] / name[2:]).write_bytes(zlib.compress(b"blob 4\0evil"))
    out = fetch(NAME, tmp_path / "out", source=str(server))
    assert all(read_image(pair.tac).size == (32, 32) for pair in read_pairs(out).pairs)


def test_a_truncated_repository_is_one_sentence(server, tmp_path):
    unpacked(server)[0].unlink()
    with pytest.raises(DataError, match="lacks the commit .*, or a file of it; name another copy"):
        fetch(NAME, tmp_path / "out", source=server.as_uri())
    assert left(tmp_path / "out") == [".out.part"]


def test_a_changed_file_is_one_sentence(server, tmp_path):
    first, second = unpacked(server)[:2]
    first.chmod(0o644)
    first.write_bytes(second.read_bytes())
    with pytest.raises(DataError, match=r"Git stopped \(.*\); run the command again\.$"):
        fetch(NAME, tmp_path / "out", source=str(server))
    assert not (tmp_path / "out").exists()


def test_a_copy_here_without_some_files_gives_the_other_pairs_and_names_what_it_lacks(
    server, tmp_path, monkeypatch
):
    git(server, "config", "uploadpack.allowFilter", "false")
    blobs = unpacked(server)
    blobs[0].unlink()
    out = fetch(NAME, tmp_path / "out", source=str(server))
    record = json.loads((out / "fetched.json").read_text())
    assert len(read_pairs(out).pairs) == record["pairs"] == COUNT - 1
    assert [path.startswith("data/part_") for path in record["lacking"]] == [True]
    assert (
        f"{COUNT - 1} of {COUNT} pairs: that copy lacks 1 files" in (out / "TERMS.txt").read_text()
    )
    for blob in blobs[1:]:
        blob.unlink()
    with pytest.raises(DataError, match=f"no pairs of {NAME} at .*: it lacks {COUNT} files"):
        fetch(NAME, tmp_path / "none", source=str(server))
    for path in ("data/part_0/interaction_0000.jpg", "README.md"):
        monkeypatch.setitem(fetching.LAYOUTS, NAME, lambda _, text, path=path: [text(path)])
        with pytest.raises(DataError, match=f"lacks the file {path}; name another copy"):
            fetch(NAME, tmp_path / "none", source=str(server))
    assert not (tmp_path / "none").exists()


@pytest.mark.parametrize(
    ("source", "words"),
    [
        ("https://127.0.0.1:9/nobody", "check the network"),
        ("file:///nowhere/at/all", "no repository is there"),
    ],
)
def test_a_source_that_does_not_reply_is_one_sentence(tmp_path, source, words, monkeypatch):
    for name in ("https_proxy", "HTTPS_PROXY", "all_proxy", "ALL_PROXY"):
        monkeypatch.delenv(name, raising=False)
    with pytest.raises(DataError, match=words):
        fetch(NAME, tmp_path / "out", source=source)
    assert not (tmp_path / "out").exists()


def test_git_has_the_proxy_and_the_certificates_of_the_caller_and_no_repository_of_theirs(
    monkeypatch,
):
    given = {"https_proxy": "http://proxy", "GIT_SSL_CAINFO": "mine.pem", "GIT_DIR": "/elsewhere"}
    for name, value in given.items():
        monkeypatch.setenv(name, value)
    seen = repository._environment()
    assert [seen.get(name) for name in given] == ["http://proxy", "mine.pem", None]


def test_without_git_the_error_names_it(tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(MissingPackageError, match="Git is not installed"):
        fetch(NAME, tmp_path / "out", source="https://127.0.0.1:9/nobody")


def test_a_full_disk_is_told_before_and_while_files_arrive(tmp_path, monkeypatch, server):
    clone = Repository(str(server), git(server, "rev-parse", "HEAD"), tmp_path / "clone")
    error = clone._error("error: file write error: No space left on device")
    assert isinstance(error, WriteError) and "free some space" in str(error)
    monkeypatch.setattr(shutil, "disk_usage", lambda _: SimpleNamespace(free=1_000_000))
    with pytest.raises(WriteError, match="needs 10 MB while it is fetched, and .* has 1 MB free"):
        fetch(NAME, tmp_path / "out")


def test_an_unknown_set_names_the_known_ones(tmp_path):
    with pytest.raises(MissingNameError, match="Did you mean 'vt60'"):
        fetch("vt6", tmp_path / "out")


def test_the_hub_resumes_by_itself_and_has_no_other_source(tmp_path, monkeypatch):
    import huggingface_hub

    with pytest.raises(SettingsError, match="model hub; --from is a folder with its files"):
        fetch("tacquad", tmp_path / "out", source="elsewhere")

    def refused(*arguments, **named):
        raise OSError("no route")

    monkeypatch.setattr(shutil, "disk_usage", lambda _: SimpleNamespace(free=10**15))
    monkeypatch.setattr(huggingface_hub, "snapshot_download", refused)
    with pytest.raises(DataError, match="no route"):
        fetch("tacquad", tmp_path / "out")
    assert not (tmp_path / "out").exists()


@pytest.fixture
def hub(monkeypatch):
    """A hub that has an archive, cut into parts of 700 bytes as it arrives."""
    import huggingface_hub

    def serve(members, cut=lambda content: content):
        def download(name, *, local_dir, allow_patterns, **_):
            assert name == "xxuan01/TacQuad" and "tacquad.zip.*" in allow_patterns
            with BytesIO() as packed:
                with ZipFile(packed, "w") as archive:
                    for place, content in members.items():
                        archive.writestr(place, content)
                content = cut(packed.getvalue())
            local_dir.mkdir(parents=True, exist_ok=True)
            for k in range(0, len(content), 700):
                part = local_dir / f"tacquad.zip.{k // 700 + 1:03d}"
                part.write_bytes(content[k : k + 700])

        monkeypatch.setattr(huggingface_hub, "snapshot_download", download)
        monkeypatch.setattr(shutil, "disk_usage", lambda _: SimpleNamespace(free=10**15))

    return serve


def picture(seed):
    with BytesIO() as handle:
        colours = np.random.default_rng(seed).integers(0, 255, (24, 24, 3), dtype=np.uint8)
        Image.fromarray(colours).save(handle, "PNG")
        return handle.getvalue()


def test_an_archive_in_parts_becomes_a_folder_that_is_read_as_tacquad(hub, tmp_path):
    halves = [f"tacquad/data_indoor/wood_cup/{half}/{k}.png" for half in ("digit", "img_digit")
              for k in range(3)]  # fmt: skip
    files = {place: picture(k) for k, place in enumerate(halves)}
    hub(files | {"tacquad/contact_indoor.csv": "wood_cup,0,0,0,2,0,0,a cup of wood\n"})
    out = fetch("tacquad", tmp_path / "out")
    assert {(pair.domain, pair.material) for pair in read_pairs(out).pairs} == {
        ("TQ-DIGIT", "wood")
    }
    assert (out / "data_indoor/wood_cup/digit/1.png").read_bytes() == files[halves[1]]
    assert "license: mit" in (out / "TERMS.txt").read_text() and left(out) == ["out"]
    assert fetch("tacquad", out) == out, "it is there"


def test_a_damaged_or_hostile_archive_is_one_sentence_and_writes_nothing_outside(hub, tmp_path):
    hub({"tacquad/contact_indoor.csv": "a" * 2000}, cut=lambda content: content[:-300])
    with pytest.raises(DataError, match="no whole archive"):
        fetch("tacquad", tmp_path / "out")
    hub({"tacquad/readme.txt": "b", "../../escaped.txt": "c"})
    with pytest.raises(DataError, match="has no contact lists"):
        fetch("tacquad", tmp_path / "deep" / "out")
    assert not list(tmp_path.glob("escaped.txt")) and not (tmp_path / "deep" / "out").exists()


def test_the_command_lists_every_set_with_its_terms(capsys):
    assert main(["fetch"]) == 0
    text = capsys.readouterr().out
    for name, one in fetched_sets().items():
        assert f"{name}  " in text and one.said in text and one.source in text


def test_the_command_fails_in_one_sentence(tmp_path, capsys):
    assert main(["fetch", NAME, "--out", str(tmp_path / "b"), "--from", str(tmp_path / "no")]) == 1
    assert capsys.readouterr().err.count("\n") <= 2
    assert main(["fetch", "--out", str(tmp_path / "b")]) == 1


@pytest.mark.slow
def test_trying_a_set_by_name_fetches_it_first(server, tmp_path, monkeypatch, capsys):
    table = {NAME: replace(fetching.fetched_sets()[NAME], source=str(server))}
    monkeypatch.setattr(fetching, "fetched_sets", lambda: table)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(trial, "EPOCHS", 1)
    assert main(["try", NAME, "--no-page", "--encoder", "strip"]) == 0
    assert f"{COUNT} pairs, 1 domain(s): DIGIT" in capsys.readouterr().out
    assert (tmp_path / NAME / "TERMS.txt").is_file() and (
        tmp_path / f"{NAME}-try" / "head"
    ).is_dir()
