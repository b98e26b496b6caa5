"""Tac3D fields as images: zero is grey, one scale, bad files left out."""

import numpy as np
import pytest
from PIL import Image

from omnivat.data.tac3d import draw_all, field_to_rgb, load_field, robust_scale

RANDOM = np.random.default_rng(0)
ONE = np.ones(3)


def save(path, array):
    np.save(path, array)
    return path


def test_axes_are_colours_and_signs_are_bright_and_dark():
    field = np.zeros((20, 20, 3))
    field[..., 0], field[..., 2] = 1.0, -1.0
    assert (field_to_rgb(field, ONE)[112, 112] == (255, 128, 0)).all()
    assert (field_to_rgb(field, 2 * ONE)[112, 112] == (191, 128, 64)).all()


def test_the_scale_of_each_axis_covers_99_percent_and_ignores_a_wild_value():
    field = np.tile([0.1, -0.1, 0.8], (20, 20, 1))  # drag and depth
    field[0, 0, 0] = 1000.0
    np.testing.assert_allclose(robust_scale([field]), [0.1, 0.1, 0.8])


def test_a_list_of_400_markers_is_the_same_field(tmp_path):
    field = RANDOM.normal(size=(20, 20, 3)).astype(np.float32)
    square = load_field(save(tmp_path / "a.npy", field))
    listed = load_field(save(tmp_path / "b.npy", field.reshape(400, 3)))
    np.testing.assert_array_equal(square, listed)


@pytest.mark.parametrize(
    "array",
    [
        np.zeros((20, 20)),
        np.zeros((60, 20)),
        np.full((20, 20, 3), np.nan),
        np.full((20, 20, 3), "x"),
        np.full((20, 20, 3), {"a": 1}),  # a pickle, which is never opened
    ],
)
def test_another_array_is_no_field(tmp_path, array):
    file = save(tmp_path / "a.npy", array)
    assert load_field(file) is None
    file.write_bytes(file.read_bytes()[:9])
    assert load_field(file) is None


def test_one_scale_serves_all_fields(tmp_path):
    weak = save(tmp_path / "weak.npy", np.full((20, 20, 3), 1.0))
    strong = save(tmp_path / "strong.npy", np.full((20, 20, 3), 4.0))
    broken = tmp_path / "broken.npy"
    broken.write_bytes(b"")
    drawn = draw_all([weak, strong, broken], tmp_path / "out")
    assert Image.open(drawn[weak]).getpixel((100, 100)) == (159, 159, 159)
    assert Image.open(drawn[strong]).getpixel((100, 100)) == (255, 255, 255)
    assert drawn.keys() == {weak, strong}
