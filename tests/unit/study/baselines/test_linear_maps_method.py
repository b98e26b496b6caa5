"""Linear maps as a method of the table: the noise is chosen on the source alone."""

from dataclasses import replace

import torch

from omnivat.study.baselines import linear_maps
from omnivat.study.baselines.contract import Source


def source():
    random = torch.Generator().manual_seed(0)
    labels = torch.arange(36) % 3
    rows = torch.eye(3).repeat(1, 4)[labels] * 2
    return Source(
        vis=rows + torch.randn(36, 12, generator=random),
        tac=rows + torch.randn(36, 12, generator=random),
        labels=labels,
        objects=tuple(f"{label}/{k // 6}" for k, label in enumerate(labels.tolist())),
        classes=("wood", "steel", "glass"),
    )


def test_the_chosen_noise_is_told_and_another_seed_keeps_it(monkeypatch):
    chosen = linear_maps.fit(source()).chosen["training noise"]
    assert chosen in linear_maps.CANDIDATES

    def again(part):
        raise AssertionError("chosen again")

    monkeypatch.setattr(linear_maps, "_chosen", again)
    for noise in linear_maps.CANDIDATES:
        fitted = linear_maps.fit(replace(source(), settled=(noise,), seed=1))
        assert fitted.chosen == {"training noise": noise}


def test_the_choice_is_made_on_objects_that_the_maps_did_not_see(monkeypatch):
    learned = []
    fit = linear_maps._fitted

    def watched(part, noise):
        learned.append(set(part.objects))
        return fit(part, noise)

    monkeypatch.setattr(linear_maps, "_fitted", watched)
    linear_maps.fit(source())
    *choosing, final = learned
    assert final == set(source().objects)
    assert len(choosing) == len(linear_maps.CANDIDATES)
    assert all(part < final for part in choosing)
