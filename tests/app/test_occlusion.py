"""Occlusion: the parts of an image that a prediction depends on."""

from itertools import product
from types import SimpleNamespace

import numpy as np
import torch
from PIL import Image

from app.pair.pictures import CELLS, PATCH, STEPS, hidden, occlusion, over_cells
from app.shared.requests import FILES


def test_each_part_is_hidden_once_in_the_mean_colour_and_the_rest_is_left():
    image = Image.effect_noise((45, 71), 90).convert("RGB")
    mean = image.resize((1, 1))
    pixels, colour = (torch.from_numpy(np.array(one)) for one in (image, mean))
    found = iter(hidden(pixels[None], colour).numpy())
    for top, left in product(range(STEPS), repeat=2):
        pasted = image.copy()
        right, bottom = (left + PATCH) * 45 // CELLS, (top + PATCH) * 71 // CELLS
        pasted.paste(mean.getpixel((0, 0)), (left * 45 // CELLS, top * 71 // CELLS, right, bottom))
        np.testing.assert_array_equal(next(found), pasted)
    assert next(found, None) is None


def test_a_cell_gets_the_mean_of_the_parts_that_covered_it():
    cells = over_cells(torch.eye(STEPS**2)[0])
    assert cells[0][0] == 1.0  # covered by that part alone
    assert cells[0][1] == 0.5
    assert cells[1][1] == 0.25
    assert cells[2:].sum() == 0


def test_a_prediction_from_the_upper_right_falls_there_and_nowhere_else():
    """A head that reads one cell: the mean brightness of row 0, column 5."""

    class Encoder:
        def preprocess(self, image):
            return torch.from_numpy(np.array(image.convert("L"))).float()  # (H, W)

        def embed(self, pixels):
            return pixels[:, :10, 50:60].mean((1, 2))[:, None] / 255

    def model(vis, tac, order):
        return SimpleNamespace(probabilities=torch.cat((vis, 1 - vis), dim=1))

    settings = SimpleNamespace(classes=("bright", "dark"))
    head = SimpleNamespace(model=model, settings=settings, familiarity=None)
    image = Image.new("RGB", (70, 70), "black")
    image.paste("white", (50, 0, 60, 10))
    decoder = SimpleNamespace(read=lambda *arguments: SimpleNamespace(image=image))
    resources = SimpleNamespace(
        shared=SimpleNamespace(decoder=decoder),
        reader=lambda name, lamps: Encoder(),
        head_named=lambda name: head,
    )
    found = occlusion(resources, {"modality": "vis", FILES: [b""]})
    drops = found["drops"]
    assert found["class"] == "bright"
    assert drops[0][5] == max(max(row) for row in drops) > 0.4
    assert not any(drops[row][column] for row in range(3, CELLS) for column in range(3))
