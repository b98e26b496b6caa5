"""Twins: 300 presses, each imaged by eight sensors, and photographed in eight scenes, as
embeddings.

Any method can be tested on "only the sensor changed" (`docs/twins.md`). A shipped value is one byte
of a unit row, and rows of ReLU features are mostly zeros, so 7,800 rows take 4 MB; they turn by
less than a degree.
"""

import json
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np
from numpy.typing import NDArray

from omnivat.data.embeddings import Array, Embeddings, Header
from omnivat.head.heads import EXAMPLES
from omnivat.kit.errors import DataError
from omnivat.kit.files import replacing

FORMAT = "omnivat-twins-1"
LEVELS = 512  # bytes for one unit
KINDS = ("vis", "tac", "filled", "printed")
TEXTS = ("objects", "looks_like", "feels_like")


@dataclass(frozen=True, slots=True, kw_only=True)
class Twins:
    """Embeddings of N presses by S sensors and in S scenes, paired: row n is one press of one
    object.

    tac      (N, S, W) touches by sensor s, dots as printed on the gel
    filled   (N, S, W) the same touches, printed dots filled
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
    label: NDArray[np.int64]
    objects: tuple[str, ...]
    looks_like: tuple[str, ...]  # the class that the object imitates by sight, or ""
    feels_like: tuple[str, ...]  # the class that it imitates by touch, or ""
    header: Header
    as_filled: str
    printed: Array
    rows: NDArray[np.int64]

    def pairs(self, sensor: str, scene: str = "", *, filled: bool = False) -> Embeddings:
        """Return the M photographed presses by one sensor, in one scene, as pairs for any head or
        command.

        scene   a domain; "": the sensor's own
        filled  with the printed dots filled

        Raises DataError for a domain that the twins lack.
        """
        of_touch, of_photo = self.place(sensor), self.place(scene or sensor)
        count = len(self.vis)
        return Embeddings(
            header=replace(self.header, preprocessing=self.as_filled) if filled else self.header,
            vis=self.vis[:, of_photo],
            tac=(self.filled if filled else self.tac)[:count, of_touch],
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
    for name, values in zip(KINDS, (made.vis, made.tac, some, made.printed), strict=True):
        length = np.linalg.norm(values, axis=-1)
        level = np.round(LEVELS * values / length[..., None])
        if not ((level >= 0) & (level <= 255)).all():
            raise DataError(
                f"{name} has values outside of 0 to {255 / LEVELS:.3f}; twins are of ReLU features."
            )
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
    file = Path(path) if path else EXAMPLES / "twins.npz"
    try:
        with np.load(file) as arrays:
            text: dict[str, Any] = json.loads(arrays["text"].tobytes())
            if text.pop("format") != FORMAT:
                raise ValueError("another format")
            vis, tac, some, printed = (
                arrays[name] * (arrays[f"{name}_length"] / LEVELS)[..., None] for name in KINDS
            )
            label, changed, rows = arrays["label"], arrays["changed"], arrays["rows"]
    except (OSError, ValueError, LookupError, TypeError, BadZipFile) as error:
        raise DataError(
            f"'{file}' cannot be read as twins ({error}); `python -m benchmarks.twins` writes them."
        ) from error
    filled = tac.copy()
    filled.reshape(-1, filled.shape[-1])[changed] = some
    header = text["header"] | {name: tuple(text["header"][name]) for name in ("domains", "classes")}
    texts: dict[str, Any] = {name: tuple(text[name]) for name in TEXTS}
    return Twins(
        vis=vis,
        tac=tac,
        filled=filled,
        label=label,
        header=Header(**header),
        as_filled=text["as_filled"],
        printed=printed,
        rows=rows,
        **texts,
    )
