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
import sys
import app, omnivat
from app.shared.resources import Resources
from omnivat.cli import main
from omnivat.head.heads import EXAMPLES, shipped_sets
from omnivat.notebook import explore
print(omnivat.__file__, app.__file__, EXAMPLES, sep="\\n")
print(*shipped_sets())
print(len(omnivat.load_embeddings(omnivat.default_embeddings())))
print(len(explore().page))
sys.exit(main(sys.argv[1:]))
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


def test_installed_library_page_and_command_find_the_shipped_files_in_any_folder(site):
    photo = next((site / "omnivat_examples" / "pairs").rglob("*_vis.*"))
    touch = photo.with_name(photo.name.replace("_vis", "_tac"))
    environment = os.environ | {"PYTHONPATH": str(site), "OMNIVAT_CACHE": str(site / "cache")}
    done = subprocess.run(
        [sys.executable, "-c", LOOK, "predict", str(photo), str(touch), "--json"],
        capture_output=True, text=True, timeout=900, cwd=site.parent, env=environment,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    *places, sets, pairs, letters, answer = done.stdout.split("\n", 6)
    assert len(places) == 3 and all(place.startswith(str(site)) for place in places)
    assert "sensors" in sets.split() and int(pairs) > 1000 and int(letters) > 1_000_000
    answer = json.loads(answer)
    assert answer["prediction"] in answer["probabilities"]
