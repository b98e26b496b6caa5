"""Predict the pairs of a set with a head, some at a time."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from omnivat.data.arrays import walked
from omnivat.data.store import Embeddings
from omnivat.head.checkpoint import Head
from omnivat.head.head import OmniVaT
from omnivat.kit.errors import DataError
from omnivat.kit.progress import checkpoint
from omnivat.kit.stages import IMAGES

Rows = NDArray[np.int64]
CHUNK = 512  # pairs in a forward pass; it bounds the memory for any set


def predicted_probabilities(
    model: OmniVaT,
    embeddings: Embeddings,
    *,
    order: float | None = None,
    modalities: Sequence[str] = ("vis", "tac"),
    rows: Rows | None = None,
) -> dict[str, Tensor]:
    """Return class probabilities (N, K) by reading (omnivat/head/output.py).

    "fused" uses all given images; "vis" and "tac" use one image with the other absent. With both
    images, "vis_branch" and "tac_branch" are the branches inside the pair.

    order       quarter turns; None: the learned one
    modalities  input of the head: "vis", "tac" or both
    rows        indices of the pairs; None: all
    Raises DataError if there are no pairs.
    """
    return predicted(
        lambda raw: model(raw.get("vis"), raw.get("tac"), order=order).readings,
        embeddings,
        modalities=modalities,
        rows=rows,
        device=model.classifier.device,
    )


def predicted_logits(
    model: OmniVaT, embeddings: Embeddings, *, modalities: Sequence[str] = ("vis", "tac")
) -> dict[str, Tensor]:
    """Return logits (N, K) before any temperature, named as in `HeadOutput.reading_logits`.

    Raises DataError if there are no pairs.
    """
    return predicted(
        lambda raw: model(raw.get("vis"), raw.get("tac")).reading_logits,
        embeddings,
        modalities=modalities,
        device=model.classifier.device,
    )


@torch.inference_mode()
def predicted(
    readings: Callable[[Mapping[str, Tensor]], Mapping[str, Tensor]],
    embeddings: Embeddings,
    *,
    modalities: Sequence[str] = IMAGES,
    rows: Rows | None = None,
    device: torch.device | None = None,
) -> dict[str, Tensor]:
    """Return what `readings` makes of raw embeddings (n, W) by modality, some pairs at a time.

    Raises DataError if there are no pairs.
    """
    found = [
        {name: values.cpu() for name, values in readings(raw).items()}
        for _, raw in blocks(embeddings, device, modalities, rows)
    ]
    if not found:
        raise DataError("There are no pairs to predict.")
    return {name: torch.cat([part[name] for part in found]) for name in found[0]}


def blocks(
    embeddings: Embeddings,
    device: torch.device | None = None,
    modalities: Sequence[str] = IMAGES,
    rows: Rows | None = None,
    *,
    size: int = CHUNK,
) -> Iterator[tuple[slice, dict[str, Tensor]]]:
    """Yield `size` pairs at a time by modality, with their places among `rows` (None: all
    pairs).
    """
    start = 0
    for some in zip(
        *(walked(getattr(embeddings, name), rows, size=size) for name in modalities), strict=True
    ):
        checkpoint()
        yield (
            slice(start, start + size),
            {n: torch.from_numpy(b).to(device) for n, b in zip(modalities, some, strict=True)},
        )
        start += size


def label_map(head_classes: Sequence[str], data_classes: Sequence[str]) -> np.ndarray[Any, Any]:
    """Return the index of each class of the data in the head, or -1 if the head lacks it."""
    return np.array([head_classes.index(c) if c in head_classes else -1 for c in data_classes])


def inputs_of(head: Head) -> tuple[str, ...]:
    """Return the images that a head was trained with: "vis", "tac" or both."""
    return tuple(head.provenance.get("train", {}).get("modalities", "vis+tac").split("+"))
