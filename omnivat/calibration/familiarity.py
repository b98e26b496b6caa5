"""Familiarity: distance of an image to the training images, relative to their own distances.

The distance is the cosine in E, the encoder's space, to the nearest training image of the modality.
A cosine alone means little, so it is compared with the training set: the cosine of each training
image to the nearest image of another object. A quantile of 0.02 means that 98 % of the training
images have a closer neighbour."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import torch
from safetensors import SafetensorError
from safetensors.torch import load_file, save
from torch import Tensor
from torch.nn.functional import normalize

from omnivat.errors import DataError
from omnivat.schema import FLOATS, tensor_table
from omnivat.stages import IMAGES

MOST_ROWS = 2000  # training images for each modality; bounds the file and the search
QUANTILES = 101
CHUNK = 512
UNLIKE = 0.05  # below this quantile a prediction is a guess; above it lies any ordinary rank
WORDS = ((UNLIKE, "unlike the training images"), (2.0, "familiar"))


@dataclass(frozen=True, slots=True, kw_only=True)
class Familiarity:
    """Training images as unit vectors, and the quantiles of their nearest cosines.

    rows       modality -> (N, D) unit rows
    quantiles  modality -> (101,) ascending cosines, from quantile 0 to 1
    lengths    modality -> (N,) lengths of the rows before; empty for an older head
    labels     (N,) class indices of the head; None for an older head
    """

    rows: dict[str, Tensor]
    quantiles: dict[str, Tensor]
    lengths: dict[str, Tensor] = field(default_factory=dict)
    labels: Tensor | None = None

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


def familiarity_of(
    vis: Tensor | None, tac: Tensor | None, objects: Sequence[str], labels: Tensor | None = None
) -> Familiarity:
    """Return the familiarity of a training set.

    vis, tac  (N, D) raw embeddings; at most 2,000 evenly spread rows are kept of each
    objects   N names; an image's neighbours of the same object do not count
    labels    (N,) class indices, kept for teaching

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
        quantiles={name: torch.quantile(nearest_cosine(x, x, owner, owner), levels) for name, x in rows.items()},
        lengths={name: x[::step].float().norm(dim=-1) for name, x in given.items()},
        labels=None if labels is None else labels[::step].long(),
    )


def nearest_cosine(
    rows: Tensor, reference: Tensor, owner: Tensor | None = None, reference_owner: Tensor | None = None
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


def save_familiarity(file: Path, found: Familiarity) -> None:
    """Write the rows in half precision, and the quantiles."""
    tensors = {name: rows.half().contiguous() for name, rows in found.rows.items()}
    tensors |= {f"{name}_quantiles": q.contiguous() for name, q in found.quantiles.items()}
    tensors |= {f"{name}_lengths": x.float().contiguous() for name, x in found.lengths.items()}
    if found.labels is not None:
        tensors["labels"] = found.labels.to(torch.int64).contiguous()
    file.write_bytes(save(tensors, metadata={"format": "omnivat-familiarity-1"}))
    file.chmod(0o644)


def load_familiarity(file: Path, width: int) -> Familiarity | None:
    """Return the saved familiarity, or None if there is no file.

    Raises DataError for a file that cannot be read or does not fit the width.
    """
    if not file.is_file():
        return None
    try:
        tensor_table(file, types=(*FLOATS, "I64"))
        tensors = load_file(file)
    except (SafetensorError, OSError) as error:
        raise DataError(f"'{file}' cannot be read ({error}); copy the head folder again.") from error
    names = [name for name in IMAGES if name in tensors]
    fits = names and all(
        tensors[n].ndim == 2 and tensors[n].shape[1] == width and f"{n}_quantiles" in tensors for n in names
    )
    count = len(tensors[names[0]]) if names else 0
    others = [tensors[key] for key in ("labels", *(f"{n}_lengths" for n in names)) if key in tensors]
    if not fits or any(one.shape != (count,) for one in others):
        raise DataError(f"'{file}' does not fit this head; copy the head folder again.")
    return Familiarity(
        rows={name: tensors[name].float() for name in names},
        quantiles={name: tensors[f"{name}_quantiles"].float() for name in names},
        lengths={n: tensors[f"{n}_lengths"].float() for n in names if f"{n}_lengths" in tensors},
        labels=tensors.get("labels"),
    )
