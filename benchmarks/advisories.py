"""Compare the locked packages with known advisories, without a network: `python -m
benchmarks.advisories FILE`.

FILE has advisories in the OSV format, one JSON object or a list of them. Exits with 1 if a locked
version is affected, or a package is not locked.
"""

import argparse
import json
import re
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from packaging.version import InvalidVersion, Version

LOCK = Path(__file__).resolve().parents[1] / "requirements.lock"
LINE = re.compile(r"^([A-Za-z0-9._-]+)==([^ \\]+)", re.MULTILINE)


def locked(text: str) -> dict[str, Version]:
    """Return name -> version of the packages that a lock file names."""
    return {plain(name): Version(version) for name, version in LINE.findall(text)}


def plain(name: str) -> str:
    """Return a package's normalized name."""
    return re.sub(r"[-_.]+", "-", name).lower()


def affected(
    packages: Mapping[str, Version], advisories: list[Mapping[str, Any]]
) -> Iterator[tuple[str, str]]:
    """Yield package and advisory for each affected locked version."""
    for advisory in advisories:
        if advisory.get("withdrawn"):
            continue
        for entry in advisory.get("affected", []):
            package = entry.get("package", {})
            name = plain(str(package.get("name", "")))
            version = packages.get(name)
            if package.get("ecosystem") == "PyPI" and version is not None and hit(version, entry):
                yield name, str(advisory.get("id", "an advisory without a name"))


def hit(version: Version, entry: Mapping[str, Any]) -> bool:
    """True if an advisory's entry includes this version, by name or by range."""
    if any(_version(text) == version for text in entry.get("versions", [])):
        return True
    return any(
        within(version, span["events"])
        for span in entry.get("ranges", [])
        if span.get("type") == "ECOSYSTEM"
    )


def within(version: Version, events: list[Mapping[str, str]]) -> bool:
    """Whether a version lies in a range of OSV events: introduced, fixed, last_affected."""
    inside = False
    for event in events:
        (what, text), *_ = event.items()
        at = _version(text)
        if at is None:
            return True  # unreadable: prefer a false warning
        if what == "introduced" and version >= at:
            inside = True
        if (what == "fixed" and version >= at) or (what == "last_affected" and version > at):
            inside = False
    return inside


def _version(text: str) -> Version | None:
    try:
        return Version(text)
    except InvalidVersion:
        return None


def main(arguments: list[str] | None = None) -> int:
    """Print what is affected."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("advisories", type=Path, nargs="+", help="files in the OSV format")
    parser.add_argument("--lock", type=Path, default=LOCK)
    chosen = parser.parse_args(arguments)
    packages = locked(chosen.lock.read_text(encoding="utf-8"))
    known: list[Mapping[str, Any]] = []
    for file in chosen.advisories:
        found = json.loads(file.read_text(encoding="utf-8"))
        known += found if isinstance(found, list) else [found]
    hits = sorted(set(affected(packages, known)))
    for name, advisory in hits:
        print(f"{name} {packages[name]} is affected by {advisory}")
    print(f"{len(packages)} locked packages, {len(known)} advisories, {len(hits)} affected")
    return int(bool(hits))


if __name__ == "__main__":
    sys.exit(main())
