"""Maps: every photo and touch as a point, in two or three dimensions, with hover pictures."""

import base64
import json
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from omnivat.figures.page import Figure, made
from omnivat.figures.specs import map_spec
from omnivat.figures.theme import CLASSES, DOMAINS, MODALITIES, RIGHT_WRONG
from omnivat.kit.errors import SettingsError
from omnivat.kit.stages import STAGE_TITLES
from omnivat.maps.frames.records import FEATURES, FrameSet

CIVIDIS = ["#00224e", "#27406f", "#575d6d", "#7d7c78", "#a59c74", "#d2c060", "#fee838"]
COLOURS = ("domain", "class", "modality", "correctness", "confidence")
LIMIT = 16_000_000  # bytes of a sheet of pictures


def map_figure(
    places: NDArray[Any],
    group: Sequence[int] | NDArray[Any],
    names: Sequence[str],
    *,
    title: str,
    caption: str = "",
    colours: Sequence[str] = CLASSES,
    hover: Sequence[str] | None = None,
    pictures: dict[str, Any] | None = None,
    modalities: Sequence[str] = ("VIS", "TAC"),
) -> Figure:
    """Return a map of N pairs: circles for photos, triangles for touches, one colour a group.

    places      (M N, 2) or (M N, 3): the rows of the first of M modalities, then of the second
    group       (N,) or (M N,) index into `names`; a click on a name hides its points
    hover       N texts, shown at the pointer
    pictures    from `pictures`: tile i is pair i's photo, tile N + i its touch

    Raises ShapeError if the lengths do not fit.

    >>> random = np.random.default_rng(0)
    >>> places, materials = random.normal(size=(8, 2)), ["wood", "steel"]
    >>> figure = map_figure(places, [0, 1, 0, 1], materials, title="Four pairs")
    >>> [trace.name for trace in figure.data][:2]
    ['wood', 'steel']
    """
    look: dict[str, Any] = {"title": title, "caption": caption, "colours": colours, "hover": hover}
    return made(map_spec(places, group, names, pictures=pictures, modalities=modalities, **look))


def frames_map(
    frames: FrameSet,
    *,
    order: float,
    stage: str = "f_hat",
    name: str | None = None,
    kind: str = "pca",
    colour: str = "domain",
    column: Sequence[str] = (),
    pictures: dict[str, Any] | None = None,
) -> Figure:
    """Return the map of a stage at the stop nearest to `order` (quarter turns).

    name    of the stage in the title; None: as in STAGE_TITLES
    kind    "pca" or "umap"
    colour  of COLOURS
    column  (N,) texts that colour the pairs in place of `colour`

    Raises SettingsError for an unknown map or colouring.

    >>> from omnivat import EXAMPLES, read_frames
    >>> frames = read_frames(EXAMPLES / "chirps" / "frames.bin")
    >>> figure = frames_map(frames, order=0.35, colour="class")
    >>> figure.layout.title.text, figure.data[0].name
    ('OmniVaT, F after DTG, p = 0.35', 'chirp 1')
    """
    drawn = frames.maps.get(f"{kind}/{stage}")
    if drawn is None:
        there = ", ".join(frames.maps)
        raise SettingsError(f"There is no map '{kind}/{stage}' in these frames; there are {there}.")
    frame = min(range(len(drawn.orders)), key=lambda i: abs(frames.orders[drawn.orders[i]] - order))
    stop = min(range(len(frames.orders)), key=lambda i: abs(frames.orders[i] - order))
    names, colours, group = grouped(column) if column else _grouped(frames, colour, stop)
    at = frames.orders[stop] if len(drawn.orders) == 1 else frames.orders[drawn.orders[frame]]
    what = "simulated data" if frames.embeddings.get("simulated") else "real data"
    headless = frames.head.get("kind") == FEATURES
    predicted = [f" · predicted {frames.classes[k]}" for k in frames.prediction[stop]]
    pairs = zip(frames.domain, frames.label, predicted, strict=True)
    hover = [
        f"{frames.domains[d]} · {frames.classes[c]}{'' if headless else p}" for d, c, p in pairs
    ]
    title = f"OmniVaT, {name or STAGE_TITLES[stage]}{'' if headless else f', p = {at:.2f}'}"
    caption = f"{kind.upper()} of {frames.pairs} pairs, {what}; the axes have no unit"
    look: dict[str, Any] = {"colours": colours, "hover": hover, "pictures": pictures}
    return map_figure(drawn.places(frame), group, names, title=title, caption=caption, **look)


def _grouped(
    frames: FrameSet, colour: str, stop: int
) -> tuple[Sequence[str], Sequence[str], NDArray[Any]]:
    """Return the groups' names and colours, and the group of each pair or each of the 2N points."""
    if colour == "domain":
        return frames.domains, DOMAINS, frames.domain
    if colour == "class":
        return frames.classes, CLASSES, frames.label
    if colour == "correctness":
        wrong = (frames.prediction[stop] != frames.label).astype(np.int64)
        return ("right", "wrong"), RIGHT_WRONG, wrong
    if colour == "confidence":
        least = 1 / len(frames.classes)
        step = (1 - least) / len(CIVIDIS)
        bins = (frames.confidence[stop] / 255 - least) // step
        names = [f"≥ {100 * (least + k * step):.0f} %" for k in range(len(CIVIDIS))]
        return names, CIVIDIS, np.clip(bins, 0, len(CIVIDIS) - 1).astype(np.int64)
    if colour == "modality":
        return ("VIS", "TAC"), MODALITIES, np.repeat(np.arange(2), frames.pairs)
    raise SettingsError(f"The colour is '{colour}'; choose one of {', '.join(COLOURS)}.")


def grouped(column: Sequence[str]) -> tuple[Sequence[str], Sequence[str], NDArray[Any]]:
    """Return names and colours of the values of a column (N,), and the value of each pair. Of more
    values than colours, the most frequent have one each and the others share one.

    >>> names, _, group = grouped(["worn", "", "worn"])
    >>> names, group.tolist()
    (['none', 'worn'], [1, 0, 1])
    """
    counts = Counter(column)
    most = len(CLASSES) if len(counts) <= len(CLASSES) else len(CLASSES) - 1
    values = sorted(value for value, _ in counts.most_common(most))
    names = [value or "none" for value in values]
    if others := len(counts) - len(values):
        names.append(f"{others:,} other values")
    place = {value: index for index, value in enumerate(values)}
    return names, CLASSES, np.array([place.get(value, len(values)) for value in column])


def pictures(sheet: str | Path) -> dict[str, Any] | None:
    """Return a sheet from `omnivat thumbnails` for `pictures=`; None without one, or above 16
    MB.

    >>> from omnivat import EXAMPLES, read_frames
    >>> sheet = pictures(EXAMPLES / "chirps" / "chirps.thumbnails.webp")
    >>> frames = read_frames(EXAMPLES / "chirps" / "frames.bin")
    >>> figure = frames_map(frames, order=0.35, pictures=sheet)  # a pair's picture at the pointer
    >>> figure.layout.meta["pictures"]["columns"]
    40
    """
    file = Path(sheet)
    if not file.is_file() or not file.with_suffix(".json").is_file() or file.stat().st_size > LIMIT:
        return None
    known = json.loads(file.with_suffix(".json").read_text(encoding="utf-8"))
    data = base64.b64encode(file.read_bytes()).decode()
    return {"sheet": f"data:image/webp;base64,{data}", "columns": int(known["columns"])}
