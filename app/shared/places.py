"""Locations of the files that the page shows: the project's own, given ones, or a visitor's."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from app.shared.limits import DRAWN_PAIRS
from omnivat.head.heads import (
    EXAMPLES,
    HEAD,
    OWN,
    default_embeddings,
    default_head,
    own_head,
    shipped_sets,
)

ENDINGS = (".png", ".webp", ".jpg", ".jpeg")


@dataclass(frozen=True, slots=True, kw_only=True)
class Places:
    """Locations of files. `frames` is None if they must be computed."""

    head: Path
    embeddings: Path
    frames: Path | None
    pairs: Path | None  # example images; None: the gallery shows pairs of the set
    compare: tuple[Path, ...] = ()  # folders of comparison heads
    own: Path | None = None  # the head for a visitor's own pictures, beside the project's head
    computed: Path | None = None  # folder of computed frames; None: the cache
    profile: Path | None = None  # of the visitor's sensor, in use from the start
    drawn: int = DRAWN_PAIRS  # of a larger set so many pairs are drawn at random

    @property
    def sheet(self) -> Path | None:
        """The thumbnails next to the embeddings; None if they or their description are missing."""
        sheet = self.embeddings.with_suffix(".thumbnails.webp")
        return sheet if sheet.is_file() and sheet.with_suffix(".json").is_file() else None


def places(
    head: Path | None = None, embeddings: Path | None = None, compare: Sequence[Path] = ()
) -> Places:
    """Return the locations of the project's own files or of given ones."""
    located = _places(EXAMPLES, head or default_head(), embeddings or default_embeddings())
    if head or embeddings:
        located = replace(located, frames=None, pairs=None if embeddings else located.pairs)
    return replace(located, compare=tuple(compare), own=None if head else located.own)


def head_in(folder: Path) -> Path:
    """Return the folder of a head; of a folder that `omnivat try` wrote, the one inside it."""
    inside = folder / HEAD
    return inside if (inside / "settings.json").is_file() else folder


def shipped_places(name: str) -> Places:
    """Return the locations of a set of the project; `omnivat.head.heads.shipped_sets` lists
    them.
    """
    folder, embeddings = shipped_sets()[name]
    return _places(folder, folder / "head", embeddings)


def _places(folder: Path, head: Path, embeddings: Path) -> Places:
    frames = folder / "frames.bin"
    return Places(
        head=head,
        embeddings=embeddings,
        frames=frames if frames.is_file() else None,
        pairs=folder / "pairs",
        own=own_head() if head == default_head() else None,
    )


def head_names(where: Places) -> dict[str, Path]:
    """Return the folder of each head by its name in requests; "" is the first one."""
    names = {"": where.head}
    for folder in where.compare:
        name = (folder.parent if folder.name == HEAD else folder).name or HEAD
        while name in names or name == OWN:
            name += "'"
        names[name] = folder
    return names


def find_examples(folder: Path) -> dict[str, dict[str, Path]]:
    """Return the images of the complete pairs under `folder`: "domain/class/stem" -> modality ->
    file.

    The files are `<domain>/<class>/<stem>_{vis,tac}.*`; a missing folder has none.
    """
    found = {}
    for vis in sorted(folder.glob("*/*/*_vis.*")):
        name = example_name(vis)
        beside = vis.parent.glob(f"{name.split('/')[-1]}_tac.*")
        tacs = [tac for tac in beside if tac.suffix.lower() in ENDINGS]
        if tacs and vis.suffix.lower() in ENDINGS:
            found[name] = {"vis": vis, "tac": tacs[0]}
    return found


def example_name(vis: Path) -> str:
    """Return "domain/class/stem" of a photo `<domain>/<class>/<stem>_vis.*`."""
    return "/".join((*vis.parts[-3:-1], vis.stem.removesuffix("_vis")))
