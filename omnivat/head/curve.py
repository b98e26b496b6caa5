"""How many more labels? What fewer lessons would have taught, by the rule of `teach`.

With 1, 2, 3, ... objects of each class, drawn several times, every lesson is predicted by a head
that its object did not teach.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from omnivat.head.checkpoint import Head
from omnivat.head.ridge import Rows
from omnivat.head.teach import Lesson, Work, missing
from omnivat.kit.errors import DataError
from omnivat.kit.progress import OnStep, Step, ignore
from omnivat.kit.threads import one_blas_thread, one_thread

DRAWS = 10  # of the objects that teach, at each count of the curve
COUNTS = (1, 2, 3, 4, 5, 7, 10, 15, 20, 30, 50)  # objects of a class, on the curve
LITTLE = 5  # points within which a gain is called small


@dataclass(frozen=True, slots=True, kw_only=True)
class Point:
    """Lessons predicted rightly when `objects` objects of each class teach, or what is left of a
    class without the tested fold: the mean share over draws, and the least and the most of a draw.
    """

    objects: int
    right: float
    least: float
    most: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Curve:
    """What labels bring, from one object of each class to all that there are, and in a sentence."""

    points: tuple[Point, ...]
    words: str


@one_thread()
@one_blas_thread()
def curve(head: Head, lessons: Sequence[Lesson], on_step: OnStep = ignore) -> Curve:
    """Predict every lesson by heads that fewer objects of each class taught, its own object left
    out. The last point is `judged`.

    Raises DataError if fewer than two classes have two objects or more.

    >>> import torch
    >>> from omnivat import EXAMPLES, load_embeddings, load_head
    >>> head = load_head(EXAMPLES / "chirps" / "head")
    >>> pairs = load_embeddings(EXAMPLES / "chirps" / "chirps.safetensors")
    >>> lessons = [
    ...     Lesson(label=str(pairs.label[row]), vis=None, tac=torch.tensor(pairs.tac[row])[None])
    ...     for row in pairs.rows_of("Chirps B-sim")[::10]
    ... ]
    >>> found = curve(head, lessons)  # twenty touches of five classes
    >>> [point.objects for point in found.points], found.words[:22]
    ([1, 2, 3], 'Too few labels to tell')
    """
    if lacking := missing(lessons):
        raise DataError(lacking)
    work = Work(head, lessons)
    most = int(np.bincount([work.labels[group[0]] for group in work.objects]).max()) - 1
    counts = [*(count for count in COUNTS if count < most), most]
    random = np.random.default_rng(0)
    right: list[Rows] = []
    for count in counts:
        on_step(Step(done=len(right), total=len(counts)))
        orders = [random.permutation(len(work.objects)) for _ in range(DRAWS)]
        draws = [work.after(count, order) for order in orders] if count < most else [work.after()]
        right.append((np.stack(draws) == work.labels).astype(float))
    means = [each.mean(1) for each in right]
    points = tuple(
        Point(objects=count, right=float(m.mean()), least=float(m.min()), most=float(m.max()))
        for count, m in zip(counts, means, strict=True)
    )
    return Curve(points=points, words=curve_in_words(counts, [each.mean(0) for each in right]))


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
        finding = "More labels bring little here" if twice <= LITTLE else "Too few labels to tell"
        return f"{finding}; {whole}."
    if len(counts) < 3:
        return f"F{whole[1:]}."
    gain, twice, last = step(len(counts) - 2, len(counts) - 1)
    clear, unclear = "more labels may bring more", "no gain that can be told from chance"
    finding = clear if gain > twice else unclear
    return f"F{whole[1:]}. The last step, {last}: {finding}."
