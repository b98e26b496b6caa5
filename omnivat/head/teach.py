"""Teach a trained head from a few labelled pairs; nothing is trained by gradient.

Lessons and the head's own training pairs decide together, in E, standardised by the source's
profile. Four methods compete, and whole objects are left out to choose between them:

logistic regression   chosen unless another is clearly better: on the training pairs and the lessons, which count several times
nearest class mean    the mean of a class's lessons; of its training pairs if it has none
nearest neighbour     among the lessons, and the training pairs of classes without lessons
class directions      means in F-hat join the directions that the head has learned
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
from omnivat.head.settings import HeadSettings
from omnivat.kit.errors import DataError, SettingsError
from omnivat.kit.logistic import Problem
from omnivat.kit.progress import OnStep, Step, ignore
from omnivat.kit.stages import IMAGES

FEWEST = 2  # objects of a class, and classes
MOST = 2000  # lessons
METHODS = ("logistic regression", "nearest class mean", "nearest neighbour", "class directions")
LOGISTIC, MEAN, NEIGHBOUR, DIRECTIONS = METHODS
STRENGTH, TOTAL = 1.0, 20  # C; weight of a class's lessons together, in pairs
SHARPNESS = 10.0  # of cosines
Rows = NDArray[np.float64]
Labels = NDArray[np.int64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Lesson:
    """One labelled pair as raw embeddings (1, input_width); one of the two may be None."""

    label: str
    vis: Tensor | None
    tac: Tensor | None
    object: str = ""  # its name: pairs of one object are left out together; "": an object of its own


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

    judged: tuple[Judged, ...]  # each lesson. The method is chosen without it: by the other objects' predictions
    method: str  # the best method over all lessons, which `taught` uses
    right: Mapping[str, int]  # method -> lessons that it predicts rightly, each object left out

    @property
    def before(self) -> int:
        """Return the lessons that the head predicts rightly as it is."""
        return sum(one.before == one.label for one in self.judged)

    @property
    def after(self) -> int:
        """Return the lessons that are right after teaching."""
        return sum(one.after == one.label for one in self.judged)


def taught(head: Head, lessons: Sequence[Lesson], method: str = "") -> Head:
    """Return a head that predicts as the lessons teach; `head` is not modified.

    method  one of METHODS; "": chosen by leaving objects out, or logistic regression with too few

    Features and stages do not change. A class that the head lacks is added. With a method other than class directions,
    the order p has no influence on the prediction. Raises DataError without lessons, or with more than 2,000.
    """
    work = _Work(head, lessons)
    if not method:
        enough = _missing(lessons) == ""
        method = work.report(ignore).method if enough else work.methods[0]
    elif method not in work.methods:
        raise SettingsError(f"There is no method '{method}' here; choose {', '.join(work.methods)}.")
    return work.head_of(method)


def judged(head: Head, lessons: Sequence[Lesson], on_step: OnStep = ignore) -> Report:
    """Predict every lesson before and after teaching, its object left out.

    Raises DataError if fewer than two classes have two objects or more.
    """
    if missing := _missing(lessons):
        raise DataError(missing)
    return _Work(head, lessons).report(on_step)


def _missing(lessons: Sequence[Lesson]) -> str:
    """Return what is missing before lessons can be judged, or ""."""
    objects: dict[str, set[str]] = {}
    for one, name in zip(lessons, _objects(lessons), strict=True):
        objects.setdefault(one.label, set()).add(name)
    if sum(len(own) >= FEWEST for own in objects.values()) >= FEWEST:
        return ""
    there = ", ".join(f"{label} {len(own)}" for label, own in objects.items()) or "none yet"
    return f"Label two or more pairs of each of two or more classes first, of different objects; there are: {there}."


def _objects(lessons: Sequence[Lesson]) -> list[str]:
    return [one.object or f"\0{index}" for index, one in enumerate(lessons)]


class _Work:
    """Lessons and training pairs as rows: unit length in each modality, both side by side."""

    def __init__(self, head: Head, lessons: Sequence[Lesson]) -> None:
        if not lessons:
            raise DataError("There is nothing to learn from; label at least one pair.")
        if len(lessons) > MOST:
            raise DataError(
                f"There are {len(lessons):,} lessons and at most {MOST:,} are taken; train a head "
                "with `python -m omnivat train` instead."
            )
        self.head, self.lessons = head, lessons
        self.classes = tuple(dict.fromkeys([*head.settings.classes, *(one.label for one in lessons)]))
        self.labels = np.array([self.classes.index(one.label) for one in lessons])
        self.rows = np.concatenate([_row(head.model, one) for one in lessons])
        self.source, self.source_labels = _training_rows(head)
        names = _objects(lessons)
        place = {name: index for index, name in enumerate(dict.fromkeys(names))}
        self.objects = np.array([place[name] for name in names])
        self.means = torch.stack([_mean_direction(head.model, one) for one in lessons])
        self.methods = METHODS if len(self.source) else (DIRECTIONS, MEAN, NEIGHBOUR)
        self._start: Rows | None = None

    @cached_property
    def _problem(self) -> Problem:
        """All rows in the basis of their span, which is computed once."""
        both = torch.from_numpy(np.concatenate((self.source, self.rows)))
        labels = torch.from_numpy(np.concatenate((self.source_labels, self.labels)))
        return Problem.of(both, labels, len(self.classes))

    def report(self, on_step: OnStep) -> Report:
        """Leave each object out and predict its lessons by every method."""
        before = [_said(self.head, one) for one in self.lessons]
        found = {name: np.zeros(len(self.lessons), np.int64) for name in self.methods}
        apart = [self.objects == held for held in np.unique(self.objects)]
        for done, out in enumerate(apart):
            on_step(Step(done=done, total=len(apart)))
            for name in self.methods:
                found[name][out] = self._predicted(name, ~out, out)
        right = {name: said == self.labels for name, said in found.items()}
        after = np.empty(len(self.lessons), np.int64)
        for out in apart:
            best = self._best({name: int(values[~out].sum()) for name, values in right.items()})
            after[out] = found[best][out]
        scores = {name: int(values.sum()) for name, values in right.items()}
        return Report(
            judged=tuple(
                Judged(label=one.label, before=was, after=self.classes[said], object=one.object)
                for one, was, said in zip(self.lessons, before, after, strict=True)
            ),
            method=self._best(scores),
            right=scores,
        )

    def _best(self, right: Mapping[str, int]) -> str:
        """Return the best method; the first one unless another is better by more than chance.

        Half of √N is about the standard error of a difference of two counts of N lessons.
        """
        first, best = self.methods[0], max(self.methods, key=right.__getitem__)
        return best if right[best] - right[first] > len(self.lessons) ** 0.5 / 2 else first

    def _predicted(self, method: str, kept: NDArray[np.bool_], out: NDArray[np.bool_]) -> Labels:
        if method == DIRECTIONS:
            labels = [one.label for one, keep in zip(self.lessons, kept, strict=True) if keep]
            other = _with_means(self.head, self.means[torch.from_numpy(kept)], labels)
            said = [_said(other, self.lessons[row]) for row in np.flatnonzero(out).tolist()]
            return np.array([self.classes.index(name) for name in said])
        rows, bias, owner = self.deciding(method, kept)
        answers: Labels = owner[(self.rows[out] @ rows.T + bias).argmax(1)]
        return answers

    def deciding(self, method: str, kept: NDArray[np.bool_]) -> tuple[Rows, Rows, Labels]:
        """Return rows (P, 2 W), biases (P,) and classes (P,): the largest score decides."""
        if method == LOGISTIC:
            weight, bias = self._logistic(kept)
            present = np.unique(np.concatenate((self.source_labels, self.labels[kept])))
            return weight[present], bias[present], present
        lessons, labels = self.rows[kept], self.labels[kept]
        rest = ~np.isin(self.source_labels, labels)
        rows = np.concatenate((lessons, self.source[rest]))
        owner = np.concatenate((labels, self.source_labels[rest]))
        if method == MEAN:
            names = np.unique(owner)
            rows, owner = np.stack([rows[owner == name].mean(0) for name in names]), names
        rows = rows / np.maximum(np.linalg.norm(rows, axis=1, keepdims=True), 1e-12)
        return SHARPNESS * rows, np.zeros(len(rows)), owner

    def _logistic(self, kept: NDArray[np.bool_]) -> tuple[Rows, Rows]:
        """Return weights (K, 2 W) and biases (K,); the search begins at the last solution."""
        each = len(self.lessons) / len(np.unique(self.labels))
        times = int(np.clip(TOTAL // each, 2, TOTAL))
        count, whole = len(self.source), self._problem
        index = np.concatenate((np.arange(count), np.tile(count + np.flatnonzero(kept), times)))
        part = replace(whole, inside=whole.inside[index], labels=whole.labels[index])
        self._start = part.solved(STRENGTH, part.start() if self._start is None else self._start, tolerance=1e-4)
        weight, bias = part.parameters(self._start)
        return weight.numpy(), bias.numpy()

    def head_of(self, method: str) -> Head:
        """Return the head taught by all lessons."""
        labels = [one.label for one in self.lessons]
        found = _with_means(self.head, self.means, labels)
        found = replace(found, provenance={**found.provenance, "taught_by": method})
        if method == DIRECTIONS:
            return found
        rows, bias, owner = self.deciding(method, np.ones(len(labels), bool))
        dtype = found.model.dtype
        own = {
            "taught_rows": torch.from_numpy(np.stack(np.split(rows, 2, axis=1))).to(dtype),
            "taught_bias": torch.from_numpy(bias).to(dtype),
            "taught_class": torch.from_numpy(owner),
        }
        settings = replace(found.settings, taught=len(rows))
        return _with_state(found, settings, {**found.model.state_dict(), **own})


@torch.no_grad()
def _row(model: OmniVaT, lesson: Lesson) -> Rows:
    """Return the row (1, 2 W) of a pair; the part of a missing image is zero."""
    given = {"vis": lesson.vis, "tac": lesson.tac}
    width = model.settings.input_width
    parts = [torch.zeros(1, width) if raw is None else model.standing(name, raw) for name, raw in given.items()]
    row: Rows = torch.cat(parts, dim=1).double().numpy()
    return row


@torch.no_grad()
def _training_rows(head: Head) -> tuple[Rows, Labels]:
    """Return the head's training pairs as rows, with their classes; none for an older head."""
    kept, width = head.familiarity, head.settings.input_width
    if kept is None or kept.labels is None or set(kept.lengths) != set(IMAGES):
        return np.zeros((0, 2 * width)), np.zeros(0, np.int64)
    raw = {name: kept.rows[name] * kept.lengths[name][:, None] for name in IMAGES}
    parts = [head.model.standing(name, raw[name]) for name in IMAGES]
    return torch.cat(parts, dim=1).double().numpy(), kept.labels.numpy()


@torch.no_grad()
def _mean_direction(model: OmniVaT, lesson: Lesson) -> Tensor:
    """Return the mean (D,) of the unit F̂ of the pair's images."""
    return torch.cat([normalize(rows, dim=-1) for rows in model(lesson.vis, lesson.tac).f_hat.values()]).mean(0)


@torch.no_grad()
def _said(head: Head, lesson: Lesson) -> str:
    probabilities = head.model(lesson.vis, lesson.tac).probabilities[0]
    return head.settings.classes[int(probabilities.argmax())]


def _with_means(head: Head, means: Tensor, labels: Sequence[str]) -> Head:
    """Return the head with directions of class means (B, D) added to its own, by label."""
    own = head.settings.classes
    classes = tuple(dict.fromkeys([*own, *labels]))
    state = {n: x.detach() for n, x in head.model.state_dict().items() if not n.startswith("taught_")}
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
    counts = {label: list(labels).count(label) for label in dict.fromkeys(labels)}
    found = replace(head, provenance={**head.provenance, "taught": counts}, metrics={}, path=None)
    return _with_state(found, replace(head.settings, classes=classes, taught=0), state)


def _with_state(head: Head, settings: HeadSettings, state: dict[str, Tensor]) -> Head:
    with torch.device("meta"):
        model = OmniVaT(settings)
    model.load_state_dict(state, assign=True)
    model.calibration = head.model.calibration
    return replace(head, model=model.eval().requires_grad_(False), settings=settings)
