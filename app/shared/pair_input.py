"""What a request about pictures names, looked up once: its pair, profile, lessons and head."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from app.shared.mend import mend_in
from app.shared.resources import Resources
from app.shared.state import ForgottenError, Question, Ref, content_name, order_from, ref_from
from omnivat.kit.errors import DataError
from omnivat.kit.progress import checkpoint
from omnivat.kit.stages import IMAGES

if TYPE_CHECKING:
    import numpy as np
    from torch import Tensor

    from omnivat.data.profile import Profile
    from omnivat.data.relief import Lamps
    from omnivat.head.calibration import Familiarity
    from omnivat.head.checkpoint import Head
    from omnivat.head.teach import Lesson

Pair = dict[str, "Tensor | None"]
OTHER = {"vis": "tac", "tac": "vis"}
MOST_LESSONS = 60
LONGEST_LABEL = 40  # letters


@dataclass(frozen=True, slots=True, kw_only=True)
class PairRequest:
    """The pair that a request names, and the head that reads it."""

    before: Pair  # (B, input_width) by modality as they come; None for a missing image
    pair: Pair  # the same, a visitor's images moved by the request's profile
    order: float | None  # p; None: the learned one
    head: "Head"  # taught by the request's lessons, if there are any
    known: "Familiarity | None"  # what its pictures are compared with


def pair_request(
    resources: Resources, question: Question, rows: "Mapping[str, Tensor]" = MappingProxyType({})
) -> PairRequest:
    """Return what a request names.

    question  {"vis", "tac": references; "order": p; "profile", "head": names; "mend": how own
              touches are mended (`app.shared.mend`); "lessons", or
              "taught": the name of a head taught before}
    rows      embeddings (B, input_width) of pictures that came with the request

    Raises DataError without any image, ForgottenError for what is no longer kept.
    """
    order = order_from(question.get("order"))
    _, before, pair = pair_of(resources, question, rows)
    head, known = reader_of(resources, question)
    return PairRequest(before=before, pair=pair, order=order, head=head, known=known)


def within(question: Question, pair: Question) -> Question:
    """Return a request about one of the pairs that a request names."""
    return {**question, **{name: pair.get(name) for name in IMAGES}}


def pair_of(
    resources: Resources, question: Question, rows: "Mapping[str, Tensor]" = MappingProxyType({})
) -> tuple[dict[str, Ref | None], Pair, Pair]:
    """Return a request's references, and its pair before and after its profile."""
    import torch

    checkpoint()
    mend = mend_in(question)
    refs = {name: None if name in rows else ref_from(question.get(name)) for name in IMAGES}
    if not rows and not any(refs.values()):
        raise DataError("Choose a pair first: a VIS image, a TAC image or both.")
    before: Pair = {name: rows.get(name) for name in IMAGES}
    count = max(map(len, rows.values()), default=1)
    for name, ref in refs.items():
        if ref:
            row = torch.from_numpy(resources.embedding(ref, name, mend).copy())[None]
            before[name] = row.expand(count, -1)
    profile = profile_in(resources, question)
    if profile is None:
        return refs, before, before
    reader = resources.head_named(question.get("head"))
    own = {name for name, ref in refs.items() if name in rows or (ref and ref.kind == "image")}
    pair = {
        name: reader.moved(name, some, profile) if name in own and some is not None else some
        for name, some in before.items()
    }
    return refs, before, pair


def profile_in(resources: Resources, question: Question) -> "Profile | None":
    """Return the profile named in a request; None without a name. Raises ForgottenError if it is
    not kept.
    """
    name = question.get("profile")
    kept = resources.profiles.get(str(name)[:64]) if name else None
    if name and kept is None:
        raise ForgottenError("The server no longer has the profile of your sensor; load it again.")
    return kept


def lamps_in(resources: Resources, question: Question) -> "Lamps | None":
    """Return the lamps of the profile named in a request, if it holds some."""
    profile = profile_in(resources, question)
    return profile.lamps if profile else None


def reader_of(resources: Resources, question: Question) -> "tuple[Head, Familiarity | None]":
    """Return the head of a request, and what pictures are compared with: its lessons, or its
    training images.
    """
    if name := question.get("taught"):
        kept = resources.taught.get(str(name)[:64])
        if kept is None:
            raise ForgottenError("The server no longer has the taught head; press Teach again.")
        return kept
    head = resources.head_named(question.get("head"))
    if not lessons_in(question):
        return head, head.familiarity

    def made() -> "tuple[Head, Familiarity | None]":
        from omnivat.head.teach import taught

        before, after = lessons_of(resources, question)
        return taught(head, after), _known(before, head)

    return resources.taught.once(taught_name(question), made)


def taught_name(question: Question) -> str:
    """Return the name of the head that a request's lessons teach."""
    text = json.dumps(
        [question.get(name) for name in ("head", "profile", "mend", "lessons")], sort_keys=True
    )
    return content_name(text.encode("utf-8", "replace"))


def lessons_in(question: Question) -> Sequence[Question]:
    """Return the labelled pairs in a request: [{"vis", "tac", "label"}, …]; raises DataError for
    anything else.
    """
    labelled = question.get("lessons") or []
    if not isinstance(labelled, list) or not all(isinstance(lesson, dict) for lesson in labelled):
        raise DataError("lessons has to be a list of pairs with a label each.")
    if len(labelled) > MOST_LESSONS:
        raise DataError(
            f"{len(labelled)} labelled pairs were sent and at most {MOST_LESSONS} are taken here; "
            "train with `python -m omnivat train` instead."
        )
    for lesson in labelled:
        label = lesson.get("label")
        if not isinstance(label, str) or not 0 < len(label.strip()) <= LONGEST_LABEL:
            raise DataError(
                f"A label is {label!r:.60}; give a name of 1 to {LONGEST_LABEL} letters."
            )
        vis, tac = (ref_from(lesson.get(name)) for name in IMAGES)
        # two of a visitor's own may be a pair
        if vis and tac and vis != tac and {vis.kind, tac.kind} != {"image"}:
            raise DataError(
                f"The photo and the touch labelled '{label}' come from different pairs; label pairs"
                " of two pictures of one object."
            )
    return labelled


def lessons_of(resources: Resources, question: Question) -> "tuple[list[Lesson], list[Lesson]]":
    """Return the labelled pairs of a request as embeddings, before and after its profile."""
    from omnivat.head.teach import Lesson

    before: list[Lesson] = []
    after: list[Lesson] = []
    for lesson in lessons_in(question):
        label = lesson["label"].strip()
        _, *pairs = pair_of(resources, within(question, lesson))
        for lessons, pair in zip((before, after), pairs, strict=True):
            lessons.append(Lesson(label=label, vis=pair["vis"], tac=pair["tac"]))
    return before, after


def _known(lessons: "Sequence[Lesson]", head: "Head") -> "Familiarity | None":
    """Return the pictures of lessons as what others are compared with; the head's training images
    for fewer than two of a kind.

    They are taken before any profile; their quantiles are the nearest cosines of each among the
    others.
    """
    import torch

    from omnivat.head.calibration import Familiarity, nearest_cosines

    rows, quantiles = {}, {}
    for name in IMAGES:
        pictures = [image for lesson in lessons if (image := getattr(lesson, name)) is not None]
        if len(pictures) > 1:
            rows[name] = own = torch.cat(pictures)
            owner = torch.arange(len(own))
            quantiles[name] = nearest_cosines(own, own, owner).mean(1).sort().values
    return Familiarity(rows=rows, quantiles=quantiles) if rows else head.familiarity


def rounded(values: "np.ndarray[Any, Any]", digits: int = 6) -> list[list[float]]:
    """Round numbers to some digits, enough for the page."""
    import numpy as np

    rows: list[list[float]] = np.round(values.astype(np.float64), digits).tolist()
    return rows


def thinned(count: int, most: int) -> "np.ndarray[Any, Any]":
    """Return the numbers of at most `most` of `count` pairs, evenly spaced."""
    import numpy as np

    return np.unique(np.linspace(0, count - 1, min(count, most)).astype(np.int64))
