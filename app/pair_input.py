"""Shared by all requests about a pair: its two images, as embeddings."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from app.resources import Resources
from app.state import ForgottenError, Ref, ref_from
from omnivat.kit.errors import DataError
from omnivat.kit.progress import checkpoint

if TYPE_CHECKING:
    import numpy as np
    import torch

    from omnivat.data.profile import Profile


def refs_from(question: Mapping[str, Any]) -> dict[str, Ref | None]:
    """Return the references of a request's VIS and TAC images."""
    return {modality: ref_from(question.get(modality)) for modality in ("vis", "tac")}


def mixed(refs: Mapping[str, Ref | None]) -> bool:
    """True if the two images come from different pairs: two of the set, or one and a visitor's."""
    vis, tac = refs["vis"], refs["tac"]
    if vis is None or tac is None or vis == tac:
        return False
    return {vis.kind, tac.kind} != {"image"}  # two of a visitor's own may be a pair


def embedded(
    resources: Resources,
    refs: Mapping[str, Ref | None],
    question: Mapping[str, Any] = MappingProxyType({}),
) -> "dict[str, torch.Tensor | None]":
    """Return the embeddings (1, input_width) of the named images; None for a missing one.

    question  its `profile`, if any, moves uploaded images to the source of its `head`

    Raises DataError if both are missing or one is not available.
    """
    checkpoint()
    if not any(refs.values()):
        raise DataError("Choose a pair first: a VIS image, a TAC image or both.")
    return {
        modality: of_ref(resources, ref, modality, question) if ref else None
        for modality, ref in refs.items()
    }


def of_ref(
    resources: Resources, ref: Ref, modality: str, question: Mapping[str, Any]
) -> "torch.Tensor":
    """Return the embedding (1, input_width) of one image, as `embedded` does."""
    import torch

    rows = torch.from_numpy(resources.embedding(ref, modality).copy())[None]
    return moved(resources, question, modality, rows) if ref.kind == "image" else rows


def moved(
    resources: Resources, question: Mapping[str, Any], modality: str, rows: "torch.Tensor"
) -> "torch.Tensor":
    """Return rows (B, input_width) of a visitor's images, moved by the profile of a request, if
    any.

    Raises DataError if it does not fit the head, or the head has no profile of its source.
    """
    profile = profile_in(resources, question)
    return (
        rows
        if profile is None
        else resources.head_named(question.get("head")).moved(modality, rows, profile)
    )


def profile_in(resources: Resources, question: Mapping[str, Any]) -> "Profile | None":
    """Return the profile named in a request; None without a name. Raises ForgottenError if it is
    not kept.
    """
    name = question.get("profile")
    found = resources.profiles.get(str(name)[:64]) if name else None
    if name and found is None:
        raise ForgottenError("The server no longer has the profile of your sensor; load it again.")
    return found


def rounded(values: "np.ndarray[Any, Any]") -> list[list[float]]:
    """Round numbers to six digits, enough for the page."""
    import numpy as np

    found: list[list[float]] = np.round(values.astype(np.float64), 6).tolist()
    return found
