"""Labels and object numbers as short text."""

import base64

import numpy as np
import pytest
from scipy.special import softmax

from omnivat.data.packing import compact, digits, odds, packed, unpacked
from omnivat.kit.errors import DataError


def test_ascending_runs_are_written_as_their_ends_and_read_again():
    numbers = [3, 4, 5, 9, 9, 1]
    assert compact(numbers) == "3-5 9 9 1" and unpacked("3-5 9 9 1") == numbers


def test_a_class_above_nine_is_a_letter():
    assert digits([0, 9, 10, 61]) == "09aZ"


def test_packed_logits_give_the_probabilities_back_to_half_precision():
    logits = np.random.default_rng(0).normal(size=(5, 3)) * 4 + 100
    kept = np.frombuffer(base64.b64decode(odds(logits)), "<f2").reshape(5, 2)
    found = softmax(np.pad(kept.astype(float), ((0, 0), (0, 1))), axis=1)
    np.testing.assert_allclose(found, softmax(logits, axis=1), atol=2e-3)


def test_numbers_are_packed_in_steps_and_what_is_not_finite_is_refused():
    record = packed(np.array([0.0, 0.26, -1.5]), "i2", 100)
    whole = np.frombuffer(base64.b64decode(record["data"]), f"<{record['kind']}")
    np.testing.assert_array_equal(whole / record["steps"], [0, 0.26, -1.5])
    with pytest.raises(DataError, match="not finite numbers; its weights are damaged"):
        packed(np.array([0.0, np.inf]), "i2")
