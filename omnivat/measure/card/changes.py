"""What changed between two cards, the likeliest first, with the evidence and the remedy."""

from collections.abc import Iterable, Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from omnivat.data.arranged import WAYS, options_of
from omnivat.measure.card.card import SensorCard, card_of, cosine
from omnivat.measure.card.traits import Array

FITS = 0.9  # least likeness at which an arrangement explains what changed
GAIN = 0.12  # of likeness over the pictures as they are, from which on an arrangement is named
FAR, NEARLY = 0.5, 0.8  # a gain so large that a poorer fit is enough: the lamps changed, too
OBJECTS = 0.05  # by which the logarithm of relief differs between kinds of objects
LEAST = 0.12  # error of a difference of the strength: less is luck of the pictures
SURE = 3.0  # standard errors of a difference, from which on it is named
AGREED = 2.5  # the same for the strength, of which two signs have to agree
APART = 0.035  # of 1 less the cosine of two lamps
STEADY = 20.0  # degrees by which a colour's direction may differ before it counts as turned
COLOURS = ("red", "green", "blue")
PROFILE = "A profile of 20 pictures undoes a part of it: omnivat profile."
MEND = (
    "Read them as the old sensor's: omnivat embed PAIRS --out SET.safetensors {}; try, predict and"
    " profile take this, too."
)
RELIEF = "Read touches by their relief, with the sensor's own lamps: --touch relief."
# points that touch loses if only this part changes: from every gel to every other, and with the
# dots filled (docs/benchmarks/twins.json, "parts")
COSTS = {
    "dots": (19.3, 0.5),
    "lamps": (7.9, 4.0),
    "noise": (3.4, 1.7),
    "sharpness": (3.3, 1.1),
    "tint": (2.1, 0.6),
    "scale": (1.7, 0.7),
}


class Change(NamedTuple):
    """One part of a sensor that changed.

    size  the difference over the smallest one named
    way   the arrangement of touches that mends it (`omnivat.data.arranged`)
    """

    part: str
    evidence: str
    remedy: str
    size: float
    way: str = ""


class Arrangement(NamedTuple):
    """How one sensor's pictures become those of another.

    way     as `omnivat.data.arranged` has it; `back` undoes it
    slopes  (2, 2): turns slopes to the right and downwards
    """

    part: str
    words: str
    way: str
    back: str
    slopes: tuple[tuple[int, int], tuple[int, int]]

    @property
    def channels(self) -> tuple[int, ...]:
        """The order of red, green and blue."""
        return (2, 1, 0) if self.way == "bgr" else (0, 1, 2)

    def grid(self, field: Array) -> Array:
        """Return an array (h, w, 3) in this arrangement."""
        return WAYS[self.way](field) if self.way else field


class Measure(NamedTuple):
    """A number of every picture, and the smallest difference of its mean that is named."""

    part: str
    row: str
    least: float
    more: str  # what B is if its number is larger; {} is the change
    less: str
    remedy: str


AS_IT_IS = Arrangement("", "", "", "", ((1, 0), (0, 1)))
ARRANGEMENTS = (
    Arrangement("channels", "Red and blue are swapped", "bgr", "bgr", ((1, 0), (0, 1))),
    Arrangement("mirrored", "Pictures are mirrored from left to right", "left-right", "left-right",
                ((-1, 0), (0, 1))),
    Arrangement("mirrored", "Pictures are mirrored from top to bottom", "top-bottom", "top-bottom",
                ((1, 0), (0, -1))),
    Arrangement("turned", "Pictures are turned by 180°", "half-turn", "half-turn",
                ((-1, 0), (0, -1))),
    Arrangement("turned", "Pictures are turned by 90° clockwise", "clockwise", "anticlockwise",
                ((0, -1), (1, 0))),
    Arrangement("turned", "Pictures are turned by 90° anticlockwise", "anticlockwise", "clockwise",
                ((0, 1), (-1, 0))),
)  # fmt: skip
MEASURES = (
    Measure("strength", "strength", 0.16, "a slope adds {} more colour",
            "a slope adds {} less colour", RELIEF),
    Measure("sharpness", "sharpness", 0.12, "edges are {} sharper", "edges are {} less sharp",
            f"Focus the camera. {PROFILE}"),
    Measure("sharpness", "softness", 0.25, "soft edges are {} sharper", "soft edges are {} weaker",
            f"Focus the camera. {PROFILE}"),
    Measure("noise", "noise", 0.2, "grain is {} stronger", "grain is {} weaker", PROFILE),
    Measure("tint", "red", 0.06, "the gel looks {} redder beside green",
            "the gel looks {} less red beside green", PROFILE),
    Measure("tint", "blue", 0.06, "the gel looks {} bluer beside green",
            "the gel looks {} less blue beside green", PROFILE),
    Measure("tint", "brightness", 0.1, "the gel is {} brighter", "the gel is {} darker", PROFILE),
    Measure("scale", "pitch", 0.06, "dots lie {} wider apart in the picture",
            "dots lie {} closer together in the picture",
            "Crop the pictures to the same field of the gel."),
)  # fmt: skip


def sensor_card(pictures: Iterable[Array], against: Iterable[Array] | None = None) -> SensorCard:
    """Return the card of a sensor from touches without labels, and what changed.

    pictures  5 to 200 touch images of one sensor, (H, W, 3) uint8; 25 show most
    against   touches of another sensor, or of the same one before; objects may be others. The
              card's `changes` then lists what changed, the likeliest first; () if nothing did

    Raises DataError for fewer than 5 pictures.

    >>> from omnivat import EXAMPLES
    >>> from omnivat.data.images import read_image
    >>> files = sorted((EXAMPLES / "pairs" / "TAG-sim").glob("*/*_tac.jpg"))
    >>> touches = [np.asarray(read_image(file)) for file in files]
    >>> swapped = sensor_card([one[..., ::-1] for one in touches], against=touches)
    >>> [change.part for change in swapped.changes]
    ['channels']
    """
    card = card_of(pictures)
    if against is None:
        return card
    return replace(card, changes=changes_between(card_of(against), card))


def changes_between(old: SensorCard, new: SensorCard) -> tuple[Change, ...]:
    """Return what changed from one sensor, or one state of it, to another; () if nothing did."""
    arranged, kept = arrangement_of(old, new)
    found = [] if kept is None else [kept]
    rest = [
        *dots_changed(old, new),
        *lamps_changed(old, new, arranged),
        *numbers_changed(old, new, arranged),
    ]
    grain = new.of("noise")[0] - old.of("noise")[0]
    if grain > 0 and any(change.part == "noise" for change in rest):  # which drowns edges
        rest = [change for change in rest if change.part != "sharpness"]
    # a crop also softens edges, and softening after the camera also smooths grain
    first = ("scale", "sharpness" if grain < 0 else "")
    rest.sort(key=lambda change: (change.part not in first, -change.size))
    seen: set[str] = set()
    for change in rest:  # the strongest evidence of each part
        if change.part not in seen:
            seen.add(change.part)
            found.append(change)
    return tuple(found)


def arrangement_of(old: SensorCard, new: SensorCard) -> tuple[Arrangement, Change | None]:
    """Return how the old sensor's pictures are arranged in the new one's, and the change if any."""
    before = likeness(old, new, AS_IT_IS)
    best, after = AS_IT_IS, before
    for arrangement in ARRANGEMENTS:
        now = likeness(old, new, arrangement)
        if now.mean() > after.mean():
            best, after = arrangement, now
    gained = float(after.mean() - before.mean())
    if best is AS_IT_IS or after.min() < (FITS if gained < FAR else NEARLY) or gained < GAIN:
        return AS_IT_IS, None
    evidence = (
        f"{best.words}: so arranged, the old sensor's light and lamps fit the new one's at"
        f" {after.mean():.2f}, and at {before.mean():.2f} as they are (1 is a perfect fit)."
    )
    return best, Change(
        best.part, evidence, MEND.format(options_of(best.back)), gained / GAIN, best.back
    )


def likeness(old: SensorCard, new: SensorCard, way: Arrangement) -> Array:
    """Return cosines of the gel's light and, where both are known, of the lamps."""
    field = way.grid(old.field)
    if field.shape != new.field.shape:
        return np.zeros(1)
    found = [cosine(centred(field), centred(new.field))]
    if old.lamps is not None and new.lamps is not None:
        found.append(abs(cosine(turned(old.lamps.colours, way), new.lamps.colours)))
    return np.array(found)


def centred(field: Array) -> Array:
    """Return the gel's light (h, w, 3) less its mean brightness: unevenness and tint."""
    return np.asarray(field / max(field.mean(), 1e-6) - 1)


def turned(colours: Array, way: Arrangement) -> Array:
    """Return the lamps' colours (3, 2) of pictures that are arranged so."""
    return np.asarray(colours[list(way.channels)] @ np.array(way.slopes).T)


def lamps_changed(old: SensorCard, new: SensorCard, way: Arrangement) -> Iterator[Change]:
    """Yield the change of the lamps, if both cards have them."""
    if old.lamps is None or new.lamps is None:
        return
    a, b = (
        colours / np.linalg.norm(colours)
        for colours in (turned(old.lamps.colours, way), new.lamps.colours)
    )
    b = b if (a * b).sum() > 0 else -b
    unsure = 1.5 * (2 - old.lamps.confidence - new.lamps.confidence)
    size = (1 - float((a * b).sum())) / max(APART, unsure)
    if size > 1:
        yield Change(
            "lamps",
            f"{difference(a, b)} Likeness of the lamps: {(a * b).sum():.2f} (1 is the same).",
            RELIEF,
            size,
        )


def difference(a: Array, b: Array) -> str:
    """Return a sentence on how the lamps b differ from the lamps a.

    a, b  (3, 2): colour (R, G, B) by direction (right, down), with the strength as length
    """
    angles = [np.degrees(np.arctan2(lamps[:, 1], -lamps[:, 0])) for lamps in (a, b)]
    turns = (angles[1] - angles[0] + 180) % 360 - 180
    weight = np.linalg.norm(a, axis=1)
    middle = float(np.average(turns, weights=weight))
    if abs(middle) > STEADY and np.abs(turns - middle)[weight > 0.3].max(initial=0) < 2 * STEADY:
        return f"The lamps are turned by {abs(middle):.0f}°, {'anti' * (middle > 0)}clockwise."
    ratios = np.linalg.norm(b, axis=1) / np.maximum(weight, 1e-6)
    ratios /= np.median(ratios)
    worst = int(np.abs(np.log(ratios)).argmax())
    if np.abs(np.log(ratios[worst])) > np.log(1.2):
        word = "stronger" if ratios[worst] > 1 else "weaker"
        return (
            f"The {COLOURS[worst]} light is {100 * abs(ratios[worst] - 1):.0f} % {word} beside the"
            " others."
        )
    return "Directions or colours of the lamps differ."


def dots_changed(old: SensorCard, new: SensorCard) -> Iterator[Change]:
    """Yield the change of the printed dots."""
    a, b = (float(card.rows["dots"].mean()) for card in (old, new))
    shared = (a * old.pictures + b * new.pictures) / (old.pictures + new.pictures)
    spread = np.sqrt(shared * (1 - shared) * (1 / old.pictures + 1 / new.pictures))
    size = abs(b - a) / max(0.35, SURE * float(spread))
    if size > 1 or (abs(b - a) > 0.9):
        verb = "has gained" if b > a else "has lost"
        yield Change(
            "dots",
            f"The gel {verb} printed dots: {100 * a:.0f} % of the old pictures show a grid of"
            f" dots, and {100 * b:.0f} % of the new.",
            "Fill the dots, as every command does without --dots keep.",
            max(size, 1.0),
        )


def numbers_changed(old: SensorCard, new: SensorCard, way: Arrangement) -> Iterator[Change]:
    """Yield the changes of what has a number in every picture."""
    sized = ""
    if min(new.size) != min(old.size):
        sizes = " × ".join(map(str, new.size)), " × ".join(map(str, old.size))
        sized = " The pictures have {} pixels and had {}, which alone changes this.".format(*sizes)
    for measure in MEASURES:
        row = measure.row
        if row == "pitch" and min(old.of("dots")[0], new.of("dots")[0]) < 0.5:
            continue
        (a, spread_a), (b, spread_b) = old.of(row), new.of(row)
        if way.channels != AS_IT_IS.channels and row in ("red", "blue"):
            a, spread_a = old.of("blue" if row == "red" else "red")
        step = np.log(b / a) if row == "pitch" else b - a
        error = float(np.hypot(spread_a, spread_b)) / (a if row == "pitch" else 1)
        if row == "strength":
            step, error = supported(step, error, old, new)
        sure = AGREED if row == "strength" else SURE
        size = abs(step) / max(measure.least, sure * error)
        if size > 1:
            words = measure.more if step > 0 else measure.less
            sentence = words.format(f"{100 * abs(np.expm1(step)):.0f} %")
            yield Change(
                measure.part,
                f"{sentence[0].upper()}{sentence[1:]} ({abs(step) / max(error, 1e-9):.0f} standard"
                f" errors).{sized if measure.part in ('sharpness', 'noise') else ''}",
                measure.remedy,
                float(size),
            )


def supported(step: float, error: float, old: SensorCard, new: SensorCard) -> tuple[float, float]:
    """Return the difference of the strength and its standard error, joined with the relief's.

    Each alone is led astray by objects: darkening by a few steep ones, relief by their kind. So no
    difference is left if the two have opposite signs.
    """
    (a, spread_a), (b, spread_b) = old.of("relief"), new.of("relief")
    both, error = np.array([step, b - a]), max(error, LEAST)
    if not np.prod(both) > 0:
        return 0.0, error
    weights = 1 / np.square([error, np.hypot(np.hypot(spread_a, spread_b), OBJECTS)])
    return float((weights * both).sum() / weights.sum()), float(weights.sum() ** -0.5)


def cost_of(part: str) -> str:
    """Return what such a change takes on the simulated twins, as a sentence; "" if not measured."""
    if part not in COSTS:
        return ""
    kept, filled = COSTS[part]
    return (
        f"Between simulated sensors that differ in this alone, touch loses {kept:.2g} points of"
        f" accuracy, and {filled:.2g} with the dots filled."
    )
