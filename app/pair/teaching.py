"""A visitor's labelled pairs: teach a head from them, test it, save both."""

from dataclasses import asdict
from typing import TYPE_CHECKING

from app.shared.pair_input import lessons_in, lessons_of, reader_of, taught_name
from app.shared.resources import Resources
from app.shared.saving import head_zip, set_zip
from app.shared.state import Question, Reply
from omnivat.kit.errors import DataError

if TYPE_CHECKING:
    from omnivat.data.store import Embeddings

DOMAIN = "My pairs"


def taught(resources: Resources, question: Question) -> Reply:
    """Teach a head and return its name, `taught`, for requests whose body is an image."""
    _require_lessons(question)
    reader_of(resources, question)
    return {"taught": taught_name(question)}


def teach(resources: Resources, question: Question) -> Reply:
    """Predict the visitor's labelled pairs before and after teaching.

    question  {"lessons": […], "head": the head to teach, the first one if left out}
    return    `judged`: label, before, after of each pair, where "after" comes from a head taught
              without it; `right`: correct predictions before and after; `share` of the head's own
              prediction in the taught head (omnivat/head/teach.py); `classes` of the taught head

    Raises DataError for too few pairs or classes.
    """
    from omnivat.head.teach import judged

    head = resources.head_named(question.get("head"))
    _, lessons = lessons_of(resources, question)
    report = judged(head, lessons)
    return {
        "judged": [{"label": j.label, "before": j.before, "after": j.after} for j in report.judged],
        "right": {"before": report.before, "after": report.after},
        "share": round(report.share, 4),
        "classes": list(reader_of(resources, question)[0].settings.classes),
    }


def curve(resources: Resources, question: Question) -> Reply:
    """Return the accuracy on left-out objects against the number of labelled objects of a class.

    question  as for `teach`
    return    `points`: objects of a class, share of correct pairs, least and largest share over
              the draws; `words`: the curve in a sentence
    """
    from omnivat.head import curve as labels

    head = resources.head_named(question.get("head"))
    _, lessons = lessons_of(resources, question)
    return asdict(labels.curve(head, lessons))


def own_set(resources: Resources, question: Question) -> "Embeddings":
    """Return the visitor's labelled pairs that have both images, as a set of one domain.

    Raises DataError if no pair has both images.
    """
    import numpy as np

    from omnivat.data.store import ROW_NAMES, Embeddings, Header

    whole = [lesson for lesson in lessons_in(question) if lesson.get("vis") and lesson.get("tac")]
    if not whole:
        raise DataError(
            "A set needs pairs of both images; label at least one photo with its touch."
        )
    # The set keeps raw embeddings: a profile is saved as a file of its own.
    lessons, _ = lessons_of(resources, {"lessons": whole})
    labels = [lesson.label for lesson in lessons]
    classes = tuple(dict.fromkeys(labels))
    encoder = resources.head().encoder
    objects = [f"{DOMAIN}/{label}/{number}" for number, label in enumerate(labels)]
    files = {
        modality: [f"{name}_{modality}.png" for name in objects] for modality in ("vis", "tac")
    }
    return Embeddings(
        header=Header(
            encoder=encoder["name"],
            weights_hash=encoder["weights_hash"],
            preprocessing=encoder["preprocessing"],
            domains=(DOMAIN,),
            classes=classes,
            origin="labelled by a visitor of the page",
        ),
        vis=np.concatenate([lesson.vis.numpy() for lesson in lessons if lesson.vis is not None]),
        tac=np.concatenate([lesson.tac.numpy() for lesson in lessons if lesson.tac is not None]),
        domain=np.zeros(len(whole), dtype=np.int64),
        label=np.array([classes.index(label) for label in labels], dtype=np.int64),
        rows={name: [""] * len(whole) for name in ROW_NAMES} | {"object": objects} | files,
    )


def save_set(resources: Resources, question: Question) -> bytes:
    """Return a zip of the visitor's labelled pairs as a set."""
    return set_zip(own_set(resources, question), "my-pairs")


def save_taught(resources: Resources, question: Question) -> bytes:
    """Return a zip of the taught head. Raises DataError without labelled pairs."""
    _require_lessons(question)
    return head_zip(reader_of(resources, question)[0], "taught-head")


def _require_lessons(question: Question) -> None:
    if not lessons_in(question):
        raise DataError("No pair is labelled yet, so no head can be taught. Label two or more.")
