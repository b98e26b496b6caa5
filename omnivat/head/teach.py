"""Teach a trained head from a few labelled pairs; nothing is trained by gradient.

What the head's probabilities leave over of the labels is learned by a ridge regression on rows in
E, standardised by the source's profile (`omnivat.head.ridge`). The taught head's probabilities are
the softmax of s (t P + Wᵀx + b): the head's prediction P, its share t, and the lessons' map. Where
the head is right, P remains; where it is wrong, or lacks the classes, t falls. The order p moves P
alone. A taught head can be taught again: P is then the prediction of the taught one.
"""

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
import torch
from torch import Tensor
from torch.nn.functional import normalize, pad

from omnivat.head.checkpoint import Head
from omnivat.head.head import OmniVaT
from omnivat.head.ridge import Labels, Ridge, ridge, sharpness
from omnivat.kit.errors import DataError, ShapeError
from omnivat.kit.progress import checkpoint
from omnivat.kit.shapes import floating, require_finite, require_shapes
from omnivat.kit.stages import IMAGES
from omnivat.kit.threads import one_blas_thread, one_thread

FEWEST = 2  # objects of a class, and classes
MOST = 2000  # lessons
FOLDS = 10  # of the objects of a class, at most; those of a fold are tested by one head


@dataclass(frozen=True, slots=True, kw_only=True)
class Lesson:
    """One labelled pair as raw embeddings (1, input_width); one of the two may be None.

    >>> from omnivat import EXAMPLES, load_embeddings
    >>> pairs = load_embeddings(EXAMPLES / "chirps" / "chirps.safetensors")
    >>> touch = torch.tensor(pairs.tac[:1])
    >>> lesson = Lesson(label="a new class", vis=None, tac=touch, object="my first chirp")
    >>> lesson.label, tuple(lesson.tac.shape)
    ('a new class', (1, 64))
    """

    label: str
    vis: Tensor | None
    tac: Tensor | None
    # its name: pairs of one object are left out together; "": an object of its own
    object: str = ""

    def __post_init__(self) -> None:
        for name in IMAGES:
            if (rows := getattr(self, name)) is not None:
                own = floating(name, rows)
                require_shapes(**{name: (own, "B W")})
                require_finite(name, own)
                object.__setattr__(self, name, own)


@dataclass(frozen=True, slots=True, kw_only=True)
class Judged:
    """Predictions for one pair before and after teaching; "after" is taught without its fold."""

    label: str
    before: str
    after: str
    object: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Report:
    """What teaching brings."""

    judged: tuple[Judged, ...]  # each lesson
    share: float  # of the head's own prediction, 0 to 1

    @property
    def before(self) -> int:
        """Return the lessons that the head predicts rightly as it is."""
        return sum(result.before == result.label for result in self.judged)

    @property
    def after(self) -> int:
        """Return the lessons that are right after teaching."""
        return sum(result.after == result.label for result in self.judged)


@one_thread()
@one_blas_thread()
def taught(head: Head, lessons: Sequence[Lesson]) -> Head:
    """Return a head that predicts as the lessons teach; `head` is not modified.

    Features and stages do not change. A class that the head lacks is added. Raises DataError
    without lessons, or with more than 2,000.

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
def judged(head: Head, lessons: Sequence[Lesson]) -> Report:
    """Predict every lesson before and after teaching.

    Folds of objects, with one of each class or a tenth of it, are left out in turn: a head without
    one object alone would be taught less of its class than of the others, and err against it.

    Raises DataError if fewer than two classes have two objects or more.

    >>> from omnivat import default_embeddings, default_head, load_embeddings, load_head
    >>> head, pairs = load_head(default_head()), load_embeddings(default_embeddings())
    >>> rows = pairs.rows_of("TQ-T3D-sim", split="train")[::4]
    >>> vis, tac = (torch.tensor(getattr(pairs, name)[rows]).split(1) for name in IMAGES)
    >>> labels = [pairs.header.classes[k] for k in pairs.label[rows]]
    >>> lessons = [Lesson(label=k, vis=v, tac=t) for k, v, t in zip(labels, vis, tac, strict=True)]
    >>> report = judged(head, lessons)
    >>> report.after > report.before, 0 <= report.share <= 1
    (True, True)
    """
    if lacking := missing(lessons):
        raise DataError(lacking)
    return Work(head, lessons).report()


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
    """Lessons as rows of length 1, both modalities side by side, and what the head predicts."""

    def __init__(self, head: Head, lessons: Sequence[Lesson]) -> None:
        if not lessons:
            raise DataError("There is nothing to learn from; label at least one pair.")
        if len(lessons) > MOST:
            raise DataError(
                f"There are {len(lessons):,} lessons and at most {MOST:,} are taken; train a head "
                "with `python -m omnivat train` instead."
            )
        for rows in (getattr(lesson, name) for lesson in lessons for name in IMAGES):
            if rows is not None and len(rows) != 1:
                raise ShapeError(f"A lesson has {len(rows)} rows; give one of each image, (1, W).")
        self.head, self.lessons = head, lessons
        self.classes = tuple(
            dict.fromkeys([*head.settings.classes, *(lesson.label for lesson in lessons)])
        )
        self.labels = np.array([self.classes.index(lesson.label) for lesson in lessons])
        names = _objects(lessons)
        self.objects = [
            np.flatnonzero([name == other for other in names]) for name in dict.fromkeys(names)
        ]
        width, known = head.settings.input_width, len(head.settings.classes)
        rows = np.zeros((len(lessons), 2, width))  # the part of a missing image stays zero
        self.before = np.zeros((len(lessons), len(self.classes)))  # the head's own prediction
        for places, images in _batches(lessons):
            checkpoint()
            with torch.no_grad():
                out = head.model(images.get("vis"), images.get("tac"))
                self.before[places, :known] = out.probabilities
                for name, raw in images.items():
                    rows[places, IMAGES.index(name)] = head.model.standing(name, raw)
        self.rows = rows.reshape(len(lessons), -1)

    def ridge(self, some: Labels | slice, groups: Sequence[Labels]) -> Ridge:
        """Return the regressions of some lessons; `groups` are places among them."""
        targets = np.eye(len(self.classes))[self.labels[some]]
        return ridge(self.rows[some], targets, self.before[some], groups)

    def report(self) -> Report:
        """Predict each lesson before, and by what the other folds teach."""
        named = [self.classes[label] for label in self.before.argmax(1)]
        after = [self.classes[label] for label in self.after()]
        return Report(
            judged=tuple(
                Judged(label=lesson.label, before=was, after=now, object=lesson.object)
                for lesson, was, now in zip(self.lessons, named, after, strict=True)
            ),
            share=self.ridge(slice(None), self.objects).share(self.objects),
        )

    def after(self, count: int = MOST, order: Labels | None = None) -> Labels:
        """Return the class (L,) of each lesson by heads that the objects of other folds taught, at
        most `count` of a class, in this order.
        """
        after = np.empty(len(self.lessons), np.int64)
        for tested, objects in splits(self.objects, self.labels, count, order):
            checkpoint()
            teach = np.concatenate(objects)
            ends = np.cumsum([len(group) for group in objects])
            groups = np.split(np.arange(len(teach)), ends[:-1])
            solved = self.ridge(teach, groups)
            share = solved.share(groups)
            products = self.rows[tested] @ self.rows[teach].T + 1
            scores = share * self.before[tested] + products @ solved.weights(share)
            after[tested] = scores.argmax(1)
        return after

    def head_taught(self) -> Head:
        """Return the head taught by all lessons."""
        solved = self.ridge(slice(None), self.objects)
        share = solved.share(self.objects)
        sharp = sharpness(solved.apart(share), self.labels)
        weights = sharp * solved.weights(share)
        counts = Counter(lesson.label for lesson in self.lessons)
        taught_classes = {name: counts[name] for name in self.classes if name in counts}
        about = {"taught": taught_classes, "head_share": share}
        head = self.head
        taught = *head.settings.taught, len(head.settings.classes)
        settings = replace(head.settings, classes=self.classes, taught=taught)
        state = _with_classes(head, self.classes, self.lessons)
        for name, value in (
            ("taught_rows", np.stack(np.split(weights.T @ self.rows, 2, axis=1))),
            ("taught_bias", weights.sum(0)),
            ("taught_share", np.array(sharp * share)),
        ):
            last = torch.from_numpy(value)[None].to(head.model.dtype)
            state[name] = torch.cat((state.get(name, last[:0]), last))
        with torch.device("meta"):
            model = OmniVaT(settings)
        model.load_state_dict(state, assign=True)
        model.temperatures = head.model.temperatures
        return replace(
            head,
            model=model.eval().requires_grad_(False),
            provenance={**head.provenance, **about},
            metrics={},
            path=None,
        )


def splits(
    objects: Sequence[Labels], labels: Labels, count: int, order: Labels | None = None
) -> Iterator[tuple[Labels, list[Labels]]]:
    """Yield the lessons that are tested, and the objects that teach: at most `count` of each class,
    the first of those that are not tested. Each lesson is tested once.

    objects  places of each object's lessons;  labels  (L,) of the lessons
    order    of the objects; None: as they stand
    """
    classes: dict[int, list[int]] = {}
    for number in range(len(objects)) if order is None else order.tolist():
        classes.setdefault(int(labels[objects[number][0]]), []).append(number)
    folds = min(FOLDS, max(-(-len(own) // max(1, len(own) - count)) for own in classes.values()))
    for fold in range(folds):
        tested, teach = [], []
        for own in classes.values():
            out = [number for at, number in enumerate(own) if at * folds // len(own) == fold]
            tested += out
            teach += [number for number in own if number not in out][:count]
        yield np.concatenate([objects[k] for k in tested]), [objects[k] for k in teach]


def _batches(lessons: Sequence[Lesson]) -> Iterator[tuple[list[int], dict[str, Tensor]]]:
    """Yield the places of the lessons that have the same images, and those images (B, W)."""
    there = [tuple(n for n in IMAGES if getattr(lesson, n) is not None) for lesson in lessons]
    for names in dict.fromkeys(there):
        places = [place for place, other in enumerate(there) if other == names]
        yield places, {n: torch.cat([getattr(lessons[k], n) for k in places]) for n in names}


@torch.no_grad()
def _with_classes(
    head: Head, classes: tuple[str, ...], lessons: Sequence[Lesson]
) -> dict[str, Tensor]:
    """Return the weights of a head with `classes`, the new ones unseen by its bank and by what it
    was taught before; the direction of a new one, by which tree nodes are classified, is the mean
    of its lessons' unit F̂.
    """
    state = {name: tensor.detach() for name, tensor in head.model.state_dict().items()}
    known = state["classifier"]
    directions = [known]
    for name in classes[len(known) :]:
        outputs = [head.model(lesson.vis, lesson.tac) for lesson in lessons if lesson.label == name]
        hats = torch.cat([rows for output in outputs for rows in output.f_hat.values()])
        mean = normalize(normalize(hats, dim=-1).mean(0), dim=-1)
        directions.append(known.norm(dim=-1).mean() * mean[None])
    state["classifier"] = torch.cat(directions)
    extra = len(classes) - len(known)
    for name in {"mffa.bank", "taught_rows"} & set(state):
        state[name] = pad(state[name], (0, 0, 0, extra))
    for name in {"mffa.bank_seen", "taught_bias"} & set(state):
        state[name] = pad(state[name], (0, extra))
    return state
