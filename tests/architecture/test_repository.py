"""The repository: sizes, leaks of local paths, and documents that match the code."""

import json
import re
import runpy
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
TEXT = {".py", ".md", ".toml", ".txt", ".js", ".css", ".json", ".jsonl", ".csv", ".html", ".sh", ""}


def tracked():
    done = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True)
    if done.returncode:
        pytest.skip("not a git checkout")
    return [path for name in done.stdout.splitlines() if (path := ROOT / name).is_file()]


def test_examples_stay_below_59_mb_and_other_binaries_below_8():
    examples = ROOT / "examples"
    sizes = {True: 0, False: 0}
    for path in tracked():
        if path.is_relative_to(examples) or path.suffix not in TEXT:
            sizes[path.is_relative_to(examples)] += path.stat().st_size
    assert sizes[True] < 59e6 and sizes[False] < 8e6


LOCAL = re.compile(rb"/(?<![\w.]/)(?:work|root|home/\w+)/")


def test_no_committed_file_names_a_path_of_one_machine():
    """Headers of binary files, too."""
    leaks = [
        f"{path.relative_to(ROOT)}: {match.group()!r}"
        for path in tracked()
        for match in LOCAL.finditer(path.read_bytes())
    ]
    assert leaks == []


def test_no_source_file_is_longer_than_300_lines_of_code():
    long = {}
    for path in tracked():
        if path.suffix == ".py" and path.parts[len(ROOT.parts)] in ("omnivat", "app"):
            code = [
                line
                for line in path.read_text(encoding="utf-8").splitlines()
                if line.strip() and not line.strip().startswith("#")
            ]
            if len(code) > 300:
                long[path.relative_to(ROOT)] = len(code)
    assert long == {}


def test_every_command_is_in_the_readme():
    from omnivat.cli import COMMANDS

    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    assert [name for name in COMMANDS if f"omnivat {name}" not in readme] == []


def test_the_picture_of_the_wings_is_what_the_imports_give():
    drawn = runpy.run_path(str(ROOT / "docs" / "wings.py"))["picture"]()
    assert (ROOT / "docs" / "wings.svg").read_text(encoding="utf-8") == drawn, (
        "run: python docs/wings.py"
    )


def test_every_stage_has_a_title_on_the_page():
    from omnivat.kit.stages import STAGE_TITLES, STAGES

    rows = (ROOT / "app" / "web" / "shared" / "tables.json").read_text(encoding="utf-8")
    titled = [row["id"] for row in json.loads(rows)["stages"] if row["title"]]
    assert tuple(STAGE_TITLES) == STAGES == tuple(k for k in titled if k in STAGES)


def broken_links(path):
    """Return the links of a document whose file, or whose heading in it, is not there."""
    broken = []
    for target in re.findall(r"\]\(([^)\s]+)\)", path.read_text(encoding="utf-8")):
        name, _, anchor = target.partition("#")
        file = path.parent / name if name else path
        if ":" in target:  # another host
            continue
        headings = (
            re.findall(r"^#+ (.+)$", file.read_text("utf-8"), re.M)
            if anchor and file.is_file()
            else []
        )
        slugs = {
            re.sub(r"[^\w -]", "", text).strip().lower().replace(" ", "-") for text in headings
        }
        if not file.exists() or (anchor and anchor not in slugs):
            broken.append(f"{path.name} -> {target}")
    return broken


def test_links_between_documents_lead_somewhere():
    documents = [path for path in tracked() if path.suffix == ".md"]
    assert len(documents) > 30 and [link for path in documents for link in broken_links(path)] == []
