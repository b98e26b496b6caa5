"""Linear maps: what they learn from, what they repeat, and what a profile does."""

import numpy as np
import pytest
import torch

from omnivat.data.profile import channels_of, moved, standardised
from omnivat.head.linear_maps import _disturbed, fit_maps, standard_rows


@pytest.fixture
def raw():
    """Photos tell class 0 from the rest, touches tell class 1 from the rest."""
    random = torch.Generator().manual_seed(0)
    labels = torch.arange(60) % 3
    rows = {n: 3 + torch.randn(60, 12, generator=random) for n in ("vis", "tac")}
    rows["vis"][:, 0] += 8 * (labels == 0)
    rows["tac"][:, 1] += 8 * (labels == 1)
    return rows, labels


def right(shares, labels):
    return float((shares.argmax(-1) == labels).float().mean())


def test_both_images_tell_what_neither_does_alone(raw):
    rows, labels = raw
    shares = fit_maps(rows, labels, 3)(rows)
    assert set(shares) == {"vis", "tac", "fused"}
    assert right(shares["fused"], labels) > 0.95
    assert max(right(shares["vis"][labels != 0], labels[labels != 0]), 0.5) < 0.9
    for values in shares.values():
        torch.testing.assert_close(values.sum(-1), torch.ones(60))


def test_noise_is_fresh_and_has_the_size_of_each_channel():
    rows = torch.randn(400, 30, generator=torch.Generator().manual_seed(0)) * torch.arange(1.0, 31)
    profile, random = channels_of(rows.numpy()), torch.Generator().manual_seed(0)
    assert torch.equal(_disturbed(rows, profile, 0, 0, random), rows)
    first, second = (_disturbed(rows, profile, 2, 0, random) - rows for _ in range(2))
    assert not torch.equal(first, second)
    torch.testing.assert_close(first.std(0), 2 * rows.std(0), rtol=0.15, atol=0)
    offsets = _disturbed(rows, profile, 0, 1, random) - rows
    torch.testing.assert_close(offsets.std(0), rows.std(0), rtol=0.2, atol=0)


def test_rows_are_those_of_a_head_at_the_length_of_a_network(raw):
    rows, _ = raw
    profile = channels_of(rows["vis"].numpy())
    mine = standard_rows(rows["vis"], profile).numpy()
    theirs = standardised(rows["vis"].numpy(), profile)
    theirs = theirs / np.linalg.norm(theirs, axis=1, keepdims=True) * 12**0.5
    np.testing.assert_allclose(mine, theirs, rtol=1e-5)


def test_a_profile_brings_back_what_an_offset_costs(raw):
    rows, labels = raw
    fitted = fit_maps(rows, labels, 3)
    far = {n: x * 3 + 40 for n, x in rows.items()}
    near = {
        n: torch.from_numpy(moved(x.numpy(), channels_of(x.numpy()), fitted.profile[n])).float()
        for n, x in far.items()
    }
    assert right(fitted(far)["fused"], labels) < 0.7 < 0.9 < right(fitted(near)["fused"], labels)


def test_one_modality_has_one_map(raw):
    rows, labels = raw
    fitted = fit_maps({"tac": rows["tac"]}, labels, 3)
    assert set(fitted.maps.maps) == {"tac"}
    shares = fitted({"tac": rows["tac"]})
    torch.testing.assert_close(shares["fused"], shares["tac"])
