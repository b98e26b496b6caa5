"""The maps of the third chapter: all touches of the twins as they come, and moved two ways."""

import base64
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import torch
from sklearn.neighbors import NearestNeighbors

from benchmarks._twins_heads import Array, head_of, rows_of, unit
from omnivat.data.embeddings import Embeddings
from omnivat.data.profile import channels_of
from omnivat.maps.projection import pca, torch_umap
from omnivat.measure.twins import Twins


def moved(rows: Array) -> tuple[Array, Array, Array]:
    """Return rows (N, S, W) of S sensors three ways: as they come, with each sensor's mean moved
    onto the common mean, and with mean and spread moved. All are in units of the common spread.
    """
    flat = rows.reshape(-1, rows.shape[-1])
    as_they_come = (rows - flat.mean(0)) / (flat.std(0) + 1e-6)
    centred = as_they_come - as_they_come.mean(0)
    return as_they_come, centred, centred / (centred.std(0) + 1e-6)


def own_twin(rows: Array) -> Array:
    """Return (S, S): how many of N presses by one sensor have their own twin as nearest press by
    another, a share.
    """
    sensors = rows.shape[1]
    found = np.ones((sensors, sensors))
    for other in range(sensors):
        near = NearestNeighbors(n_neighbors=1).fit(rows[:, other])
        for first in range(sensors):
            if first != other:
                nearest = near.kneighbors(rows[:, first], return_distance=False)[:, 0]
                found[first, other] = (nearest == np.arange(len(rows))).mean()
    return found


def threads(made: Twins, learning: Embeddings) -> dict[str, Any]:
    """Return the contents of `examples/twins.map.json`: maps of all touches (dots as printed) in
    the three ways of `moved`.

    label     a digit for each press: its class
    pca, umap  by way: positions of press 0 by sensor 0 to S - 1, then of press 1, ...; in base64,
              little-endian 16-bit pairs of one box for the three ways. UMAP goes on from the map
              of the way before
    own_twin  [sensor][way]: share of presses whose nearest press by another sensor is their own
              twin, mean of the others
    gap       by way: distance between the means of two sensors' unit rows, mean over pairs of
              sensors
    accuracy  by way: share right on another sensor, mean over sources and targets, of a head on
              standardised rows that is given the mean, or mean and spread, of all presses
    """
    rows = rows_of({"tac": made.tac}, "touch")
    ways = moved(rows)
    points = [torch.from_numpy(way.reshape(-1, way.shape[-1])).float() for way in ways]
    basis = pca.basis(torch.cat(points))
    flat = [basis.place(some).numpy() for some in points]
    chained: list[Array] = []
    for some in points:
        start = torch.from_numpy(chained[-1]) if chained else None
        chained.append(torch_umap.project(some, start=start).numpy())
    near = [own_twin(way) for way in ways]
    away = ~np.eye(rows.shape[1], dtype=bool)
    return {
        "presses": len(rows),
        "label": "".join(map(str, made.label)),
        "pca": packed(flat),
        "umap": packed(chained),
        "own_twin": [
            [round(float(w[s][away[s]].mean()), 3) for w in near] for s in range(rows.shape[1])
        ],
        "own_twin_mean": [round(float(w[away].mean()), 3) for w in near],
        "gap": [round(gap(way), 3) for way in ways],
        "accuracy": accuracies(made, rows, learning),
    }


def packed(maps: Sequence[Array]) -> list[str]:
    """Return maps (N, 2) as 16-bit positions in their common box, in base64."""
    every = np.concatenate(maps)
    low, size = every.min(0), np.ptp(every, axis=0).max()
    return [
        base64.b64encode(((m - low) / size * 65_535).round().astype("<u2").tobytes()).decode()
        for m in maps
    ]


def gap(rows: Array) -> float:
    """Return the mean distance between the mean unit rows of two sensors."""
    means = unit(rows).mean(0)
    apart = np.linalg.norm(means[:, None] - means, axis=-1)
    return float(apart[np.triu_indices(len(means), 1)].mean())


def accuracies(made: Twins, rows: Array, learning: Embeddings) -> list[float]:
    """Return the mean accuracy on other sensors: touches as they come, with each sensor's mean
    aligned, and with mean and variance aligned.

    rows  (presses, sensors, D) embeddings of the twins' touches
    """
    found = []
    for source, name in enumerate(made.header.domains):
        head = head_of(learning, name, "touch")
        tested = np.isin(made.label, head.model.classes_)
        for target in range(rows.shape[1]):
            if target != source:
                seen = channels_of(rows[:, target])
                for known in (None, replace(seen, variance=head.own.variance), seen):
                    right = head.answers(rows[:, target], known) == made.label
                    found.append(right[tested].mean())
    return [round(float(v), 3) for v in np.reshape(found, (-1, 3)).mean(0)]
