"""Touches turned, mirrored or with swapped channels: one sensor's pictures as another shows them.

An arrangement is a text of words from WAYS, in their order, such as "left-right bgr"; "" is none.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from PIL import Image

from omnivat.data.pairs import PairSet
from omnivat.kit.errors import DataError, SettingsError
from omnivat.kit.schema import object_in, texts
from omnivat.kit.tables import suggestion

Array = np.ndarray[Any, np.dtype[Any]]
FLIPS: Mapping[str, Callable[[Array], Array]] = {
    "left-right": np.fliplr,
    "top-bottom": np.flipud,
    "half-turn": lambda a: np.rot90(a, 2),
    "clockwise": lambda a: np.rot90(a, 3),
    "anticlockwise": lambda a: np.rot90(a, 1),
}
WAYS: Mapping[str, Callable[[Array], Array]] = {**FLIPS, "bgr": lambda a: a[..., ::-1]}


def arranged(picture: Image.Image, way: str) -> Image.Image:
    """Return an RGB picture in an arrangement; the same object for "".

    >>> picture = Image.fromarray(np.uint8([[[1, 2, 3], [4, 5, 6]]]))
    >>> np.asarray(arranged(picture, "left-right bgr")).tolist()
    [[[6, 5, 4], [3, 2, 1]]]
    """
    if not way:
        return picture
    pixels = np.asarray(picture)
    for word in way.split():
        pixels = WAYS[word](pixels)
    return Image.fromarray(np.ascontiguousarray(pixels))


def ways_from(text: str) -> dict[str, str]:
    """Return domain -> arrangement of a header's JSON; raises DataError for another text."""
    ways = texts(object_in(text.encode(), "tac_way"), "tac_way")
    return {name: known_way(way) for name, way in ways.items()}


def known_way(way: str) -> str:
    """Return an arrangement; raises DataError for another text."""
    if any(word not in WAYS for word in way.split()):
        raise DataError(f"'{way:.60}' is no arrangement; it has words of {', '.join(WAYS)}.")
    return way


def ways_in(
    flips: Iterable[str], channels: Iterable[str], domains: Sequence[str]
) -> dict[str, str]:
    """Return domain -> its arrangement, from the values of --flip and --channels.

    flips, channels  "WAY" for every domain, or "DOMAIN=WAY"
    Raises SettingsError for an unknown way or domain, and for two ways of one domain.

    >>> ways_in(["DIGIT-b=left-right"], ["bgr"], ["DIGIT-a", "DIGIT-b"])
    {'DIGIT-a': 'bgr', 'DIGIT-b': 'left-right bgr'}
    """
    found: dict[str, dict[str, str]] = {name: {} for name in domains}
    for option, known, values in (
        ("flip", tuple(FLIPS), flips),
        ("channels", ("bgr", "rgb"), channels),
    ):
        for value in values:
            name, _, way = value.rpartition("=")
            if way not in known or (name and name not in found):
                wrong, names = (way, known) if way not in known else (name, domains)
                raise SettingsError(
                    f"--{option} names '{wrong:.60}'; give WAY or DOMAIN=WAY, here one of"
                    f" {', '.join(names)}.{suggestion(wrong, names)}"
                )
            for domain in [name] if name else found:
                if found[domain].setdefault(option, way) != way:
                    raise SettingsError(f"--{option} gives '{domain}' two ways; keep one.")
    ways = {name: " ".join(w for w in some.values() if w != "rgb") for name, some in found.items()}
    return {name: way for name, way in ways.items() if way}


def with_ways(loaded: PairSet, ways: Mapping[str, str]) -> PairSet:
    """Return the pairs with the arrangement of each domain's touches."""
    pairs = tuple(replace(pair, tac_way=ways.get(pair.domain, "")) for pair in loaded.pairs)
    return replace(loaded, pairs=pairs) if ways else loaded


def ways_of(pairs: Iterable[Any]) -> dict[str, str]:
    """Return domain -> the arrangement of its touches, without those that stay as they are."""
    return {pair.domain: pair.tac_way for pair in pairs if pair.tac_way}


def require_ways(learned: Mapping[str, str], here: Mapping[str, str]) -> None:
    """Raise DataError if a domain that a head learned in an arrangement comes in another one.

    learned, here  domain -> arrangement, of a head and of a set; a domain without one is left out

    A set may be arranged where the head's pictures were not: that is how the pictures of another
    sensor are made to fit.
    """
    for name, way in learned.items():
        if here.get(name, "") != way:
            raise DataError(
                f"This head learned the touches of '{name}' with {options_of(way)}, and these are"
                f" {f'made with {options_of(here[name])}' if name in here else 'as they come'}."
                " Embed the pairs as the head's, or choose a head that fits."
            )


def options_of(way: str) -> str:
    """Return the options of `embed` that arrange touches so.

    >>> options_of("left-right bgr")
    '--flip left-right --channels bgr'
    """
    return " ".join(f"--{'flip' if w in FLIPS else 'channels'} {w}" for w in way.split())
