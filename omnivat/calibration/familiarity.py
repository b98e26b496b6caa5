"""Familiarity: distance of an image to the training images, relative to their own distances.

The distance is the cosine in E, the encoder's space, to the nearest training image of the modality.
A cosine alone means little, so it is compared with the training set: the cosine of each training
image to the nearest image of another object. A quantile of 0.02 means that 98 % of the training
images have a closer neighbour.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import torch
from torch import Tensor
from torch.nn.functional import normalize

from omnivat.errors import DataError

MOST_ROWS = 2000  # training images for each modality; bounds the file and the search
QUANTILES = 101
CHUNK = 512
WORDS = ((0.05, "unlike the training images"), (0.25, "unusual"), (2.0, "familiar"))


@dataclass(frozen=True, slots=True, kw_only=True)
class Familiarity:
    """Training images as unit vectors, and the quantiles of their nearest cosines.

    rows       modality -> (N, D) unit rows
    quantiles  modality -> (101,) ascending cosines, from quantile 0 to 1
    """

    rows: dict[str, Tensor]
    quantiles: dict[str, Tensor]

    def look(self, vis: Tensor | None, tac: Tensor | None) -> list[dict[str, dict[str, Any]]]:
        """Return one record for each pair: modality -> cosine, quantile in [0, 1] and words.

        vis, tac  (B, D) raw embeddings of the head's encoder; one may be None
        """
        given = {n: x for n, x in (("vis", vis), ("tac", tac)) if x is not None and n in self.rows}
        found = {name: self._one(name, rows) for name, rows in given.items()}
        count = max((len(rows) for rows in given.values()), default=0)
        return [{name: records[i] for name, records in found.items()} for i in range(count)]

    def _one(self, name: str, rows: Tensor) -> list[dict[str, Any]]:
        cosines = nearest_cosine(rows, self.rows[name])
        places = quantile_of(cosines, self.quantiles[name])
        return [
            {"cosine": round(c, 4), "quantile": round(q, 3), "words": words(q)}
            for c, q in zip(cosines.tolist(), places.tolist(), strict=True)
        ]


def words(quantile: float) -> str:
    """Return a quantile of familiarity in words."""
    return next(text for limit, text in WORDS if quantile < limit)


def familiarity_of(vis: Tensor | None, tac: Tensor | None, objects: Sequence[str]) -> Familiarity:
    """Return the familiarity of a training set.

    vis, tac  (N, D) raw embeddings; at most 2,000 evenly spread rows are kept of each
    objects   N names; an image's neighbours of the same object do not count

    Raises DataError if all images are of one object.
    """
    given = {n: x for n, x in (("vis", vis), ("tac", tac)) if x is not None}
    step = max(1, -(-len(objects) // MOST_ROWS))
    names = list(objects)[::step]
    numbers = {name: i for i, name in enumerate(dict.fromkeys(names))}
    owner = torch.tensor([numbers[n] if n else len(names) + i for i, n in enumerate(names)])
    if len(set(owner.tolist())) < 2:
        raise DataError("Familiarity needs training images of two objects or more.")
    rows = {name: normalize(x[::step].float(), dim=-1) for name, x in given.items()}
    levels = torch.linspace(0, 1, QUANTILES)
    return Familiarity(
        rows=rows,
        quantiles={
            name: torch.quantile(nearest_cosine(x, x, owner, owner), levels)
            for name, x in rows.items()
        },
    )


def nearest_cosine(
    rows: Tensor,
    reference: Tensor,
    owner: Tensor | None = None,
    reference_owner: Tensor | None = None,
) -> Tensor:
    """Return (B,): the largest cosine of each row (B, D) with reference rows (N, D).

    owner, reference_owner  (B,), (N,) objects; rows of the same object are skipped
    """
    units = normalize(rows.float(), dim=-1)
    others = normalize(reference.float(), dim=-1)
    found = []
    for start in range(0, len(units), CHUNK):
        part = slice(start, start + CHUNK)
        cosines = units[part] @ others.T
        if owner is not None and reference_owner is not None:
            same = owner[part, None] == reference_owner[None]
            cosines = cosines.masked_fill(same, -1.0)
        found.append(cosines.amax(1))
    return torch.cat(found) if found else units.new_zeros(0)


def quantile_of(values: Tensor, quantiles: Tensor) -> Tensor:
    """Return the quantiles of values (B,) among ascending ones (Q,): 0 below all, 1 above all."""
    last = len(quantiles) - 1
    upper = torch.searchsorted(quantiles, values, right=True).clamp(1, last)
    low, high = quantiles[upper - 1], quantiles[upper]
    inside = ((values - low) / (high - low).clamp_min(1e-12)).clamp(0, 1)
    place: Tensor = (upper - 1 + inside) / last
    return place
