"""Occlusion: the parts of an image that a prediction depends on."""

from io import BytesIO

import pytest
from PIL import Image

from app.occlusion import CELLS, PATCH, hidden, occlusion, over_cells
from app.state import Ref
from omnivat.errors import DataError


def test_each_part_is_hidden_once_in_the_mean_colour_and_the_rest_is_left():
    image = Image.new("RGB", (70, 70), "black")
    image.paste("white", (0, 0, 35, 70))
    parts = list(hidden(image))
    assert len(parts) == (CELLS - PATCH + 1) ** 2
    assert parts[0].getpixel((1, 1)) == image.resize((1, 1)).getpixel((0, 0))
    assert parts[0].getpixel((30, 30)) == (255, 255, 255)
    assert image.getpixel((1, 1)) == (255, 255, 255)


def test_a_cell_gets_the_mean_of_the_parts_that_covered_it():
    steps = CELLS - PATCH + 1
    falls = [[0.0] * steps for _ in range(steps)]
    falls[0][0] = 1.0
    cells = over_cells(falls)
    assert cells[0][0] == 1.0  # covered by that part alone
    assert cells[0][1] == 0.5
    assert cells[1][1] == 0.25
    assert sum(cells[3]) == 0


def test_an_image_of_one_colour_has_nothing_to_hide(resources):
    with BytesIO() as handle:
        Image.new("RGB", (32, 32), "gray").save(handle, "PNG")
        found = occlusion(
            resources, handle.getvalue(), modality="tac", other=Ref("row", "3"), order=None
        )
    assert max(abs(drop) for row in found["drops"] for drop in row) < 1e-6
    assert found["class"] in resources.head().settings.classes


def test_hiding_parts_of_a_varied_image_changes_the_answer(resources, png):
    found = occlusion(resources, png(), modality="vis", other=None, order=0.5)
    assert max(abs(drop) for row in found["drops"] for drop in row) > 1e-5


def test_another_modality_is_refused(resources, png):
    with pytest.raises(DataError, match="it is vis or tac"):
        occlusion(resources, png(), modality="lang", other=None, order=None)
