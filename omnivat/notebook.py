"""Show Explore in a notebook cell: the exported page in a frame, without a server."""

from dataclasses import dataclass
from html import escape
from importlib import import_module
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

from omnivat.kit.errors import SettingsError
from omnivat.kit.progress import OnStep, ignore

if TYPE_CHECKING:
    from omnivat.data.embeddings import Embeddings
    from omnivat.head.checkpoint import Head

HEIGHTS = (300, 4000)


@dataclass(frozen=True, slots=True)
class Cell:
    """A page that a notebook shows as the value of a cell."""

    page: str  # a whole HTML document
    height: int  # CSS pixels

    def _repr_html_(self) -> str:
        """Return the page in a sandboxed frame, which cannot reach the notebook."""
        return (
            f'<iframe srcdoc="{escape(self.page)}"'
            f' style="width:100%;height:{self.height}px;border:0" sandbox="allow-scripts'
            ' allow-downloads" title="OmniVaT: Explore"></iframe>'
        )

    def save(self, path: str | Path) -> Path:
        """Write the page as one HTML file; return its path."""
        from omnivat.kit.files import path_of, write_text

        target = path_of(path)
        write_text(target, self.page)
        return target


def explore(
    head: "str | Path | Head | None" = None,
    embeddings: "str | Path | Embeddings | None" = None,
    *,
    height: int = 900,
    on_step: OnStep = ignore,
) -> Cell:
    """Return Explore for a head and a set, to show as the value of a notebook cell.

    head        a head folder, or a loaded head; None: the project's own
    embeddings  an embeddings file, or loaded embeddings; None: the project's own
    height      of the frame, 300 to 4000 CSS pixels
    on_step     called with progress while maps are computed, which takes seconds to minutes

    The page is complete: it needs no server, and a saved notebook keeps it.
    Raises SettingsError for another height, DataError if head and set do not fit.

    >>> cell = explore()  # as the value of a notebook cell it shows itself; `save` writes a file
    >>> cell.page[:15], cell.height
    ('<!doctype html>', 900)
    """
    if not HEIGHTS[0] <= height <= HEIGHTS[1]:
        raise SettingsError(f"height is {height}; choose {HEIGHTS[0]} to {HEIGHTS[1]} pixels.")
    from app.shared.places import places
    from app.site.export import export_page, frames_file

    with TemporaryDirectory(prefix="omnivat-notebook-") as temporary:
        place = Path(temporary)
        folder = _place(head, place / "head", "omnivat.head.checkpoint", "save_head")
        where = places(
            folder,
            _place(embeddings, place / "set.safetensors", "omnivat.data.store", "save_embeddings"),
        )
        frames = frames_file(where, on_step)
        export_page(where, frames, place / "page.html")
        page = (place / "page.html").read_text(encoding="utf-8")
    return Cell(page, height)


def _place(place: Any, target: Path, module: str, save: str) -> Path | None:
    """Return the path of a head or a set; one in memory is first written to `target`."""
    if place is None or isinstance(place, str | Path):
        return None if place is None else Path(place)
    getattr(import_module(module), save)(target, place)
    return target
