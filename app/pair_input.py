"""Shared by all requests about a pair: its two images, as embeddings."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from app.resources import Resources
from app.state import Ref, ref_from
from omnivat.errors import DataError

if TYPE_CHECKING:
    import numpy as np
    import torch


def refs_from(question: Mapping[str, Any]) -> dict[str, Ref | None]:
    """Return the references of a request's VIS and TAC images."""
    return {modality: ref_from(question.get(modality)) for modality in ("vis", "tac")}


def embedded(
    resources: Resources, refs: Mapping[str, Ref | None]
) -> "dict[str, torch.Tensor | None]":
    """Return the embeddings (1, input_width) of the named images; None for a missing one.

    Raises DataError if both are missing or one is not available.
    """
    if not any(refs.values()):
        raise DataError("Choose a pair first: a VIS image, a TAC image or both.")
    import torch

    return {
        modality: torch.from_numpy(resources.embedding(ref, modality).copy())[None] if ref else None
        for modality, ref in refs.items()
    }


def rounded(values: "np.ndarray[Any, Any]") -> list[list[float]]:
    """Round numbers to six digits, enough for the page."""
    return [[round(float(v), 6) for v in row] for row in values]
