"""The lamps of each domain of a set, found in its own touches."""

from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from omnivat.data.dots import fill_dots
from omnivat.data.images import read_bytes
from omnivat.data.pairs import Pair
from omnivat.data.relief import Lamps, lamps
from omnivat.data.relief.files import spread
from omnivat.data.rest import seen
from omnivat.encoders.cache import Source
from omnivat.kit.errors import DataError

Touch = tuple[Source, int, Path | None, str]  # a picture, its crop, no-contact picture, arrangement


def lamps_of_domains(pairs: Iterable[Pair], known: Mapping[str, Lamps]) -> dict[str, Lamps | str]:
    """Return domain -> its lamps, `known` ones or from its own touches, or why it has none."""
    touches: dict[str, dict[Touch, None]] = defaultdict(dict)
    for pair in pairs:
        touches[pair.domain][pair.tac, pair.tac_crop, pair.tac_rest, pair.tac_way] = None
    return {
        name: known[name] if name in known else lamps_or_reason(list(some))
        for name, some in touches.items()
    }


def lamps_or_reason(touches: Sequence[Touch]) -> Lamps | str:
    """Return the lamps of one sensor from at most 50 of its touches, evenly spread, or the reason
    why it has none. A touch that cannot be read is left out.
    """
    try:
        return lamps(_readable(spread(touches)), dots="keep")
    except DataError as error:
        return str(error)


def _readable(touches: Iterable[Touch]) -> Iterator[np.ndarray[Any, Any]]:
    for source, crop, rest, way in touches:
        try:
            content = source if isinstance(source, Image.Image) else read_bytes(source, "a touch")
            calm = read_bytes(rest) if rest else b""
            image = seen(content, "a touch", crop=crop, rest=calm, way=way, clean=_clean)
        except DataError:
            continue
        yield fill_dots(np.asarray(image))[0]


def _clean(image: Image.Image) -> Image.Image:
    return Image.fromarray(fill_dots(np.asarray(image))[0])
