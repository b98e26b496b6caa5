"""The lock file names every package that the application asks for, in a version that fits, with
a hash.
"""

import re
from pathlib import Path

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name as plain
from packaging.version import Version

ROOT = Path(__file__).resolve().parents[2]
LINE = re.compile(r"^([A-Za-z0-9._-]+)==([^ \\]+)", re.MULTILINE)


def locked(text):
    """Return name -> version of the packages that a lock file names."""
    return {plain(name): Version(version) for name, version in LINE.findall(text)}


def requirements():
    lines = (ROOT / "requirements.txt").read_text(encoding="utf-8").splitlines()
    kept = [line.split("#")[0].strip() for line in lines]
    return [Requirement(line) for line in kept if line and not line.startswith("-")]


def test_every_requirement_is_locked_in_a_version_that_fits():
    packages = locked((ROOT / "requirements.lock").read_text(encoding="utf-8"))
    for wanted in requirements():
        version = packages[plain(wanted.name)]
        assert wanted.specifier.contains(version, prereleases=True), f"{wanted} {version}"


def test_every_locked_package_has_a_hash():
    text = (ROOT / "requirements.lock").read_text(encoding="utf-8")
    entries = re.findall(r"^\S+==\S+ \\\n    --hash=sha256:[0-9a-f]{64}$", text, re.MULTILINE)
    assert len(entries) == len(locked(text)) > 20


def test_pillow_is_one_that_resolves_its_advisories_on_damaged_images():
    pillow = next(one for one in requirements() if one.name == "pillow")
    assert not pillow.specifier.contains("12.2.0")
