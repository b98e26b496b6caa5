"""Twins: 300 presses, each imaged by eight sensors, and photographed in eight scenes, as
embeddings.

Any method can be tested on "only the sensor changed" (`docs/twins.md`). A shipped value is one byte
of a unit row, and rows of ReLU features are mostly zeros, so 6,500 rows take 3.5 MB; they turn by
less than a degree.
"""

import json
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from omnivat.data.arrays import require_range
from omnivat.data.domains import require_domain_names
from omnivat.data.embeddings import Array, Embeddings, Header
from omnivat.data.npz import read_npz
from omnivat.data.relief.files import RELIEF
from omnivat.data.store import header_of
from omnivat.head.heads import EXAMPLES
from omnivat.kit.errors import DataError, first_line
from omnivat.kit.files import path_of, replacing
from omnivat.kit.schema import object_in

FORMAT = "omnivat-twins-2"
LEVELS = 512  # bytes for one unit
MOST_BYTES = 500_000_000  # of all arrays of a file
KINDS = ("vis", "tac", "filled", "relief", "printed")
TEXTS = ("objects", "looks_like", "feels_like")


@dataclass(frozen=True, slots=True, kw_only=True)
class Twins:
    """Embeddings of N presses by S sensors and in S scenes, paired: row n is one press of one
    object.

    tac      (N, S, W) touches by sensor s, dots as printed on the gel
    filled   (N, S, W) the same touches, printed dots filled
    relief   (N, S, W) the same touches, each drawn as its relief by the lamps that it gives alone
    vis      (M, S, W) photographs of the first M objects in scene s
    label    (N,) indices into `header.classes`
    objects  N names; no head has met these objects
    header   of `vis` and `tac`; `header.domains` names the S sensors and scenes
    as_filled  the header's preprocessing of `filled`
    printed    (R, W) touches of the set that heads learn from, dots as printed; `rows` (R,) are
               their rows there

    Two touches of a row differ in the sensor only, and two photographs in the scene only:

    >>> shipped = twins()
    >>> shipped.tac.shape
    (300, 8, 1280)
    >>> touch = shipped.tac / np.linalg.norm(shipped.tac, axis=-1, keepdims=True)
    >>> sensors = map(shipped.place, ("TAG-sim", "TQ-DIGIT-sim"))
    >>> gelsight, digit = (touch[:, sensor] for sensor in sensors)
    >>> nearest = (gelsight @ digit.T).argmax(1)  # a press finds its own twin among 300
    >>> bool((nearest == np.arange(300)).mean() < 0.2)
    True
    """

    vis: Array
    tac: Array
    filled: Array
    relief: Array
    label: NDArray[np.int64]
    objects: tuple[str, ...]
    looks_like: tuple[str, ...]  # the class that the object imitates by sight, or ""
    feels_like: tuple[str, ...]  # the class that it imitates by touch, or ""
    header: Header
    as_filled: str
    printed: Array
    rows: NDArray[np.int64]

    def pairs(
        self, sensor: str, scene: str = "", *, filled: bool = False, relief: bool = False
    ) -> Embeddings:
        """Return the M photographed presses by one sensor, in one scene, as pairs for any head or
        command.

        scene   a domain; "": the sensor's own
        filled  with the printed dots filled
        relief  drawn as their relief

        Raises DataError for a domain that the twins lack.
        """
        of_touch, of_photo = self.place(sensor), self.place(scene or sensor)
        count, preprocessing = len(self.vis), self.header.preprocessing
        if filled or relief:
            preprocessing = self.as_filled + RELIEF * relief
        touches = self.relief if relief else self.filled if filled else self.tac
        return Embeddings(
            header=replace(self.header, preprocessing=preprocessing),
            vis=self.vis[:, of_photo],
            tac=touches[:count, of_touch],
            domain=np.full(count, of_touch),
            label=self.label[:count],
            rows={
                "object": list(self.objects[:count]),
                "split": ["test"] * count,
                "looks_like": list(self.looks_like[:count]),
                "feels_like": list(self.feels_like[:count]),
                **{name: [""] * count for name in ("vis", "tac", "part")},
            },
        )

    def place(self, domain: str) -> int:
        """Return the index of a sensor and scene. Raises DataError for a domain that the twins
        lack.
        """
        if domain not in self.header.domains:
            raise DataError(
                f"The twins have no domain '{domain}'; choose one of"
                f" {', '.join(self.header.domains)}."
            )
        return self.header.domains.index(domain)


def write_twins(path: Path, made: Twins) -> None:
    """Write twins as NPZ, completely or not at all. Raises DataError if a byte cannot hold their
    values.
    """
    changed = np.flatnonzero((made.filled != made.tac).any(-1).ravel())
    some = made.filled.reshape(-1, made.filled.shape[-1])[changed]
    arrays: dict[str, Any] = {"label": made.label, "changed": changed, "rows": made.rows}
    kinds = (made.vis, made.tac, some, made.relief, made.printed)
    for name, values in zip(KINDS, kinds, strict=True):
        length = np.linalg.norm(values, axis=-1)
        level = np.round(LEVELS * values / length[..., None])
        if not ((level >= 0) & (level <= 255)).all():
            raise DataError(
                f"{name} has values outside of 0 to {255 / LEVELS:.3f}; twins are of ReLU features."
            )
        length *= LEVELS / np.linalg.norm(level, axis=-1)  # what is read is written the same again
        arrays |= {name: level.astype(np.uint8), f"{name}_length": length.astype(np.float32)}
    text = {name: getattr(made, name) for name in TEXTS}
    text |= {"format": FORMAT, "header": asdict(made.header), "as_filled": made.as_filled}
    with replacing(path) as temporary, temporary.open("wb") as file:
        np.savez_compressed(file, text=np.frombuffer(json.dumps(text).encode(), np.uint8), **arrays)


def twins(path: str | Path | None = None) -> Twins:
    """Load twins (None: the shipped ones). Raises DataError if the file is missing or of another
    kind.

    >>> presses = twins()
    >>> presses.header.domains[:2], len(presses.objects)
    (('TAG-sim', 'OF Real-sim'), 300)
    """
    file = EXAMPLES / "twins.npz" if path is None else path_of(path)
    try:
        return _checked(read_npz(file, MOST_BYTES))
    except (DataError, ValueError, LookupError, TypeError, AttributeError) as error:
        raise DataError(
            f"'{file}' cannot be read as twins ({first_line(error, 300)}); `python -m"
            " benchmarks.twins` writes them."
        ) from error


def _checked(arrays: dict[str, NDArray[Any]]) -> Twins:
    """Return the twins in a file's arrays. Raises an error for arrays that do not belong
    together.
    """
    text = object_in(arrays["text"].tobytes(), "text")
    if text["format"] != FORMAT:
        raise ValueError("another format")
    head = {k: v if isinstance(v, str) else json.dumps(v) for k, v in text["header"].items()}
    header = header_of(head | {"modalities": "vis+tac"})
    require_domain_names(header.domains)
    (count, sensors, width), shown = arrays["tac"].shape, len(arrays["vis"])
    changed, rows, label = (arrays[name] for name in ("changed", "rows", "label"))
    shapes = {
        "tac": (count, len(header.domains), width),
        "vis": (min(shown, count), sensors, width),
        "filled": (len(changed), width),
        "relief": (count, sensors, width),
        "printed": (len(rows), width),
    }
    vectors: dict[str, Any] = {}
    for name, shape in shapes.items():
        levels, length = arrays[name], arrays[f"{name}_length"]
        if levels.shape != shape or levels.dtype != np.uint8 or length.shape != shape[:-1]:
            raise ValueError(f"{name} is {levels.dtype} of shape {levels.shape}, expected {shape}")
        if length.dtype != np.float32 or not ((length >= 0) & np.isfinite(length)).all():
            raise ValueError(f"{name}_length should be finite float32 from 0")
        vectors[name] = levels * (length / LEVELS)[..., None]
        for _ in require_range([vectors[name].reshape(-1, width)], name):
            pass
    most = {"label": len(header.classes), "changed": count * sensors, "rows": MOST_BYTES}
    for name, end in most.items():
        own = arrays[name]
        if own.ndim != 1 or own.dtype.kind not in "iu" or not ((own >= 0) & (own < end)).all():
            raise ValueError(f"{name} should be indices below {end}")
    if len(np.unique(changed)) < len(changed):
        raise ValueError("changed names a touch twice")
    texts: dict[str, Any] = {name: tuple(text[name]) for name in TEXTS}
    for name, own in {**texts, "label": label}.items():
        if len(own) != count or (name in TEXTS and not all(isinstance(text, str) for text in own)):
            raise ValueError(f"{name} should have {count} entries")
    filled = vectors["tac"].copy()
    filled.reshape(-1, width)[changed] = vectors["filled"]
    return Twins(
        **vectors | {"filled": filled},
        label=label.astype(np.int64),
        header=header,
        as_filled=str(text["as_filled"]),
        rows=rows,
        **texts,
    )
