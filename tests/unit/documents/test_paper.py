"""The report to cite: it has the length and parts of its form, cites what it lists, and builds."""

import importlib.util
import re
import shutil
from pathlib import Path

import pytest

PAPER = Path(__file__).resolve().parents[3] / "paper"
TEXT = (PAPER / "paper.md").read_text(encoding="utf-8")
PARTS = (
    "Summary",
    "Statement of need",
    "State of the field",
    "What it does",
    "What it found",
    "Limits",
    "Acknowledgements",
    "References",
)


def test_it_has_the_parts_of_its_form_in_at_most_1200_words():
    assert tuple(re.findall(r"^# (.*)$", TEXT, re.M)) == PARTS
    body = TEXT.split("---", 2)[2]
    assert 750 <= len(body.split()) <= 1200


def test_every_entry_of_the_bibliography_is_cited_and_every_citation_has_one():
    entries = set(
        re.findall(r"^@\w+\{(\w+),", (PAPER / "paper.bib").read_text(encoding="utf-8"), re.M)
    )
    assert set(re.findall(r"@(\w+)", TEXT.split("---", 2)[2])) == entries


def test_its_two_figures_are_committed():
    figures = re.findall(r"\]\((\.\./docs/[^)]+)\)", TEXT)
    assert len(figures) == 2 and all((PAPER / name).resolve().is_file() for name in figures)


@pytest.fixture
def build():
    """Return the module paper/build.py."""
    pytest.importorskip("pypandoc")
    spec = importlib.util.spec_from_file_location("build", PAPER / "build.py")
    assert spec and spec.loader
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_it_becomes_one_page_with_its_references_and_pictures(build, tmp_path, monkeypatch):
    monkeypatch.setattr(build, "BROWSERS", ())  # the PDF is the browser's print of this page
    (page,) = build.build(tmp_path)
    html = page.read_text(encoding="utf-8")
    assert "Revisiting Batch Normalization" in html and "[@" not in html
    assert html.count("<figure") == 2 and "../docs" not in html


@pytest.mark.browser
def test_its_page_prints_to_a_pdf(build, tmp_path):
    if not any(map(shutil.which, build.BROWSERS)):
        pytest.skip("no browser to print with")
    _, sheet = build.build(tmp_path)
    assert sheet.read_bytes().startswith(b"%PDF")
