"""Linear maps of photo, touch and both, averaged, over standardised rows
(`omnivat.head.linear_maps`).

Training noise is chosen on the source alone: on held-out objects as imitated sensors see them
(`omnivat.training.selection`). Held-out objects as they are would favour none.
"""

from itertools import product

import numpy as np
import torch

from omnivat.head.linear_maps import FittedMaps, fit_maps
from omnivat.kit.seeding import derive_seed
from omnivat.study.baselines.contract import Fitted, Source, joined
from omnivat.study.baselines.descent import size
from omnivat.study.baselines.evidence import folds
from omnivat.training.selection import KINDS, SHIFTS, imitated

CANDIDATES = {"none": (0.0, 0.0), "noise 4, shift 1": (4.0, 1.0)}  # white noise, common offset


def fit(source: Source) -> Fitted:
    """Train the maps on a source, standardised by its own profile."""
    settled = [name for name in CANDIDATES if name in source.settled]
    noise = settled[0] if settled else _chosen(source)
    fitted = _fitted(source, noise)
    return Fitted(
        predict=lambda vis, tac: fitted({"vis": vis, "tac": tac}),
        features=lambda vis, tac: joined(**fitted.standard({"vis": vis, "tac": tac})),
        chosen={"training noise": noise},
        parameters=size(fitted.maps),
    )


def _fitted(source: Source, noise: str) -> FittedMaps:
    white, shift = CANDIDATES[noise]
    seed = derive_seed(source.seed, "linear maps")
    classes = len(source.classes)
    return fit_maps(source.images, source.labels, classes, noise=white, shift=shift, seed=seed)


def _chosen(source: Source) -> str:
    """Return the noise with most right predictions of held-out pairs under imitated sensors."""
    right = dict.fromkeys(CANDIDATES, 0)
    for rows, held in folds(source, repeats=1):
        part, rest = source.select(rows), source.select(held)
        models = {noise: _fitted(part, noise) for noise in CANDIDATES}
        for kind, number in product(KINDS, range(SHIFTS)):
            random = np.random.default_rng(derive_seed(source.seed, kind, number))
            raw = {
                name: torch.from_numpy(
                    imitated(values.numpy(), part.images[name].numpy(), random, kind)
                )
                for name, values in rest.images.items()
            }
            for noise, model in models.items():
                right[noise] += int((model(raw)["fused"].argmax(-1) == rest.labels).sum())
    return max(right, key=right.__getitem__)
