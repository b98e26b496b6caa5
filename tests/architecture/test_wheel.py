"""The wheel works where there is no checkout: library, page and examples are inside."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PARTS = ("omnivat", "app", "examples", "pyproject.toml", "setup.py", "README.md", "LICENSE")

pytestmark = pytest.mark.slow
LOOK = """
import app, omnivat
from app.shared.resources import Resources
from omnivat.head.heads import EXAMPLES, shipped_sets
from omnivat.notebook import explore
print(omnivat.__file__, app.__file__, EXAMPLES, sep="\\n")
print(*shipped_sets())
print(len(omnivat.load_embeddings(omnivat.default_embeddings())))
print(len(explore().page))
"""


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """A folder with what the wheel installs, and nothing of the checkout beside it."""
    source, site = tmp_path_factory.mktemp("source"), tmp_path_factory.mktemp("wheel") / "site"
    for part in PARTS:
        (source / part).symlink_to(ROOT / part)
    build = [sys.executable, "setup.py", "-q", "build", "--build-lib", str(site)]
    subprocess.run(build, cwd=source, check=True, timeout=900)
    return site


def run(site, *arguments):
    """Return what `python ...` prints with the wheel's content alone on the path."""
    environment = os.environ | {"PYTHONPATH": str(site), "OMNIVAT_CACHE": str(site / "cache")}
    done = subprocess.run(
        [sys.executable, *arguments],
        capture_output=True, text=True, timeout=900, cwd=site.parent, env=environment,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_an_installed_command_predicts_a_shipped_pair(site):
    photo = next((site / "omnivat_examples" / "pairs").rglob("*_vis.*"))
    touch = next(photo.parent.glob(photo.name.replace("_vis", "_tac")))
    answer = json.loads(run(site, "-m", "omnivat", "predict", str(photo), str(touch), "--json"))
    assert answer["prediction"] in answer["probabilities"]


def test_the_installed_library_and_page_find_the_shipped_sets_and_explore_in_any_folder(site):
    printed = run(site, "-c", LOOK)
    *places, sets, pairs, letters = printed.splitlines()
    assert len(places) == 3 and all(place.startswith(str(site)) for place in places)
    assert "sensors" in sets.split() and int(pairs) > 1000 and int(letters) > 1_000_000
