"""Teach a trained head from a few labelled pairs: two linear maps, blended; nothing is trained by
gradient.

Lessons and the head's own training pairs are rows in E, standardised by the source's profile. Each
map is a ridge regression of one-hot classes on rows, which a linear system solves:

both     training pairs and lessons; the lessons of a class count as WEIGHT pairs together
lessons  the lessons, and training pairs of the classes that no lesson has

The taught head's scores are (1 - t) both + t lessons. The share t has the least squared error over
the lessons, each predicted without its object. It has a closed form and no threshold, so a lesson
more or less moves it little. Predictions of left-out objects follow from the same linear system.

Source: stacked regression (Breiman, Machine Learning 24, 1996); leaving out in closed form as in
Rifkin and Lippert, "Notes on regularized least squares" (MIT-CSAIL-TR-2007-025), for whole objects.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor
from torch.nn.functional import normalize

from omnivat.head.checkpoint import Head
from omnivat.head.head import OmniVaT
from omnivat.head.ridge import Labels, Ridge, Rows, ridge, share_of_lessons, sharpness, weight_of
from omnivat.head.settings import HeadSettings
from omnivat.kit.errors import DataError
from omnivat.kit.progress import OnStep, Step, checkpoint, ignore
from omnivat.kit.stages import IMAGES
from omnivat.kit.threads import one_blas_thread, one_thread

FEWEST = 2  # objects of a class, and classes
MOST = 2000  # lessons
PARTS = ("training pairs and lessons", "lessons alone")


@dataclass(frozen=True, slots=True, kw_only=True)
class Lesson:
    """One labelled pair as raw embeddings (1, input_width); one of the two may be None."""

    label: str
    vis: Tensor | None
    tac: Tensor | None
    # its name: pairs of one object are left out together; "": an object of its own
    object: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Judged:
    """Predictions for one pair before and after teaching; "after" is taught without its object."""

    label: str
    before: str
    after: str
    object: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Report:
    """What teaching brings."""

    # each lesson; the share of the maps is chosen without its object, too
    judged: tuple[Judged, ...]
    share: float  # of the lessons alone, 0 to 1, in the taught head
    right: Mapping[str, int]  # map -> lessons that it predicts rightly, each object left out

    @property
    def before(self) -> int:
        """Return the lessons that the head predicts rightly as it is."""
        return sum(one.before == one.label for one in self.judged)

    @property
    def after(self) -> int:
        """Return the lessons that are right after teaching."""
        return sum(one.after == one.label for one in self.judged)


@one_thread()
@one_blas_thread()
def taught(head: Head, lessons: Sequence[Lesson]) -> Head:
    """Return a head that predicts as the lessons teach; `head` is not modified.

    Features and stages do not change, and the order p has no influence on the prediction. A class
    that the head lacks is added. With too few objects to leave out, the share of the lessons alone
    is 0. Raises DataError without lessons, or with more than 2,000.

    >>> from omnivat import default_embeddings, default_head, load_embeddings, load_head
    >>> head, pairs = load_head(default_head()), load_embeddings(default_embeddings())
    >>> rows = pairs.rows_of("TQ-DIGIT-sim", split="train")
    >>> lessons = [
    ...     Lesson(
    ...         label="cork" if pairs.label[row] else "wood",
    ...         vis=torch.tensor(pairs.vis[row])[None],
    ...         tac=torch.tensor(pairs.tac[row])[None],
    ...     )
    ...     for row in rows[::20]
    ... ]
    >>> taught(head, lessons).settings.classes[-1]  # a class that the head lacks is added
    'cork'
    >>> report = judged(head, lessons)
    >>> [0 <= right <= len(lessons) for right in (report.before, report.after)]
    [True, True]
    """
    return Work(head, lessons).head_taught()


@one_thread()
@one_blas_thread()
def judged(head: Head, lessons: Sequence[Lesson], on_step: OnStep = ignore) -> Report:
    """Predict every lesson before and after teaching, its object left out.

    Raises DataError if fewer than two classes have two objects or more.
    """
    if lacking := missing(lessons):
        raise DataError(lacking)
    return Work(head, lessons).report(on_step)


def missing(lessons: Sequence[Lesson]) -> str:
    """Return what is missing before lessons can be judged, or ""."""
    objects: dict[str, set[str]] = {}
    for lesson, name in zip(lessons, _objects(lessons), strict=True):
        objects.setdefault(lesson.label, set()).add(name)
    if sum(len(names) >= FEWEST for names in objects.values()) >= FEWEST:
        return ""
    there = ", ".join(f"{label} {len(names)}" for label, names in objects.items()) or "none yet"
    return (
        "Label two or more pairs of each of two or more classes first, of different objects; there"
        f" are: {there}."
    )


def _objects(lessons: Sequence[Lesson]) -> list[str]:
    return [lesson.object or f"\0{index}" for index, lesson in enumerate(lessons)]


class Work:
    """Lessons and training pairs as rows of length 1, both modalities side by side, and the two
    maps.
    """

    def __init__(self, head: Head, lessons: Sequence[Lesson]) -> None:
        if not lessons:
            raise DataError("There is nothing to learn from; label at least one pair.")
        if len(lessons) > MOST:
            raise DataError(
                f"There are {len(lessons):,} lessons and at most {MOST:,} are taken; train a head "
                "with `python -m omnivat train` instead."
            )
        self.head, self.lessons = head, lessons
        self.classes = tuple(
            dict.fromkeys([*head.settings.classes, *(one.label for one in lessons)])
        )
        self.labels = np.array([self.classes.index(one.label) for one in lessons])
        self.rows = np.concatenate([_row(head.model, one) for one in lessons])
        self.source, self.known = _training_rows(head)
        names = _objects(lessons)
        self.objects = [
            np.flatnonzero([name == other for other in names]) for name in dict.fromkeys(names)
        ]
        self.present = np.unique(np.concatenate((self.known, self.labels)))

    @cached_property
    def maps(self) -> list[Ridge]:
        """The map of training pairs and lessons, and that of the lessons alone."""
        weight = weight_of(self.labels)
        return [
            ridge(
                np.concatenate((self.rows, self.source[kept])),
                np.concatenate((self.labels, self.known[kept])),
                np.concatenate((np.full(len(self.rows), weight), np.ones(kept.sum()))),
                len(self.classes),
                self.objects,
            )
            for kept in self.kept(self.labels)
        ]

    @cached_property
    def errors(self) -> list[Rows]:
        """Of each lesson by each map without its object."""
        return [np.eye(len(self.classes))[self.labels] - one.apart for one in self.maps]

    @cached_property
    def share(self) -> float:
        return 0.0 if missing(self.lessons) else share_of_lessons(*self.errors)

    def kept(self, labels: Labels) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
        """Return the training pairs of each map, if lessons of `labels` teach."""
        return np.ones(len(self.known), bool), ~np.isin(self.known, labels)

    def blended(self, both: Rows, lessons: Rows, share: float | None = None) -> Rows:
        share = self.share if share is None else share
        return (1 - share) * both + share * lessons

    def report(self, on_step: OnStep) -> Report:
        """Predict each lesson before, by each map and by their blend, its object left out."""
        before = []
        for done, lesson in enumerate(self.lessons):
            checkpoint()
            on_step(Step(done=done, total=len(self.lessons)))
            before.append(_predicted(self.head, lesson))
        after = self.after()
        return Report(
            judged=tuple(
                Judged(label=one.label, before=was, after=self.classes[label], object=one.object)
                for one, was, label in zip(self.lessons, before, after, strict=True)
            ),
            share=self.share,
            right={
                name: int((self.best(one.apart) == self.labels).sum())
                for name, one in zip(PARTS, self.maps, strict=True)
            },
        )

    def after(self) -> Labels:
        """Return the class (L,) of each lesson, taught by all others and blended without it."""
        both, alone = (one.apart for one in self.maps)
        after = np.empty(len(self.lessons), np.int64)
        for group in self.objects:
            others = np.setdiff1d(np.arange(len(after)), group)
            share = share_of_lessons(*(errors[others] for errors in self.errors))
            after[group] = self.best(self.blended(both[group], alone[group], share))
        return after

    def best(self, scores: Rows) -> Labels:
        chosen: Labels = self.present[scores[:, self.present].argmax(1)]
        return chosen

    def head_taught(self) -> Head:
        """Return the head taught by all lessons; it keeps a row and a bias of each class that
        has pairs.
        """
        both, alone = self.maps
        sharp = sharpness(self.blended(both.apart, alone.apart), self.labels)
        weights = sharp * self.blended(both.weights, alone.weights)[:, self.present]
        bias = sharp * self.blended(both.bias, alone.bias)[self.present]
        found = _with_classes(self.head, self.classes, self.lessons)
        dtype = found.model.dtype
        rows = {
            "taught_rows": torch.from_numpy(np.stack(np.split(weights.T, 2, axis=1))).to(dtype),
            "taught_bias": torch.from_numpy(bias).to(dtype),
            "taught_class": torch.from_numpy(self.present),
        }
        counts = {name: [one.label for one in self.lessons].count(name) for name in self.classes}
        about = {
            "taught": {name: count for name, count in counts.items() if count},
            "lessons_share": self.share,
        }
        found = replace(found, provenance={**found.provenance, **about}, metrics={}, path=None)
        settings = replace(found.settings, taught=len(self.present))
        return _with_state(found, settings, {**found.model.state_dict(), **rows})


@torch.no_grad()
def _row(model: OmniVaT, lesson: Lesson) -> Rows:
    """Return the row (1, 2 W) of a pair; the part of a missing image is zero."""
    width = model.settings.input_width
    images = {"vis": lesson.vis, "tac": lesson.tac}
    parts = [
        torch.zeros(1, width) if raw is None else model.standing(name, raw)
        for name, raw in images.items()
    ]
    row: Rows = torch.cat(parts, dim=1).double().numpy()
    return row


@torch.no_grad()
def _training_rows(head: Head) -> tuple[Rows, Labels]:
    """Return the head's training pairs as rows, with their classes; none if its folder has none."""
    kept, width = head.familiarity, head.settings.input_width
    if kept is None or kept.labels is None or set(kept.lengths) != set(IMAGES):
        return np.zeros((0, 2 * width)), np.zeros(0, np.int64)
    raw = {name: kept.rows[name] * kept.lengths[name][:, None] for name in IMAGES}
    parts = [head.model.standing(name, raw[name]) for name in IMAGES]
    return torch.cat(parts, dim=1).double().numpy(), kept.labels.numpy()


@torch.no_grad()
def _predicted(head: Head, lesson: Lesson) -> str:
    probabilities = head.model(lesson.vis, lesson.tac).probabilities[0]
    return head.settings.classes[int(probabilities.argmax())]


@torch.no_grad()
def _with_classes(head: Head, classes: tuple[str, ...], lessons: Sequence[Lesson]) -> Head:
    """Return the head with `classes`; the direction of a new one is the mean of its lessons'
    unit F̂.
    """
    state = {
        n: x.detach() for n, x in head.model.state_dict().items() if not n.startswith("taught_")
    }
    directions = state["classifier"]
    for name in classes[len(directions) :]:
        hats = [
            f
            for one in lessons
            if one.label == name
            for f in head.model(one.vis, one.tac).f_hat.values()
        ]
        mean = normalize(normalize(torch.cat(hats), dim=-1).mean(0), dim=-1)
        length = state["classifier"].norm(dim=-1).mean()
        directions = torch.cat((directions, length * mean[None]))
    extra = len(directions) - len(state["classifier"])
    state["classifier"] = directions
    if extra and "mffa.bank" in state:  # unseen classes: the class-agnostic token stays
        bank, seen = state["mffa.bank"], state["mffa.bank_seen"]
        state["mffa.bank"] = torch.cat((bank, bank.new_zeros(len(bank), extra, bank.shape[2])), 1)
        state["mffa.bank_seen"] = torch.cat((seen, seen.new_zeros(extra)))
    return _with_state(
        head, replace(head.settings, classes=classes, taught=0, taught_alone=False), state
    )


def _with_state(head: Head, settings: HeadSettings, state: dict[str, Tensor]) -> Head:
    with torch.device("meta"):
        model = OmniVaT(settings)
    model.load_state_dict(state, assign=True)
    model.calibration = head.model.calibration
    return replace(head, model=model.eval().requires_grad_(False), settings=settings)
