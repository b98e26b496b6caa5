"""Bring single files of a Git repository at one commit, and nothing else of it.

A partial clone without blobs lists the files; the wanted blobs then come in batches, and Git checks
each by its hash. What arrived stays when the work stops, so a later call goes on from there.
"""

import os
import shutil
import subprocess
from collections.abc import Iterable, Iterator, Mapping, Sequence
from fnmatch import fnmatchcase
from pathlib import Path

from omnivat.kit.errors import DataError, MissingPackageError, WriteError, printable
from omnivat.kit.progress import OnStep, Step, ignore

BATCH = 200  # blobs of one request
# of a repository on this machine, which may not be set up to serve single files
SERVING = "git -c uploadpack.allowFilter=true -c uploadpack.allowAnySHA1InWant=true upload-pack"
MOST_BYTES = 300_000_000  # of one file
OPTIONS = {  # nothing of the repository runs, and a silent server is given up
    "core.hooksPath": os.devnull,
    "gc.auto": "0",
    "http.lowSpeedLimit": "1000",
    "http.lowSpeedTime": "60",
    "fetch.negotiationAlgorithm": "noop",
}
REASONS = {  # in what Git writes, in small letters -> what to do
    "no space left": (
        "the disk is full; free some space and run the command again, what arrived is kept"
    ),
    "could not resolve host": (
        "there is no way to that host; check the network and run the command again"
    ),
    "could not resolve proxy": "the proxy is unknown; check the network and run the command again",
    "failed to connect": "nothing replies there; check the network and run the command again",
    "connection refused": "nothing replies there; check the network and run the command again",
    "timed out": "nothing replies there; check the network and run the command again",
    "repository not found": "no repository is there now; name another copy with --from",
    "could not read username": "no public repository is there now; name another copy with --from",
    "does not appear to be a git repository": (
        "no repository is there; name another copy with --from"
    ),
    "does not exist": "no repository is there; name another copy with --from",
    "not allowed": "only https and files of this machine are read; name such a copy with --from",
    "not our ref": "it lacks the commit {commit}, or a file of it; name another copy with --from",
}


class DamagedError(DataError):
    """Git stopped for a reason that may lie in what arrived earlier."""


class Repository:
    """A bare partial clone of `source`, an https URL or a path, in `folder`, at `commit`.

    Of an earlier run's folder only objects stay, whose hashes are checked: settings, hooks and
    references are written anew, because anybody may have put that folder there.

    Raises MissingPackageError without Git, DataError or WriteError (one sentence) if the commit
    does not arrive.
    """

    def __init__(self, source: str, commit: str, folder: Path) -> None:
        if shutil.which("git") is None:
            raise MissingPackageError(
                "Git is not installed, and it brings the files; install it (https://git-scm.com)."
            )
        self.source, self.commit, self.folder = source, commit, folder
        place = Path(source).expanduser()
        self.local = place.absolute() if place.exists() else None
        folder.mkdir(parents=True, exist_ok=True)
        for stale in (*folder.iterdir(), folder / "objects" / "info"):
            if stale.name != "objects":
                remove(stale)
        self._git("init", "--quiet", "--bare", "--template=")
        remote = {
            "url": self.local.as_uri() if self.local else source,
            "promisor": "true",
            "partialclonefilter": "blob:none",
            **({"uploadpack": SERVING} if self.local else {}),
        }
        for name, value in remote.items():
            self._git("config", f"remote.origin.{name}", value)
        if any(path.is_file() for path in (folder / "objects").rglob("*")):
            self._git("fsck", "--no-dangling", "--no-progress")
        self._fetch("--depth=1", commit)

    def files(self, patterns: Iterable[str]) -> dict[str, str]:
        """Return path -> hash of the files that match a pattern, such as "data/*.jpg"; * matches
        / too.
        """
        wanted = tuple(patterns)
        listed = self._run(self._command("ls-tree", "-r", "-z", self.commit))
        found = {}
        for line in filter(None, listed.decode(errors="backslashreplace").split("\0")):
            about, _, path = line.partition("\t")
            mode, _, name = about.split()
            if mode.startswith("100") and any(fnmatchcase(path, pattern) for pattern in wanted):
                found[path] = name
        return found

    def bring(self, hashes: Iterable[str], on_step: OnStep = ignore) -> set[str]:
        """Fetch the blobs that are not here yet; return those that a source on this machine lacks.

        Git refuses a blob whose content has another hash.
        """
        wanted = set(hashes)
        absent = wanted - self._present()
        lacking = self._lacking(absent)
        missing = sorted(absent - lacking)
        for k in range(0, len(missing), BATCH):
            on_step(Step(done=len(wanted) - len(missing) + k, total=len(wanted), text="files"))
            self._fetch("--stdin", into="\n".join(missing[k : k + BATCH]) + "\n")
        return lacking

    def contents(self, hashes: Mapping[str, str]) -> Iterator[tuple[str, bytes]]:
        """Yield path and content of files that were brought, by path -> hash.

        Raises DataError for one over 300 MB.
        """
        form = "--batch-check=%(objectsize)"
        sizes = self._git("cat-file", form, into="\n".join(hashes.values()) + "\n").splitlines()
        for (path, name), size in zip(hashes.items(), sizes, strict=True):
            if not size.isdigit() or int(size) > MOST_BYTES:
                raise DataError(f"'{path}' of '{self.source}' is missing or over 300 MB.")
            yield path, self._run(self._command("cat-file", "blob", name))

    def _present(self) -> set[str]:
        form = "--batch-check=%(objectname)"
        return set(self._git("cat-file", "--batch-all-objects", "--unordered", form).split())

    def _lacking(self, hashes: set[str]) -> set[str]:
        """Return the blobs that a source on this machine lacks, as a partial copy does."""
        if self.local is None or not hashes:
            return set()
        command = ["git", "-C", str(self.local), "cat-file", "--batch-check"]
        said = self._run(command, "\n".join(hashes) + "\n").decode().splitlines()
        return {line.split()[0] for line in said if line.endswith(" missing")}

    def _fetch(self, *arguments: str, into: str = "") -> None:
        quiet = (
            "--quiet",
            "--no-tags",
            "--no-write-fetch-head",
            "--recurse-submodules=no",
            "--filter=blob:none",
        )
        self._git("fetch", *quiet, "origin", *arguments, into=into)

    def _command(self, *arguments: str) -> list[str]:
        settings = [part for name, value in OPTIONS.items() for part in ("-c", f"{name}={value}")]
        return ["git", f"--git-dir={self.folder}", *settings, *arguments]

    def _git(self, *arguments: str, into: str = "") -> str:
        return os.fsdecode(self._run(self._command(*arguments), into))

    def _run(self, command: Sequence[str], into: str = "") -> bytes:
        done = subprocess.run(command, input=into.encode(), capture_output=True, env=_environment())
        if done.returncode:
            raise self._error(os.fsdecode(done.stderr))
        return done.stdout

    def _error(self, said: str) -> DataError | WriteError:
        """Return the error of one sentence for what Git wrote."""
        low = said.lower()
        reason = next((text for sign, text in REASONS.items() if sign in low), "")
        if "no space" in low or ("permission denied" in low and "publickey" not in low):
            return WriteError(
                f"'{self.folder.parent}' cannot be written: {reason or 'permission denied'}."
            )
        lines = [line for line in said.splitlines() if line.startswith(("fatal:", "error:"))]
        last = printable((lines or said.splitlines() or ["no reason"])[0])[:160]
        kind = DataError if reason else DamagedError
        reason = reason or f"Git stopped ({last}); run the command again"
        return kind(f"'{self.source}' was not fetched: {reason.format(commit=self.commit[:7])}.")


def remove(path: Path) -> None:
    """Remove a file, a link or a folder, if it is there; what a link names stays."""
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path)
    else:
        path.unlink(missing_ok=True)


def _environment() -> dict[str, str]:
    """Return the environment of Git: English, no questions, no repository of the caller, no file
    that was not requested, and no transport that runs a command.
    """
    kept = {
        name: value
        for name, value in os.environ.items()
        if not name.startswith("GIT_") or "SSL" in name
    }
    own = {"GIT_TERMINAL_PROMPT": "0", "GIT_ASKPASS": "true", "GIT_NO_LAZY_FETCH": "1"}
    return kept | own | {"GIT_ALLOW_PROTOCOL": "https:file", "LC_ALL": "C.UTF-8"}
