"""Source-side evidence: held-out objects, and sensors imitated by one move of all pairs."""

import numpy as np
import pytest

from omnivat.kit.errors import DataError
from omnivat.training.selection import evidence, shift


def test_held_out_objects_are_whole_and_all_pairs_are_on_one_side(source):
    part, (rest, *shifted) = evidence(source)
    fit, held = part.rows["object"], rest.rows["object"]
    assert len(shifted) == 12 and all(one.rows["object"] == held for one in shifted)
    assert not set(fit) & set(held)
    assert len(fit) + len(held) == len(source)


def test_an_imitated_sensor_moves_all_pairs_alike(source):
    """Differences between pairs are stretched axis by axis, the same everywhere."""
    moved = shift(source, source, seed=3, kind="axes")
    ratio = (moved.tac[1:] - moved.tac[0]) / (source.tac[1:] - source.tac[0])
    stretch, offset = np.median(ratio, 0), moved.tac.mean(0) - source.tac.mean(0)
    np.testing.assert_allclose(ratio, np.broadcast_to(stretch, ratio.shape), rtol=0.02)
    assert 0.5 <= stretch.min() < 0.8 and 1.2 < stretch.max() <= 1.5
    assert 0.6 < (offset / source.tac.std(0)).std() < 1.5


def test_a_move_along_the_spread_stays_where_the_source_has_any(source):
    """Its offset lies in the span of the source's own differences, and is as long as one."""
    moved = shift(source, source, seed=3, kind="spread")
    centred = source.tac - source.tac.mean(0)
    offset = moved.tac.mean(0) - source.tac.mean(0)
    _, values, basis = np.linalg.svd(centred, full_matrices=False)
    inside = basis[values > 1e-3 * values[0]] @ offset
    np.testing.assert_allclose(np.linalg.norm(inside), np.linalg.norm(offset), rtol=1e-3)
    assert 0.2 < np.linalg.norm(offset) / np.sqrt((centred**2).sum(1).mean()) < 5


def test_a_source_of_single_objects_gives_no_evidence(source):
    one_each = source.select(np.array([0, 16, 32]))
    with pytest.raises(DataError, match="one object only"):
        evidence(one_each)
