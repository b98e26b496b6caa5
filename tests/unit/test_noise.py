"""Noise on embeddings in training."""

import numpy as np
import pytest
import torch

from omnivat.errors import SettingsError
from omnivat.train import TrainSettings
from omnivat.train.batches import batches


def drawn(source, **changes):
    """Return one batch of all pairs in a fixed order of drawing."""
    settings = TrainSettings(batch=len(source), lang=False, **changes)
    return next(batches(source, source.label, np.arange(len(source)), None, settings, 5))


def test_noise_is_white_and_in_standard_deviations_of_each_channel(make_embeddings):
    source = make_embeddings(per_class=200, domains=("TAG-sim",))
    plain, noisy = (drawn(source, noise=noise) for noise in (0.0, 2.0))
    added = (noisy.vis - plain.vis).numpy() / source.vis.std(0)
    assert np.allclose(added.std(0), 2, rtol=0.1) and np.allclose(added.mean(0), 0, atol=0.3)
    assert abs(np.corrcoef(added[:, 0], added[:, 1])[0, 1]) < 0.1
    assert not torch.equal(noisy.tac - plain.tac, noisy.vis - plain.vis)


def test_noise_leaves_what_else_is_drawn_as_it_was(make_embeddings):
    plain, noisy = (drawn(make_embeddings(), noise=noise) for noise in (0.0, 1.0))
    for name in ("labels", "lang_on", "token_on"):
        assert torch.equal(getattr(plain, name), getattr(noisy, name))


def test_noise_below_zero_is_refused():
    with pytest.raises(SettingsError, match="noise is -1"):
        TrainSettings(noise=-1.0)
