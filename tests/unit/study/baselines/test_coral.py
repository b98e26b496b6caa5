"""CORAL between modalities: what its weight does."""

import torch

from omnivat.study.baselines.classics import coral_loss, fitted_coral
from omnivat.study.baselines.contract import Source


def test_a_larger_weight_brings_the_covariances_of_the_modalities_closer():
    random = torch.Generator().manual_seed(0)
    labels = torch.arange(3).repeat_interleave(10)
    vis, tac = (torch.randn(30, 12, generator=random) * width for width in (3.0, 1.0))
    source = Source(
        vis=vis,
        tac=tac + 4 * torch.randn(1, 12, generator=random),
        labels=labels,
        objects=tuple(map(str, range(30))),
        classes=("wood", "steel", "glass"),
    )
    distances = []
    for weight in (0.0, 10.0, 1000.0):
        hidden = fitted_coral(source, weight).features(source.vis, source.tac)
        distances.append(float(coral_loss(hidden["vis"], hidden["tac"])))
    assert distances[0] > distances[1] > distances[2]
