"""Gaps and retrieval in the features of a ladder's head, for `benchmarks.gap_predicts`."""

from typing import Any

import numpy as np
import torch
from torch import Tensor

from benchmarks._ladder_methods import Array, rows_of
from omnivat.data.embeddings import Embeddings
from omnivat.kit.stages import IMAGES
from omnivat.maps.sweep.walk import stage_features
from omnivat.measure.gaps.centroid import centroid_gap
from omnivat.measure.gaps.unit import unit

STAGES = ("relu", "f_bar", "f_hat")
Space = dict[str, dict[str, list[float]]]  # domain -> stage -> MEASURED
MEASURED = ("modality gap", "domain gap", "rank", "class found")


@torch.inference_mode()
def space(model: Any, embeddings: Embeddings, source: Array, tested: Array) -> Space:
    """Return gaps and retrieval of every domain's test pairs; each image with the other one absent.

    modality gap  distance of the mean directions of photos and touches
    domain gap    the same between a domain and the source's training pairs, mean of both images
    rank          of a photo's own touch among those of its domain, by cosine, mean: 0 first, 1 last
    class found   share of photos whose nearest touch has their class
    """
    home, found = _rows(model, embeddings, source), {}
    for index, name in enumerate(embeddings.header.domains):
        own = tested[embeddings.domain[tested] == index]
        here = _rows(model, embeddings, own)
        label = torch.from_numpy(embeddings.label[own])
        found[name] = {s: _measured(here[s], home[s], label) for s in STAGES}
    return found


def _rows(model: Any, embeddings: Embeddings, rows: Array) -> dict[str, dict[str, Tensor]]:
    vis, tac = (torch.from_numpy(np.asarray(x, np.float32)) for x in rows_of(embeddings, rows))
    outputs = {"vis": model(vis, None), "tac": model(None, tac)}
    return {stage: {name: stage_features(one, stage)[name] for name, one in outputs.items()} for stage in STAGES}


def _measured(here: dict[str, Tensor], home: dict[str, Tensor], label: Tensor) -> list[float]:
    cosines = unit(here["vis"]) @ unit(here["tac"]).T
    right = cosines.diagonal()[:, None]
    ranks = (cosines > right).sum(1) + ((cosines == right).sum(1) - 1) / 2
    same = label[cosines.argmax(1)] == label
    values = (
        float(centroid_gap(here["vis"], here["tac"])),
        float(np.mean([float(centroid_gap(here[n], home[n])) for n in IMAGES])),
        float(ranks.mean() / (len(label) - 1)),
        float(same.double().mean()),
    )
    return [round(value, 4) for value in values]
