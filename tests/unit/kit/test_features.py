"""Arrays at the library's door: any numbers are taken, and a bad one is named by row and column."""

import pytest
import torch

from omnivat import centroid_gap
from omnivat.kit.errors import OmniVatError
from omnivat.kit.shapes import SUMMED, features
from omnivat.maps.projection.neighbours import nearest

ROWS = torch.rand(40, 12, generator=torch.Generator().manual_seed(0))


def test_no_query_has_no_neighbours():
    found = nearest(ROWS, 3, queries=ROWS[:0])
    assert found.index.shape == found.distance.shape == (0, 3)


def test_rows_keep_their_values_gradient_and_precision():
    (rows,) = features(rows=ROWS.half())
    assert rows.dtype == torch.float32 and torch.equal(rows, ROWS.half().float())
    rows, wide = features(rows=ROWS, wide=ROWS.double())
    assert rows.dtype == wide.dtype == torch.float64
    learned = ROWS.clone().requires_grad_()
    centroid_gap(learned, ROWS.flip(0) + 1).backward()
    assert learned.grad is not None
    assert features(most=SUMMED, rows=ROWS * 1e14)[0].max() > 1e13
    with pytest.raises(OmniVatError, match="expected at most 1e.15"):
        features(most=SUMMED, rows=ROWS * 1e17)
