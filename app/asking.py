"""What every question about a pair shares: its two images, as embeddings."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from app.resources import Resources
from app.state import Ref, ref_from
from omnivat.errors import DataError

if TYPE_CHECKING:
    import numpy as np
    import torch


def refs_from(question: Mapping[str, Any]) -> dict[str, Ref | None]:
    """Return what a question names as VIS and TAC."""
    return {modality: ref_from(question.get(modality)) for modality in ("vis", "tac")}


def embedded(
    resources: Resources, refs: Mapping[str, Ref | None]
) -> "dict[str, torch.Tensor | None]":
    """Return the embeddings (1, input_width) of the images named, None where one is left out.

    Raises DataError when both are left out or one is not to be had.
    """
    if not any(refs.values()):
        raise DataError("Choose a pair first: a VIS image, a TAC image or both.")
    import torch

    return {
        modality: torch.from_numpy(resources.embedding(ref, modality).copy())[None] if ref else None
        for modality, ref in refs.items()
    }


def rounded(values: "np.ndarray[Any, Any]") -> list[list[float]]:
    """Return rows of numbers with six digits, enough for anything the page shows."""
    return [[round(float(v), 6) for v in row] for row in values]
