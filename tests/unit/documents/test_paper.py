"""The report to cite: it has the length and parts of its form, cites what it lists, and builds."""

import importlib.util
import shutil
from pathlib import Path

import pytest

PAPER = Path(__file__).resolve().parents[3] / "paper"


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
