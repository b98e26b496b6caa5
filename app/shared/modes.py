"""Modes of p for a head and a set: the rows of `app/shared/tables.py` whose frames stand next to
the set.

A mode without a file of its own is the loaded head's; its frames are computed if there are none.
"""

import logging
from collections.abc import Container
from contextlib import suppress
from pathlib import Path

from app.shared.places import Places
from app.shared.resources import Resources
from app.shared.state import Reply
from app.shared.tables import tables
from omnivat.head.heads import EXAMPLES, shipped_sets
from omnivat.kit.errors import DataError

log = logging.getLogger(__name__)
SETS = {"sensors": "Touch sensors", "chirps": "Chirps"}


def mode_files(where: Places) -> dict[str, Path]:
    """Return the frames files next to a set of embeddings, by mode."""
    folder = where.embeddings.parent
    files = {row["id"]: folder / row["file"] for row in tables()["modes"] if "file" in row}
    return {mode: file for mode, file in files.items() if file.is_file()}


def fitting_files(resources: Resources) -> dict[str, Path]:
    """Return the frames files that match the pairs and encoder of the set; log the others."""
    from omnivat.maps.frames.file import frames_header

    fitting = {}
    for mode, file in mode_files(resources.where).items():
        try:
            embeddings = resources.embeddings()
            header = embeddings.header
            wanted = (len(embeddings), header.domains, header.weights_hash, header.origin)
            record = frames_header(file)
            made = record["embeddings"]
            if (
                record["pairs"],
                tuple(record["domains"]),
                made["weights_hash"],
                made.get("origin", ""),
            ) == wanted:
                fitting[mode] = file
            else:
                log.warning("'%s' is of another set and is left out.", file.name)
        except (DataError, KeyError, TypeError) as error:
            log.warning("frames left out: %s", error)
    return fitting


def modes(resources: Resources, among: Container[str] | None = None) -> Reply:
    """Return the choices of a visitor: the modes of p and the sets of the project.

    among   names of the sets to list; None: all
    return  {"modes": names in the page's order, "sets": [{"name", "title", "shown", "curve"}, …],
            "twins": whether the project's twins are there}; `curve` is the accuracy of heads
            trained at each p, {"title", "orders", "share"} or None
    """
    fitting = fitting_files(resources)
    shown = resources.where.embeddings.resolve()
    sets = []
    listed = shipped_sets()
    for name in listed if among is None else [mode for mode in listed if mode in among]:
        (folder, embeddings), title = listed[name], SETS.get(name, name)
        curve = _curve(folder, title)
        sets.append(
            {"name": name, "title": title, "shown": embeddings.resolve() == shown, "curve": curve}
        )
    return {
        "modes": [
            row["id"] for row in tables()["modes"] if "file" not in row or row["id"] in fitting
        ],
        "sets": sets,
        "twins": bool(sets) and (EXAMPLES / "twins.json").is_file(),
    }


def _curve(folder: Path, title: str) -> Reply | None:
    """Return the accuracy in unseen domains of the first mode of a head for each stop, if there
    is one over several trainings.
    """
    from omnivat.maps.frames.file import frames_header

    for row in tables()["modes"]:
        if "heads" in row["can"]:
            with suppress(DataError, KeyError):
                record = frames_header(folder / row["file"])
                share = record["curves"]["seeds:accuracy/unseen/mean"]
                return {"title": title, "orders": record["orders"], "share": share}
    return None
