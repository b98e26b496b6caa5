"""Familiarity: the nearest training image, read against the training set's own distances."""

import pytest
import torch
from torch.nn.functional import normalize

from omnivat.head.calibration import (
    familiarity_of,
    load_familiarity,
    nearest_cosines,
    quantile_of,
    save_familiarity,
)
from omnivat.kit.errors import DataError


@pytest.fixture(scope="module")
def images():
    random = torch.Generator().manual_seed(0)
    centre = torch.randn(32, generator=random)
    return [centre + 0.5 * torch.randn(200, 32, generator=random) for _ in ("vis", "tac")]


def own_objects(count):
    return [str(i) for i in range(count)]


def test_the_nearest_cosines_are_the_largest_of_all_and_one_in_ten():
    rows, reference = torch.eye(3), normalize(torch.tensor([[1.0, 1.0, 0.0], [0.0, 0.0, 5.0]]))
    expected = torch.tensor([0.5**0.5, 0.5**0.5, 1.0])
    torch.testing.assert_close(nearest_cosines(rows, reference)[:, 0], expected)
    assert [nearest_cosines(rows, torch.rand(n, 3)).shape[1] for n in (2, 25, 100, 500)] == [
        *(1, 2, 10, 10)
    ]


def test_a_training_image_is_familiar_and_noise_is_not(images):
    found = familiarity_of(*images, own_objects(200))
    (known,) = found.look(images[0][:1], None)
    assert known["vis"] == {
        "cosine": 1.0,
        "quantile": known["vis"]["quantile"],
        "words": "familiar",
    }
    strange = torch.randn(1, 32, generator=torch.Generator().manual_seed(9))
    (unknown,) = found.look(strange, strange)
    assert unknown["vis"]["quantile"] == 0 == unknown["tac"]["quantile"]
    assert unknown["vis"]["words"] == "unlike the training images"


def test_pictures_of_the_same_object_do_not_count_as_neighbours(images):
    """Two nearly equal pictures an object would otherwise make all else look strange."""
    # of fewer than twenty pictures, one neighbour counts
    vis = images[0][:9].repeat_interleave(2, dim=0) + 1e-4
    one = familiarity_of(vis, None, [str(i // 2) for i in range(18)])
    two = familiarity_of(vis, None, own_objects(18))
    assert one.quantiles["vis"].max() < 0.999 < two.quantiles["vis"].min()


def test_a_quantile_is_where_a_value_stands():
    quantiles = torch.tensor([0.0, 0.2, 0.4, 1.0])
    values = torch.tensor([-1.0, 0.0, 0.1, 0.4, 0.7, 1.0, 2.0])
    expected = torch.tensor([0, 0, 1 / 6, 2 / 3, 5 / 6, 1, 1])
    torch.testing.assert_close(quantile_of(values, quantiles), expected)


def test_a_large_set_keeps_two_thousand_rows_at_most():
    found = familiarity_of(torch.randn(4002, 4), None, own_objects(4002))
    assert len(found.rows["vis"]) == 4002 / 3


def test_one_object_is_refused_and_two_are_enough():
    with pytest.raises(DataError, match="two objects or more"):
        familiarity_of(torch.randn(3, 4), None, ["same"] * 3)
    assert "vis" in familiarity_of(torch.randn(3, 4), None, ["same", "same", "other"]).quantiles


def test_the_training_rows_come_back(images, tmp_path):
    save_familiarity(tmp_path / "file.safetensors", familiarity_of(*images, own_objects(200)))
    again = load_familiarity(tmp_path / "file.safetensors", 32)
    for name, rows in zip(("vis", "tac"), images, strict=True):
        torch.testing.assert_close(again.rows[name], normalize(rows, dim=-1), atol=1e-3, rtol=1e-3)


@pytest.mark.parametrize("spoilt", ["rows", "quantiles"])
@pytest.mark.parametrize("value", [float("nan"), 2.0])
def test_rows_that_are_no_unit_vectors_and_quantiles_that_are_no_numbers_are_refused(
    images, tmp_path, spoilt, value
):
    found = familiarity_of(*images, own_objects(200))
    getattr(found, spoilt)["tac"][3] = value
    save_familiarity(tmp_path / "file.safetensors", found)
    if spoilt == "quantiles" and value == 2.0:
        assert load_familiarity(tmp_path / "file.safetensors", 32)
    else:
        with pytest.raises(DataError, match="copy the head folder again"):
            load_familiarity(tmp_path / "file.safetensors", 32)
