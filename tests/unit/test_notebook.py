"""Explore in a notebook cell."""

import html
import re

import pytest

from omnivat.data.store import load_embeddings
from omnivat.head.checkpoint import load_head
from omnivat.kit.errors import DataError, SettingsError
from omnivat.notebook import Cell, explore


@pytest.mark.slow
def test_a_cell_holds_the_whole_page_of_a_head_and_a_set_in_memory(
    head_folder, tmp_path, monkeypatch
):
    monkeypatch.setenv("OMNIVAT_CACHE", str(tmp_path))
    pairs = load_embeddings(head_folder.parent / "set.safetensors")
    cell = explore(load_head(head_folder), pairs, height=640)
    shown = cell._repr_html_()
    assert shown.startswith("<iframe srcdoc=")
    assert "height:640px" in shown
    page = html.unescape(re.search(r'srcdoc="([^"]*)"', shown)[1])
    assert page == cell.page
    assert not re.findall(r'(?:src|href)="(?!data:|#)[^"]+"', page)
    assert "omnivat-held" in page and "80 VIS-TAC pairs" in page
    assert cell.save(tmp_path / "lecture.html").read_text(encoding="utf-8") == page


def test_a_frame_cannot_reach_the_notebook():
    assert 'sandbox="allow-scripts allow-downloads"' in Cell("<p>x</p>", 300)._repr_html_()
    assert "<script>" not in Cell("<script>x</script>", 300)._repr_html_()


def test_a_height_that_is_none_and_a_head_that_is_not_there_are_refused(tmp_path):
    with pytest.raises(SettingsError, match="height is 5; choose 300 to 4000"):
        explore(height=5)
    with pytest.raises(DataError, match="is missing, so there is no map"):
        explore(tmp_path / "none", tmp_path / "none.safetensors")
