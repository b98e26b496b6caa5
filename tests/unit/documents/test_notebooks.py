"""The notebooks run from top to bottom in a folder of their own, and hold no outputs."""

import ast
from pathlib import Path

import pytest

from omnivat.head import linear_maps

FOLDER = Path(__file__).resolve().parents[3] / "docs" / "notebooks"
BOOKS = sorted(FOLDER.glob("*.ipynb"))


def test_there_are_five_notebooks_without_outputs():
    nbformat = pytest.importorskip("nbformat")
    assert len(BOOKS) == 5
    for file in BOOKS:
        book = nbformat.read(file, as_version=4)
        nbformat.validate(book)
        assert not [cell for cell in book.cells if cell.get("outputs")]


@pytest.mark.slow
@pytest.mark.parametrize("file", BOOKS, ids=lambda file: file.stem)
def test_a_notebook_runs_from_top_to_bottom(file, tmp_path, monkeypatch):
    """Its cells are plain Python, which runs here; the last value of a cell is what it shows."""
    nbformat = pytest.importorskip("nbformat")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("OMNIVAT_CACHE", str(tmp_path / "cache"))
    monkeypatch.setattr(linear_maps, "PLAIN_STEPS", 10)
    names, shown = {"__name__": "__main__"}, []
    for cell in nbformat.read(file, as_version=4).cells:
        if cell.cell_type != "code":
            continue
        *body, last = ast.parse(cell.source).body
        if not isinstance(last, ast.Expr):
            body.append(last)
        exec(compile(ast.Module(body, []), file.name, "exec"), names)
        if isinstance(last, ast.Expr):
            shown.append(eval(compile(ast.Expression(last.value), file.name, "eval"), names))
    html = [one._repr_html_() for one in shown if hasattr(one, "_repr_html_")]
    assert html and all("<iframe srcdoc=" in one for one in html)
