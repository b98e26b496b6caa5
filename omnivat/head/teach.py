"""Teach a trained head from a few labelled pairs: two linear maps, blended; nothing is trained by
gradient.

Lessons and the head's own training pairs are rows in E, standardised by the source's profile. Each
map is a ridge regression of one-hot classes on rows, which a linear system solves:

both     training pairs and lessons; the lessons of a class count as WEIGHT pairs together
lessons  the lessons, and training pairs of the classes that no lesson has

The taught head's scores are (1 - t) both + t lessons. The share t has the least squared error over
the lessons, each predicted without its object. It has a closed form and no threshold, so a lesson
more or less moves it little. Predictions of left-out objects follow from the same linear system.

The curve of labels repeats this with fewer objects of each class, drawn several times. The map of
the training pairs alone is solved once, and every draw adds its lessons to it (Schur complement).

Source: stacked regression (Breiman, Machine Learning 24, 1996); leaving out in closed form as in
Rifkin and Lippert, "Notes on regularized least squares" (MIT-CSAIL-TR-2007-025), for whole objects.
"""

from collections.abc import Iterator, Mapping, Sequence
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
from omnivat.kit.errors import DataError
from omnivat.kit.progress import OnStep, Step, checkpoint, ignore
from omnivat.kit.stages import IMAGES

FEWEST = 2  # objects of a class, and classes
MOST = 2000  # lessons
PARTS = ("training pairs and lessons", "lessons alone")
PENALTY = 1.0  # of squared weights; a row has length 1, and a constant 1 beside it
WEIGHT = 10  # of a class's lessons together, in training pairs
SHARPNESS = (0.5, 50.0)  # least and most, of scores
DRAWS = 10  # of the objects that teach, at each count of the curve
COUNTS = (1, 2, 3, 4, 5, 7, 10, 15, 20, 30, 50)  # objects of a class, on the curve
LITTLE = 5  # points within which a gain is told to be small
FOLDS = 10  # of the objects of a class, at most; those of a fold are tested by one head
Rows = NDArray[np.float64]
Labels = NDArray[np.int64]


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


@dataclass(frozen=True, slots=True, kw_only=True)
class Point:
    """Lessons predicted rightly when `objects` objects of each class teach, or what is left of a
    class without the tested fold: the mean share over draws, and the least and the most of a draw.
    """

    objects: int
    right: float
    low: float
    high: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Curve:
    """What labels bring, from one object of each class to all that there are, and in a sentence."""

    points: tuple[Point, ...]
    words: str


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
    return _Work(head, lessons).head_taught()


def judged(head: Head, lessons: Sequence[Lesson], on_step: OnStep = ignore) -> Report:
    """Predict every lesson before and after teaching, its object left out.

    Raises DataError if fewer than two classes have two objects or more.
    """
    if missing := _missing(lessons):
        raise DataError(missing)
    return _Work(head, lessons).report(on_step)


def curve(head: Head, lessons: Sequence[Lesson], on_step: OnStep = ignore) -> Curve:
    """Predict every lesson by heads that fewer objects of each class taught, its own object left
    out. The last point is `judged`.

    Raises DataError if fewer than two classes have two objects or more.
    """
    if missing := _missing(lessons):
        raise DataError(missing)
    return _Work(head, lessons).curve(on_step)


def _missing(lessons: Sequence[Lesson]) -> str:
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


@dataclass(frozen=True, slots=True)
class Ridge:
    """A ridge regression of one-hot classes, and its predictions for rows that it did not see."""

    weights: Rows  # (2 W, K)
    bias: Rows  # (K,)
    apart: Rows  # (L, K) scores of each lesson by the regression without its object


def ridge(
    rows: Rows, labels: Labels, counts: Rows, classes: int, groups: Sequence[Labels]
) -> Ridge:
    """Solve the regression of one-hot labels (N,) on rows (N, 2 W) of which each counts `counts`
    (N,) times.

    groups  the places of each object's lessons, which are left out together; lessons are the first
            rows

    """
    targets = np.eye(classes)[labels]
    shares, errors = solved(rows @ rows.T + 1 + PENALTY * np.diag(1 / counts), targets, groups)
    return Ridge(rows.T @ shares, shares.sum(0), targets[: len(errors)] - errors)


def solved(matrix: Rows, targets: Rows, groups: Sequence[Labels]) -> tuple[Rows, Rows]:
    """Return a = matrix⁻¹ targets (N, K), and the errors (L, K) of each group's rows without it:
    (matrix⁻¹ of the group)⁻¹ (a of the group). The L rows of all groups are the first ones.
    """
    inverse = np.linalg.inv(matrix)
    shares = inverse @ targets
    errors = np.empty((sum(map(len, groups)), targets.shape[1]))
    for group in groups:
        errors[group] = np.linalg.solve(inverse[np.ix_(group, group)], shares[group])
    return shares, errors


def weight_of(labels: Labels) -> float:
    """Return how many training pairs each lesson counts as."""
    return max(1.0, WEIGHT * len(np.unique(labels)) / len(labels))


def share_of_lessons(both: Rows, lessons: Rows) -> float:
    """Return t, 0 to 1, with the least squared error of (1 - t) both + t lessons: errors (L, K)
    of each map.
    """
    apart = both - lessons
    return float(np.clip((both * apart).sum() / max((apart**2).sum(), 1e-12), 0, 1))


def sharpness(scores: Rows, labels: Labels) -> float:
    """Return the factor of scores (L, K) whose softmax has the least log loss, within SHARPNESS.

    One more lesson, of every class alike, keeps it finite.
    """
    own, count = scores[np.arange(len(labels)), labels], len(labels)
    low, high = SHARPNESS
    for _ in range(40):  # the slope of the loss rises with the factor
        factor = (low + high) / 2
        shares = np.exp(factor * (scores - scores.max(1, keepdims=True)))
        mean = (shares / shares.sum(1, keepdims=True) * scores).sum(1)
        slope = (mean - own).sum() + (mean - scores.mean(1)).sum() / count
        low, high = (factor, high) if slope < 0 else (low, factor)
    return high


def splits(
    objects: Sequence[Labels], labels: Labels, count: int, random: np.random.Generator
) -> Iterator[tuple[Labels, list[Labels]]]:
    """Yield the lessons that are tested, and the objects that teach: at most `count` of each class,
    drawn from those that are not tested. Each lesson is tested once.

    objects  places of each object's lessons;  labels  (L,) of the lessons
    """
    classes: dict[int, list[int]] = {}
    for number in random.permutation(len(objects)).tolist():
        classes.setdefault(int(labels[objects[number][0]]), []).append(number)
    folds = min(FOLDS, max(-(-len(own) // max(1, len(own) - count)) for own in classes.values()))
    for fold in range(folds):
        tested, teach = [], []
        for own in classes.values():
            out = [number for at, number in enumerate(own) if at * folds // len(own) == fold]
            tested += out
            teach += [number for number in own if number not in out][:count]
        yield np.concatenate([objects[k] for k in tested]), [objects[k] for k in teach]


def curve_in_words(counts: Sequence[int], right: Sequence[Rows]) -> str:
    """Return what labels bring, in words; a difference counts beyond two standard errors over
    lessons, and beyond two lessons.

    counts  objects of a class;  right  at each count, (L,) share of draws that have a lesson right
    """
    if len(counts) < 2:
        return "Label a third object of a class to see what more labels bring."

    def step(first: int, last: int) -> tuple[float, float, str]:
        change = 100 * (right[last] - right[first])
        gain, lesson = change.mean(), 100 / len(change)
        twice = 2 * max(change.std(ddof=1) / len(change) ** 0.5, lesson)
        words = f"from {counts[first]} to {counts[last]} objects a class: {round(gain):+d} points"
        return gain, twice, f"{words}, give or take {twice:.0f}"

    gain, twice, whole = step(0, len(counts) - 1)
    if abs(gain) <= twice:
        told = "More labels bring little here" if twice <= LITTLE else "Too few labels to tell"
        return f"{told}: {whole}."
    if len(counts) < 3:
        return f"F{whole[1:]}."
    gain, twice, last = step(len(counts) - 2, len(counts) - 1)
    told = "more labels may bring more" if gain > twice else "no gain that can be told from chance"
    return f"F{whole[1:]}. The last step, {last}: {told}."


class _Work:
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
        self.spans: dict[bytes, tuple[Rows, Rows]] = {}  # by training pairs

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
        return 0.0 if _missing(self.lessons) else share_of_lessons(*self.errors)

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
                name: int((self._best(one.apart) == self.labels).sum())
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
            after[group] = self._best(self.blended(both[group], alone[group], share))
        return after

    def curve(self, on_step: OnStep) -> Curve:
        """Teach with COUNTS objects of each class, DRAWS times, and with all."""
        classes = [self.labels[group[0]] for group in self.objects]
        most = int(np.bincount(classes).max()) - 1
        counts = [*(count for count in COUNTS if count < most), most]
        random = np.random.default_rng(0)
        right: list[Rows] = []
        for count in counts[:-1]:
            on_step(Step(done=len(right), total=len(counts)))
            right.append(np.stack([self.drawn(count, random) for _ in range(DRAWS)]))
        on_step(Step(done=len(right), total=len(counts)))
        right.append((self.after() == self.labels)[None].astype(float))
        means = [each.mean(1) for each in right]
        points = tuple(
            Point(objects=count, right=float(m.mean()), low=float(m.min()), high=float(m.max()))
            for count, m in zip(counts, means, strict=True)
        )
        return Curve(points=points, words=curve_in_words(counts, [each.mean(0) for each in right]))

    def drawn(self, count: int, random: np.random.Generator) -> Rows:
        """Return (L,) 1 for a lesson that `count` objects of each class, drawn, have right."""
        right = np.zeros(len(self.lessons))
        for tested, objects in splits(self.objects, self.labels, count, random):
            checkpoint()
            teach = np.concatenate(objects)
            ends = np.cumsum([len(group) for group in objects])
            groups = [
                np.arange(end - len(group), end) for end, group in zip(ends, objects, strict=True)
            ]
            labels, weight = self.labels[teach], weight_of(self.labels[teach])
            scores, errors = [], []
            for kept in self.kept(labels):
                products, by_source = self.beyond(kept)
                targets = np.eye(len(self.classes))[labels] - by_source[teach]
                matrix = products[np.ix_(teach, teach)] + PENALTY / weight * np.eye(len(teach))
                shares, apart = solved(matrix, targets, groups)
                scores.append(by_source[tested] + products[np.ix_(tested, teach)] @ shares)
                errors.append(apart)
            share = 0.0 if _missing([self.lessons[k] for k in teach]) else share_of_lessons(*errors)
            right[tested] = (
                self._best(self.blended(scores[0], scores[1], share)) == self.labels[tested]
            )
        return right

    def beyond(self, kept: NDArray[np.bool_]) -> tuple[Rows, Rows]:
        """Return the products (L, L) of the lessons beyond what the training pairs `kept` span, and
        their scores (L, K) by the map of these pairs.
        """
        key = kept.tobytes()
        if key not in self.spans:
            source, lessons = self.source[kept], len(self.rows)
            across = source @ self.rows.T + 1
            found = np.linalg.solve(
                source @ source.T + 1 + PENALTY * np.eye(len(source)),
                np.concatenate((across, np.eye(len(self.classes))[self.known[kept]]), axis=1),
            )
            products = self.rows @ self.rows.T + 1 - across.T @ found[:, :lessons]
            self.spans[key] = products, across.T @ found[:, lessons:]
        return self.spans[key]

    def _best(self, scores: Rows) -> Labels:
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
