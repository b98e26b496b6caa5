"""The wheel works where there is no checkout: library, page and examples are inside."""

import json
import os
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PARTS = ("omnivat", "app", "examples", "pyproject.toml", "setup.py", "README.md", "LICENSE")

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """A folder with what the wheel installs, and nothing of the checkout beside it."""
    folder = tmp_path_factory.mktemp("wheel")
    source = folder / "source"
    source.mkdir()
    for part in PARTS:
        if (ROOT / part).is_dir():
            shutil.copytree(
                ROOT / part, source / part, ignore=shutil.ignore_patterns("__pycache__")
            )
        else:
            shutil.copy(ROOT / part, source / part)
    build = [sys.executable, "-m", "pip", "wheel", "--no-deps", "--no-build-isolation", "-q"]
    subprocess.run([*build, "-w", str(folder), str(source)], check=True, timeout=900)
    with zipfile.ZipFile(next(folder.glob("*.whl"))) as wheel:
        wheel.extractall(folder / "site")
    shutil.rmtree(source)
    return folder / "site"


def run(site, *arguments):
    """Return what `python ...` prints with the wheel's content alone on the path."""
    environment = os.environ | {"PYTHONPATH": str(site), "OMNIVAT_CACHE": str(site / "cache")}
    done = subprocess.run(
        [sys.executable, *arguments],
        capture_output=True, text=True, timeout=900, cwd=site.parent, env=environment,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_the_installed_library_is_the_one_that_runs(site):
    printed = run(site, "-c", "import omnivat, app; print(omnivat.__file__, app.__file__)")
    assert printed.count(str(site)) == 2


def test_an_installed_command_finds_the_shipped_head_and_set(site):
    record = json.loads(run(site, "-m", "omnivat", "gaps", "--stage", "f_hat", "--json"))
    assert record["pairs"] > 1000


def test_an_installed_command_predicts_a_shipped_pair(site):
    photo = next((site / "omnivat_examples" / "pairs").rglob("*_vis.*"))
    touch = next(photo.parent.glob(photo.name.replace("_vis", "_tac")))
    answer = json.loads(run(site, "-m", "omnivat", "predict", str(photo), str(touch), "--json"))
    assert answer["prediction"] in answer["probabilities"]


def test_the_page_finds_its_scripts_and_sets(site):
    code = (
        "from app.resources import Resources; from omnivat.head.heads import EXAMPLES,"
        " shipped_sets;print(EXAMPLES, *shipped_sets())"
    )
    printed = run(site, "-c", code)
    assert "omnivat_examples" in printed and "sensors" in printed


def test_explore_opens_in_a_notebook_of_any_folder(site):
    code = "from omnivat.notebook import explore; print(len(explore().page))"
    assert int(run(site, "-c", code)) > 1_000_000
