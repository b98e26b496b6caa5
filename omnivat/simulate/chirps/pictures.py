"""A set of chirps on disk: two pictures of stripes for each pair, and pairs.csv."""

import csv
import io
from pathlib import Path

import numpy as np

from omnivat.data.embeddings import Embeddings
from omnivat.data.manifest import COLUMNS
from omnivat.data.pairs import Pair, PairSet
from omnivat.data.strips import STRIPES, strip_picture
from omnivat.errors import SettingsError
from omnivat.files import replacing, require_writable, write_text
from omnivat.modalities import IMAGES
from omnivat.progress import OnStep, Step, ignore
from omnivat.simulate.chirps.settings import ChirpSettings
from omnivat.simulate.chirps.signals import chirp_embeddings, origin


def write_chirps(
    out: Path, settings: ChirpSettings, *, pictures: bool = True, on_step: OnStep = ignore
) -> PairSet:
    """Write `<out>/<domain>/<class>/<name>_{vis,tac}.png` and `<out>/pairs.csv`; return the pairs.

    The same settings give the same bytes. `omnivat embed OUT --encoder strip --no-flips` reads
    the signals back.

    Raises SettingsError for a width that does not fit a picture, WriteError if the folder is not
    writable.
    """
    if settings.width != STRIPES:
        raise SettingsError(
            f"width is {settings.width}; a picture shows {STRIPES} stripes. Use width={STRIPES}, "
            "or chirp_embeddings(settings) for signals without pictures."
        )
    require_writable(out / "pairs.csv")
    made = chirp_embeddings(settings)
    for row in range(len(made)):
        for name in IMAGES:
            _write(out / made.rows[name][row], getattr(made, name)[row])
        on_step(Step(done=row + 1, total=len(made), text=made.rows["object"][row]))
    write_text(out / "pairs.csv", pairs_table(made))
    return PairSet(
        pairs=tuple(_pair(out, made, row) for row in range(len(made))),
        origin=origin(settings),
        simulated=True,
    )


def pairs_table(made: Embeddings) -> str:
    """Return pairs.csv of a set: paths relative to its folder."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(COLUMNS)
    for row in range(len(made)):
        names = {name: column[row] for name, column in made.rows.items()}
        names["domain"] = made.header.domains[made.domain[row]]
        names["material"] = made.header.classes[made.label[row]]
        writer.writerow([names[column] for column in COLUMNS])
    return text.getvalue()


def _write(path: Path, signal: "np.ndarray[tuple[int], np.dtype[np.float32]]") -> None:
    with replacing(path) as temporary:
        strip_picture(signal).save(temporary, format="PNG")


def _pair(out: Path, made: Embeddings, row: int) -> Pair:
    return Pair(
        vis=out / made.rows["vis"][row],
        tac=out / made.rows["tac"][row],
        domain=made.header.domains[made.domain[row]],
        material=made.header.classes[made.label[row]],
        object=made.rows["object"][row],
        split=made.rows["split"][row],
    )
