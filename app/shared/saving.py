"""What the page saves: heads and sets as zip files, the open view as an interactive figure."""

from collections.abc import Callable, Sequence
from pathlib import Path
from shutil import make_archive
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

from app.shared.modes import mode_files
from app.shared.resources import Resources
from app.shared.state import Question, one_of, order_from
from app.shared.tables import row_of, tables
from omnivat.kit.errors import DataError

if TYPE_CHECKING:
    from omnivat.data.store import Embeddings
    from omnivat.head.checkpoint import Head

HEAD_NOTE = """A head made in the OmniVaT page.

python app.py --head {name}
python -m omnivat evaluate --head {name} --embeddings FILE
"""
SET_NOTE = """A set of embeddings made in the OmniVaT page. It holds no images.

python app.py --embeddings {name}/embeddings.safetensors
python -m omnivat train --embeddings {name}/embeddings.safetensors --source DOMAIN --out my-head
"""


def head_zip(head: "Head", name: str) -> bytes:
    """Return a zip of the head's folder, called `name`."""
    from omnivat.head.checkpoint import save_head

    return _zipped(lambda folder: save_head(folder, head), name, HEAD_NOTE)


def set_zip(embeddings: "Embeddings", name: str) -> bytes:
    """Return a zip of an embeddings file and its manifest, in a folder called `name`."""
    from omnivat.data.store import save_embeddings

    return _zipped(
        lambda folder: save_embeddings(folder / "embeddings.safetensors", embeddings),
        name,
        SET_NOTE,
    )


def save_figure(resources: Resources, question: Question) -> bytes:
    """Return the open map, the curves against p and the staircase as one HTML page without a
    server.

    question  {"order": p or None, "stage", "map", "colour", "mode": as in the page's address}

    Raises DataError while there are no frames, SettingsError for an unknown map or colouring.
    """
    from omnivat.figures import frames_map, gap_curves, html_page, pictures, staircase
    from omnivat.maps.frames import read_frames
    from omnivat.maps.frames.records import FEATURES

    kind, colour = (str(question.get(k, v))[:20] for k, v in (("map", "pca"), ("colour", "domain")))
    named = str(question.get("mode"))
    file = mode_files(resources.where).get(named) or resources.frames.state().file
    if file is None:
        raise DataError("The map is not ready yet; save it when it is shown.")
    frames = read_frames(file)
    mode = row_of("modes", frames.head.get("kind"))
    column = column_of(resources, colour)
    steps = {row["id"]: row for row in tables()["stages"]}
    step = steps[one_of("stage", question.get("stage", [*steps][-1]), steps)]
    stage = {"stage": step.get("as", step["id"]), "name": step["title"]}
    order = order_from(question.get("order"))
    at = float(frames.head.get("learned_order") or 0.5) if order is None else order
    tiles = pictures(resources.sheet) if resources.sheet else None
    shown = {"kind": kind, "colour": colour, "column": column, "pictures": tiles}
    parts = [frames_map(frames, order=at, **stage, **shown)]
    if frames.head.get("kind") != FEATURES:
        parts.append(gap_curves(frames, order=at, mode=mode, **stage))
        parts.append(staircase(frames, order=at, mode=mode))
    return str(html_page(f"OmniVaT: {frames.pairs} VIS-TAC pairs", parts)).encode()


def column_of(resources: Resources, colour: str) -> Sequence[str]:
    """Return the texts (N,) of the column that a colour paints; none for other colours."""
    column = row_of("colours", colour).get("column")
    return resources.embeddings().rows.get(column, ()) if column else ()


def _zipped(save: Callable[[Path], Any], name: str, note: str) -> bytes:
    """Return a zip of the folder `name` that `save` writes, with a note."""
    with TemporaryDirectory(prefix="omnivat-save-") as home:
        folder = Path(home) / name
        save(folder)
        (folder / "README.txt").write_text(note.format(name=name), encoding="utf-8")
        return Path(make_archive(str(folder), "zip", home, name)).read_bytes()
