"""A visitor's labelled pairs: teach a head from them, test it, save both."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from app.pair_input import embedded, mixed, refs_from
from app.resources import Resources
from app.saving import head_zip, set_zip
from app.state import ForgottenError, content_name
from omnivat.kit.errors import DataError
from omnivat.kit.stages import IMAGES

if TYPE_CHECKING:
    from omnivat.data.store import Embeddings
    from omnivat.head.calibration import Familiarity
    from omnivat.head.checkpoint import Head
    from omnivat.head.teach import Lesson

MOST_LESSONS = 60
LONGEST_LABEL = 40  # letters
DOMAIN = "My pairs"


def lessons_in(question: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    """Return the labelled pairs in a request: [{"vis", "tac", "label"}, …]; raises DataError for
    anything else.
    """
    given = question.get("lessons") or []
    if not isinstance(given, list) or not all(isinstance(one, dict) for one in given):
        raise DataError("lessons has to be a list of pairs with a label each.")
    if len(given) > MOST_LESSONS:
        raise DataError(
            f"{len(given)} labelled pairs were sent and at most {MOST_LESSONS} are taken here; "
            "train with `python -m omnivat train` instead."
        )
    for one in given:
        label = one.get("label")
        if not isinstance(label, str) or not 0 < len(label.strip()) <= LONGEST_LABEL:
            raise DataError(
                f"A label is {label!r:.60}; give a name of 1 to {LONGEST_LABEL} letters."
            )
        if mixed(refs_from(one)):
            raise DataError(
                f"The photo and the touch labelled '{label}' come from different pairs; label pairs"
                " of two pictures of one object."
            )
    return given


def head_for(resources: Resources, question: Mapping[str, Any]) -> "Head":
    """Return the head named in a request, taught from the request's lessons if there are any."""
    head, given = resources.head_named(question.get("head")), lessons_in(question)
    if not given:
        return head
    from omnivat.head.teach import taught

    return resources.taught.once(
        _name(question),
        lambda: (
            taught(head, _lessons(resources, given, question)),
            familiar_lessons(resources, question),
        ),
    )[0]


def taught_name(resources: Resources, question: Mapping[str, Any]) -> dict[str, Any]:
    """Teach a head and return its name for `head_taught`, for requests whose body is an image."""
    if not lessons_in(question):
        raise DataError("No pair is labelled yet, so no head can be taught. Label two or more.")
    head_for(resources, question)
    return {"taught": _name(question)}


def head_taught(
    resources: Resources, name: str, head: str = ""
) -> "tuple[Head, Familiarity | None]":
    """Return the head of a name from `taught_name`, and what its pictures are compared with; the
    head named `head` and its training images for "". Raises ForgottenError if it is not kept.
    """
    if not name:
        plain = resources.head_named(head)
        return plain, plain.familiarity
    found = resources.taught.get(name)
    if found is None:
        raise ForgottenError("The server no longer has the taught head; press Teach again.")
    return found


def teach(resources: Resources, question: Mapping[str, Any]) -> dict[str, Any]:
    """Predict the visitor's labelled pairs before and after teaching.

    question  {"lessons": […], "head": the head to teach, the first one if left out}
    return    `judged`: label, before, after of each pair, where "after" comes from a head taught
              without it; `right`: correct predictions before and after; `share` of the head's own
              prediction in the taught head (omnivat/head/teach.py); `classes` of the taught head

    Raises DataError for too few pairs or classes.
    """
    from omnivat.head.teach import judged

    head = resources.head_named(question.get("head"))
    found = judged(head, _lessons(resources, lessons_in(question), question))
    return {
        "judged": [{"label": j.label, "before": j.before, "after": j.after} for j in found.judged],
        "right": {"before": found.before, "after": found.after},
        "share": round(found.share, 4),
        "classes": list(head_for(resources, question).settings.classes),
    }


def curve(resources: Resources, question: Mapping[str, Any]) -> dict[str, Any]:
    """Return what labels bring: `points` (objects of a class, share of right pairs, least and most
    over draws), and `words`. The question is that of `teach`.
    """
    from omnivat.head import curve as labels

    head = resources.head_named(question.get("head"))
    return asdict(labels.curve(head, _lessons(resources, lessons_in(question), question)))


def familiar_lessons(resources: Resources, question: Mapping[str, Any]) -> "Familiarity | None":
    """Return the pictures of a request's lessons as what others are compared with; None for fewer
    than two of a kind.

    They are taken before any profile; their quantiles are the nearest cosines of each among the
    others.
    """
    import torch

    from omnivat.head.calibration import Familiarity, nearest_cosines

    lessons = _lessons(resources, lessons_in(question), {})
    pictures = {
        name: [one for lesson in lessons if (one := getattr(lesson, name)) is not None]
        for name in IMAGES
    }
    rows = {name: torch.cat(some) for name, some in pictures.items() if len(some) > 1}
    owners = {name: torch.arange(len(own)) for name, own in rows.items()}
    near = {
        n: nearest_cosines(own, own, owners[n], owners[n]).mean(1).sort().values
        for n, own in rows.items()
    }
    return Familiarity(rows=rows, quantiles=near) if rows else None


def own_set(resources: Resources, question: Mapping[str, Any]) -> "Embeddings":
    """Return the visitor's labelled pairs as a set of one domain; raises DataError if none has
    both images.
    """
    import numpy as np

    from omnivat.data.store import ROW_NAMES, Embeddings, Header

    given = [one for one in lessons_in(question) if one.get("vis") and one.get("tac")]
    if not given:
        raise DataError(
            "A set needs pairs of both images; label at least one photo with its touch."
        )
    lessons = _lessons(resources, given, {})  # as they come: a profile is a file of its own
    labels = [one.label for one in lessons]
    classes = tuple(dict.fromkeys(labels))
    encoder = resources.head().encoder
    objects = [f"{DOMAIN}/{label}/{number}" for number, label in enumerate(labels)]
    files = {modality: [f"{one}_{modality}.png" for one in objects] for modality in ("vis", "tac")}
    rows = {name: [""] * len(given) for name in ROW_NAMES} | {"object": objects} | files
    return Embeddings(
        header=Header(
            encoder=encoder["name"],
            weights_hash=encoder["weights_hash"],
            preprocessing=encoder["preprocessing"],
            domains=(DOMAIN,),
            classes=classes,
            origin="labelled by a visitor of the page",
        ),
        vis=np.concatenate([one.vis.numpy() for one in lessons if one.vis is not None]),
        tac=np.concatenate([one.tac.numpy() for one in lessons if one.tac is not None]),
        domain=np.zeros(len(given), dtype=np.int64),
        label=np.array([classes.index(label) for label in labels], dtype=np.int64),
        rows=rows,
    )


def save_set(resources: Resources, question: Mapping[str, Any]) -> bytes:
    """Return a zip of the visitor's labelled pairs as a set."""
    return set_zip(own_set(resources, question), "my-pairs")


def save_taught(resources: Resources, question: Mapping[str, Any]) -> bytes:
    """Return a zip of the taught head. Raises DataError without labelled pairs."""
    if not lessons_in(question):
        raise DataError("No pair is labelled yet, so there is no taught head to save.")
    return head_zip(head_for(resources, question), "taught-head")


def _name(question: Mapping[str, Any]) -> str:
    text = json.dumps(
        [question.get(name) for name in ("head", "profile", "lessons")], sort_keys=True
    )
    return content_name(text.encode("utf-8", "replace"))


def _lessons(
    resources: Resources, labelled: Sequence[Mapping[str, Any]], question: Mapping[str, Any]
) -> "list[Lesson]":
    from omnivat.head.teach import Lesson

    pairs = [embedded(resources, refs_from(one), question) for one in labelled]
    labels = [one["label"].strip() for one in labelled]
    return [
        Lesson(label=label, vis=pair["vis"], tac=pair["tac"])
        for label, pair in zip(labels, pairs, strict=True)
    ]
