"""Noise on embeddings in training."""

import numpy as np
import torch

from omnivat.training import TrainSettings
from omnivat.training.batches import batches


def drawn(source, **changes):
    """Return one batch of all pairs in a fixed order of drawing."""
    settings = TrainSettings(batch=len(source), lang=False, **changes)
    return next(batches(source, source.label, None, settings, 5))


def test_noise_is_white_and_in_standard_deviations_of_each_channel(make_embeddings):
    source = make_embeddings(per_class=200, domains=("TAG-sim",))
    plain, noisy = (drawn(source, noise=noise) for noise in (0.0, 2.0))
    added = (noisy.images["vis"] - plain.images["vis"]).numpy() / source.vis.std(0)
    assert np.allclose(added.std(0), 2, rtol=0.1) and np.allclose(added.mean(0), 0, atol=0.3)
    assert abs(np.corrcoef(added[:, 0], added[:, 1])[0, 1]) < 0.1
    assert not torch.equal(
        noisy.images["tac"] - plain.images["tac"], noisy.images["vis"] - plain.images["vis"]
    )


def test_a_shift_moves_all_pairs_of_a_batch_by_one_offset_for_each_modality(make_embeddings):
    source = make_embeddings(domains=("TAG-sim",))
    plain, shifted = (drawn(source, shift=shift) for shift in (0.0, 1.0))
    photos, touches = (
        shifted.images["vis"] - plain.images["vis"],
        shifted.images["tac"] - plain.images["tac"],
    )
    assert torch.allclose(photos, photos[:1].expand_as(photos), atol=1e-5)
    assert photos.norm() > 1 and not torch.allclose(photos, touches, atol=0.1)


def test_shifts_spread_like_the_pairs_of_the_source(make_embeddings):
    source = make_embeddings(domains=("TAG-sim",), width=4)
    settings = TrainSettings(batch=1, lang=False, shift=3.0)
    offsets = []
    for seed in range(20):
        for one in (settings, TrainSettings(batch=1, lang=False)):
            every = batches(source, source.label, None, one, seed)
            offsets.append(torch.cat([batch.images["vis"] for batch in every]))
    moves = torch.cat([a - b for a, b in zip(offsets[::2], offsets[1::2], strict=True)]).numpy()
    wanted = 9 * np.cov(source.vis.T, ddof=0)
    assert np.abs(np.cov(moves.T) - wanted).max() < 0.15 * np.abs(wanted).max()
