"""Calibration of a head's confidence, from held-out source pairs, and how familiar an image is.

Familiarity is the distance of an image to the training images, relative to their own distances: the
mean cosine in E, the encoder's space, to the ten nearest training images of the modality. A cosine
alone means little, so it is compared with the training set: the same of each training image, among
images of other objects. A quantile of 0.02 means that 98 % of the training images have closer
neighbours. An image is taken as it comes, before any profile: a profile of odd pictures would move
them among the training images.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import torch
from safetensors import SafetensorError
from safetensors.torch import load_file, save
from torch import Tensor
from torch.nn.functional import cross_entropy, normalize

from omnivat.head.fusion import UNFITTED, Temperatures, fused_logs
from omnivat.kit.errors import DataError
from omnivat.kit.files import replacing
from omnivat.kit.schema import tensor_table
from omnivat.kit.stages import IMAGES

LOWEST, HIGHEST = 0.05, 20.0  # temperatures
STEPS = 32  # of the golden section; relative error 1e-6
GOLDEN = (5**0.5 - 1) / 2


def fit_temperature(logits: Tensor, labels: Tensor) -> float:
    """Return the temperature in [0.05, 20] with the lowest mean negative log-likelihood.

    logits  (N, K) logits or log-probabilities;  labels  (N,)

    The loss is convex in 1/T, so the golden section in log T finds its minimum.
    Raises DataError without pairs.
    Source: Guo et al., ICML 2017.

    >>> sure = torch.tensor([[4.0, 0.0]] * 4)  # 98 % sure, and right in three of four
    >>> temperature = fit_temperature(sure, torch.tensor([0, 0, 0, 1]))
    >>> torch.softmax(sure[0] / temperature, dim=0)
    tensor([0.7500, 0.2500])
    """
    if not len(labels):
        raise DataError("A temperature needs held-out pairs; there are none.")
    values = logits.double()

    def loss(log_temperature: float) -> float:
        return float(cross_entropy(values / _exp(log_temperature), labels))

    low, high = torch.tensor([LOWEST, HIGHEST], dtype=torch.float64).log().tolist()
    left, right = high - GOLDEN * (high - low), low + GOLDEN * (high - low)
    at_left, at_right = loss(left), loss(right)
    for _ in range(STEPS):
        if at_left <= at_right:
            high, right, at_right = right, left, at_left
            left = high - GOLDEN * (high - low)
            at_left = loss(left)
        else:
            low, left, at_left = left, right, at_right
            right = low + GOLDEN * (high - low)
            at_right = loss(right)
    return _exp((low + high) / 2)


def fit_calibration(
    logits: Mapping[str, Tensor], labels: Tensor, *, fusion: str = "mean"
) -> Temperatures:
    """Return temperatures for "fused", "vis" and "tac".

    logits  of held-out pairs: "vis" and "tac" with the other image absent; "vis_branch" and
            "tac_branch" inside the pair, "pair" of the summed features. A missing one keeps
            temperature 1
    fusion  late fusion of the branches
    """
    alone = {n: fit_temperature(logits[n], labels) for n in IMAGES if n in logits}
    if len(alone) == 1:
        (both,) = alone.values()
    else:
        branches = logits["vis_branch"], logits["tac_branch"]
        fused = logits["pair"] if fusion == "feature" else fused_logs(fusion, *branches)
        both = fit_temperature(fused, labels)
    return {**UNFITTED, **alone, "fused": both}


def _exp(value: float) -> float:
    return float(torch.tensor(value, dtype=torch.float64).exp())


MOST_ROWS = 2000  # training images for each modality; bounds the file and the search
QUANTILES = 101
NEIGHBOURS = 10  # nearest images of a hundred or more; one of fewer than twenty
CHUNK = 512
LONGEST = 1.01  # of a unit vector in half precision
UNLIKE = 0.05  # below this quantile a prediction is a guess; above it lies any ordinary rank
WORDS = ((UNLIKE, "unlike the training images"), (2.0, "familiar"))


@dataclass(frozen=True, slots=True, kw_only=True)
class Familiarity:
    """Training images as unit vectors, and the quantiles of their nearest cosines, by modality."""

    rows: dict[str, Tensor]  # (N, D) of unit length
    quantiles: dict[str, Tensor]  # (101,) ascending cosines, from quantile 0 to 1

    def look(self, vis: Tensor | None, tac: Tensor | None) -> list[dict[str, dict[str, Any]]]:
        """Return one record for each pair: modality -> cosine to the nearest image, quantile in
        [0, 1] and words.

        vis, tac  (B, D) raw embeddings of the head's encoder, before any profile; one may be None
        """
        given = {n: x for n, x in (("vis", vis), ("tac", tac)) if x is not None and n in self.rows}
        records: list[dict[str, dict[str, Any]]] = [{} for _ in next(iter(given.values()), ())]
        for name, rows in given.items():
            cosines = nearest_cosines(rows, self.rows[name])
            places = quantile_of(cosines.mean(1), self.quantiles[name])
            for record, c, q in zip(records, cosines[:, 0].tolist(), places.tolist(), strict=True):
                quantile = round(q, 3)
                about = {"cosine": round(c, 4), "quantile": quantile, "words": words(quantile)}
                record[name] = about
        return records


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
    step = -(-len(objects) // MOST_ROWS) or 1
    names = [name or f"\0{row}" for row, name in enumerate(objects[::step])]
    numbers = {name: number for number, name in enumerate(dict.fromkeys(names))}
    owner = torch.tensor([numbers[name] for name in names])
    if len(numbers) < 2:
        raise DataError("Familiarity needs training images of two objects or more.")
    rows = {name: normalize(x[::step].float(), dim=-1) for name, x in given.items()}
    levels = torch.linspace(0, 1, QUANTILES)
    return Familiarity(
        rows=rows,
        quantiles={
            name: torch.quantile(nearest_cosines(x, x, owner).mean(1), levels)
            for name, x in rows.items()
        },
    )


def nearest_cosines(rows: Tensor, reference: Tensor, owner: Tensor | None = None) -> Tensor:
    """Return (B, n): the largest cosines of each row (B, D) with reference rows (N, D), descending;
    n is N / 10, at least 1 and at most NEIGHBOURS.

    owner  (B,) objects of rows that are the reference themselves; those of the same are skipped
    """
    units, others = (normalize(x.float(), dim=-1) for x in (rows, reference))
    cosines = []
    for rows in torch.arange(len(units)).split(CHUNK):
        same = None if owner is None else owner[rows, None] == owner
        cosines.append(closest(units[rows], others, same))
    return torch.cat(cosines)


def closest(units: Tensor, others: Tensor, same: Tensor | None = None) -> Tensor:
    """Return `nearest_cosines` of unit rows (B, D); `same` (B, N): the reference rows to skip."""
    count = min(NEIGHBOURS, max(1, others.shape[0] // 10))  # len() would be fixed in a graph
    cosines = units @ others.T
    if same is not None:
        cosines = cosines.masked_fill(same, -1.0)
    return cosines.topk(count, dim=1).values


def quantile_of(values: Tensor, quantiles: Tensor) -> Tensor:
    """Return the quantiles of values (B,) among ascending ones (Q,): 0 below all, 1 above all."""
    last = quantiles.shape[0] - 1
    upper = (quantiles <= values[:, None]).sum(1).clamp(1, last)
    low, high = quantiles[upper - 1], quantiles[upper]
    inside = ((values - low) / (high - low).clamp_min(1e-12)).clamp(0, 1)
    place: Tensor = (upper - 1 + inside) / last
    return place


def save_familiarity(file: Path, familiarity: Familiarity) -> None:
    """Write the rows in half precision, and the quantiles."""
    tensors = {name: rows.half().contiguous() for name, rows in familiarity.rows.items()}
    tensors |= {f"{name}_quantiles": q.contiguous() for name, q in familiarity.quantiles.items()}
    with replacing(file) as whole:
        whole.write_bytes(save(tensors, metadata={"format": "omnivat-familiarity-1"}))


def tensors_in(file: Path) -> dict[str, Tensor]:
    """Return the tensors of a file of a head. Raises DataError if it cannot be read."""
    try:
        tensor_table(file)
        return load_file(file)
    except (SafetensorError, OSError) as error:
        raise DataError(
            f"'{file}' cannot be read ({error}); copy the head folder again."
        ) from error


def load_familiarity(file: Path, width: int) -> Familiarity | None:
    """Return the saved familiarity, or None if there is no file.

    Raises DataError for a file that cannot be read or does not fit the width.
    """
    if not file.is_file():
        return None
    tensors = tensors_in(file)
    names = [name for name in IMAGES if name in tensors]
    rows = {name: tensors[name].float() for name in names}
    quantiles = {name: tensors.get(f"{name}_quantiles", torch.empty(0)).float() for name in names}
    fits = names and all(
        rows[name].shape[1:] == (width,)
        and (rows[name].norm(dim=1) < LONGEST).all()  # false of what is no number
        and quantiles[name].ndim == 1
        and len(quantiles[name]) > 1
        and quantiles[name].isfinite().all()
        for name in names
    )
    if not fits:
        raise DataError(f"'{file}' does not fit this head; copy the head folder again.")
    return Familiarity(rows=rows, quantiles=quantiles)
