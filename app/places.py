"""Locations of the files that the page shows: the project's own, given ones, or a visitor's."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from app.limits import DRAWN_PAIRS
from omnivat.heads import EXAMPLES, default_embeddings, default_head, shipped_sets


@dataclass(frozen=True, slots=True, kw_only=True)
class Places:
    """Locations of files. `frames` is None if they must be computed."""

    head: Path
    embeddings: Path
    frames: Path | None
    sprite: Path | None  # NAME.thumbnails.webp next to the embeddings, and its .json
    pairs: Path | None  # example images; None: the gallery shows pairs of the set
    compare: tuple[Path, ...] = ()  # folders of comparison heads
    computed: Path | None = None  # folder of computed frames; None: the cache
    profile: Path | None = None  # of the visitor's sensor, in use from the start
    drawn: int = DRAWN_PAIRS  # of a larger set so many pairs are drawn at random


def places(head: Path | None = None, embeddings: Path | None = None, compare: Sequence[Path] = ()) -> Places:
    """Return the locations of the project's own files or of given ones."""
    own = head is None and embeddings is None
    frames = EXAMPLES / "frames.bin"
    sheet = (embeddings or default_embeddings()).with_suffix(".thumbnails.webp")
    return Places(
        head=head or default_head(),
        embeddings=embeddings or default_embeddings(),
        frames=frames if own and frames.is_file() else None,
        sprite=sheet if sheet.is_file() else None,
        pairs=EXAMPLES / "pairs" if embeddings is None else None,
        compare=tuple(compare),
    )


def shipped_places(name: str) -> Places:
    """Return the locations of a set of the project; `omnivat.heads.shipped_sets` lists them."""
    folder, embeddings = shipped_sets()[name]
    frames, sheet = folder / "frames.bin", embeddings.with_suffix(".thumbnails.webp")
    return Places(
        head=folder / "head",
        embeddings=embeddings,
        frames=frames if frames.is_file() else None,
        sprite=sheet if sheet.is_file() else None,
        pairs=folder / "pairs",
    )


def head_names(where: Places) -> dict[str, Path]:
    """Return the folder of each head by its name in requests; "" is the first one."""
    names = {"": where.head}
    for folder in where.compare:
        name = folder.name or "head"
        while name in names:
            name += "'"
        names[name] = folder
    return names
