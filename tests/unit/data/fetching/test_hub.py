"""`hf:OWNER/NAME`, with a stand-in for the client of the model hub."""

import shutil
from types import SimpleNamespace

import pytest

from omnivat.cli import main
from omnivat.data.readers import read_pairs
from tests.unit.data.test_stored import written_by_datasets

hub = pytest.importorskip("huggingface_hub")
errors = pytest.importorskip("huggingface_hub.errors")
ABSENT = {  # what the client raises
    ("lab/none", None): errors.RepositoryNotFoundError,
    ("lab/gated", None): errors.GatedRepoError,
    ("lab/press", "v9"): errors.RevisionNotFoundError,
}


@pytest.fixture
def commits(tmp_path, monkeypatch):
    """Two commits of lab/press, by revision; the second renames the file of the first."""
    monkeypatch.setenv("OMNIVAT_CACHE", str(tmp_path / "cache"))
    for commit, shard in (("1" * 40, "00001"), ("2" * 40, "00002")):
        file = f"train-00000-of-{shard}.parquet"
        written_by_datasets(tmp_path / "hub" / commit / "data" / file)
    found = {None: "1" * 40, "v2": "2" * 40}

    def info(_, name, *, repo_type, revision):
        if kind := ABSENT.get((name, revision)):
            raise kind.__new__(kind)
        return SimpleNamespace(sha=found[revision])

    def download(name, *, revision, local_dir, **_):
        shutil.copytree(tmp_path / "hub" / revision, local_dir)

    monkeypatch.setattr(hub.HfApi, "repo_info", info)
    monkeypatch.setattr(hub, "snapshot_download", download)
    return found


def brought(name, out):
    return main(["import", name, "--out", str(out), "--vis", "wrist"])


def test_a_data_set_arrives_and_a_new_commit_of_it_leaves_no_old_files(commits, tmp_path):
    for name in ("hf:lab/press", "hf:lab/press@v2"):
        out = tmp_path / name[-2:]
        assert brought(name, out) == 0
        found = [(p.domain, p.split, p.object) for p in read_pairs(out).pairs]
        assert len(found) == 4
        assert set(found) == {("press", "train", "mug"), ("press", "train", "fork")}


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("hf:lab/none", "there is none of that name, or it is private: check the name"),
        ("hf:lab/gated", "accept its terms on its page, and log in with `hf auth login`"),
        ("hf:lab/press@v9", "it has no such revision: check what follows the @"),
        ("hf:press", "write it as hf:OWNER/NAME"),
    ],
)
def test_a_set_that_does_not_arrive_is_one_sentence(commits, tmp_path, capsys, name, words):
    assert brought(name, tmp_path / "out") == 1
    told = capsys.readouterr().err
    assert words in told and "Traceback" not in told and not (tmp_path / "out").exists()


@pytest.mark.parametrize("commit", [None, "../../../../x"])
def test_a_commit_that_is_none_is_one_sentence_and_names_no_folder(
    commits, tmp_path, capsys, commit
):
    commits[None] = commit
    before = sorted(tmp_path.rglob("*"))
    assert brought("hf:lab/press", tmp_path / "out") == 1
    told = capsys.readouterr().err
    assert "states no commit" in told and told.count("\n") == 1
    assert sorted(tmp_path.rglob("*")) == before
