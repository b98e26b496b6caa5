"""Teach a trained head from a few labelled pairs: class means in F̂, no gradient steps."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import torch
from torch import Tensor
from torch.nn.functional import normalize

from omnivat.checkpoint import Head
from omnivat.errors import DataError
from omnivat.model.head import OmniVaT

FEWEST = 2  # fewest pairs of a class, and fewest classes


@dataclass(frozen=True, slots=True, kw_only=True)
class Lesson:
    """One labelled pair as raw embeddings (1, input_width); one of the two may be None."""

    label: str
    vis: Tensor | None
    tac: Tensor | None


@dataclass(frozen=True, slots=True, kw_only=True)
class Judged:
    """Predictions for one pair before and after teaching; "after" is taught without this pair."""

    label: str
    before: str
    after: str


def taught(head: Head, lessons: Sequence[Lesson]) -> Head:
    """Return a head whose class directions are moved to the lessons' mean F̂.

    A class keeps its learned direction with the weight of one pair. A class that the head lacks
    gets its direction from the lessons. Features do not change, and `head` is not modified.

    Raises DataError without lessons.
    """
    if not lessons:
        raise DataError("There is nothing to learn from; label at least one pair.")
    means = torch.stack([_mean_direction(head.model, one) for one in lessons])
    return _with_means(head, means, [one.label for one in lessons])


def judged(head: Head, lessons: Sequence[Lesson]) -> list[Judged]:
    """Predict every lesson before and after teaching, each by a head taught on all others.

    Raises DataError if fewer than two classes have two or more pairs.
    """
    require_enough([one.label for one in lessons])
    means = torch.stack([_mean_direction(head.model, one) for one in lessons])
    labels = [one.label for one in lessons]
    found = []
    for left_out, one in enumerate(lessons):
        rest = [row for row in range(len(lessons)) if row != left_out]
        other = _with_means(head, means[rest], [labels[row] for row in rest])
        before, after = _predicted(head, one), _predicted(other, one)
        found.append(Judged(label=one.label, before=before, after=after))
    return found


def require_enough(labels: Sequence[str]) -> None:
    """Raise DataError if fewer than two classes have two pairs."""
    counts = {label: labels.count(label) for label in dict.fromkeys(labels)}
    if sum(count >= FEWEST for count in counts.values()) < FEWEST:
        there = ", ".join(f"{label} {count}" for label, count in counts.items()) or "none yet"
        raise DataError(
            f"Label two or more pairs of each of two or more classes first; there are: {there}."
        )


@torch.no_grad()
def _mean_direction(model: OmniVaT, lesson: Lesson) -> Tensor:
    """Return the mean (D,) of the unit F̂ of the pair's images."""
    features = model(lesson.vis, lesson.tac).f_hat
    return torch.stack([normalize(rows, dim=-1)[0] for rows in features.values()]).mean(0)


@torch.no_grad()
def _predicted(head: Head, lesson: Lesson) -> str:
    probabilities = head.model(lesson.vis, lesson.tac).probabilities[0]
    return head.settings.classes[int(probabilities.argmax())]


def _with_means(head: Head, means: Tensor, labels: Sequence[str]) -> Head:
    """Return the head with directions of class means (B, D) added to its own, by label."""
    own = head.settings.classes
    classes = (*own, *(label for label in dict.fromkeys(labels) if label not in own))
    state = {name: tensor.detach() for name, tensor in head.model.state_dict().items()}
    extra = len(classes) - len(own)
    directions = normalize(state["classifier"], dim=-1)
    lengths = state["classifier"].norm(dim=-1).mean()
    directions = torch.cat((directions, directions.new_zeros(extra, directions.shape[1])))
    index = torch.tensor([classes.index(label) for label in labels])
    moved = normalize(directions.index_add(0, index, means.to(directions.dtype)), dim=-1)
    state["classifier"] = lengths * moved
    if extra and "mffa.bank" in state:  # unseen classes: the class-agnostic token stays
        bank, seen = state["mffa.bank"], state["mffa.bank_seen"]
        state["mffa.bank"] = torch.cat((bank, bank.new_zeros(len(bank), extra, bank.shape[2])), 1)
        state["mffa.bank_seen"] = torch.cat((seen, seen.new_zeros(extra)))
    settings = replace(head.settings, classes=classes)
    with torch.device("meta"):
        model = OmniVaT(settings)
    model.load_state_dict(state, assign=True)
    model.calibration = head.model.calibration
    counts = {label: list(labels).count(label) for label in dict.fromkeys(labels)}
    return replace(
        head,
        model=model.eval().requires_grad_(False),
        settings=settings,
        provenance={**head.provenance, "taught": counts},
        metrics={},
        path=None,
    )
