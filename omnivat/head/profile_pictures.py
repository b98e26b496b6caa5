"""A profile of pictures on disk or in memory: embed each, keep mean and variance."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from omnivat.data.naming import is_image_name, modality_of
from omnivat.data.pairs import Skipped
from omnivat.data.profile import Profile, channels_of
from omnivat.data.readers import read_pairs, recognised
from omnivat.data.readers.files import folders_in, show, visible
from omnivat.data.rest import RESTED, with_rest
from omnivat.encoders.base import DotsFilled, Encoder, ReliefDrawn, for_modality
from omnivat.encoders.cache import Source, embed_image
from omnivat.encoders.embed.relief import lamps_or_reason
from omnivat.kit.errors import DataError, OmniVatError
from omnivat.kit.progress import OnStep, Step, ignore
from omnivat.kit.stages import IMAGES


@dataclass(frozen=True, slots=True, kw_only=True)
class Picture:
    """One unlabelled picture of a modality."""

    modality: str  # "vis" or "tac"
    source: Source
    name: str = ""
    crop: int = 0
    rest: Path | None = None
    way: str = ""


def pictures_in(
    folder: Path | None,
    *,
    vis: Path | None = None,
    tac: Path | None = None,
    rest: str | None = None,
) -> list[Picture]:
    """Return the pictures of a folder: of pairs, or by name (`*_vis.*`, `*_tac.*`, vis/, tac/).

    vis, tac  folders of one modality each, instead of `folder`
    rest      as --tac-rest of `embed`
    Raises DataError if there are none.
    """
    if folder is None:
        places = (("vis", vis), ("tac", tac))
        pictures = [
            _picture(name, path) for name, place in places if place for path in _images(place)
        ]
    else:
        pictures = _of_pairs(folder, rest) or [
            _picture(m, path) for path in _images(folder) if (m := modality_of(path))
        ]
    if not pictures:
        raise DataError(
            f"No photos or tactile images are in '{show(folder or vis or tac or '')}'. Name them "
            "*_vis.png and *_tac.png, put them in folders vis and tac, or give --vis and --tac."
        )
    if rest not in (None, "none", "auto", "all"):
        pictures = [
            replace(p, rest=Path(str(rest))) if p.modality == "tac" else p for p in pictures
        ]
    return pictures


def _picture(modality: str, path: Path) -> Picture:
    return Picture(modality=modality, source=path, name=show(path))


def _of_pairs(folder: Path, rest: str | None) -> list[Picture]:
    """Return the pictures of a table or a folder of pairs in a known layout; [] for another
    folder, and for one whose pictures names alone tell.
    """
    reader = recognised(folder)
    if (reader, rest or "none") == ("folder", "none"):
        return []
    try:
        pairs = with_rest(read_pairs(folder, reader=reader), rest or "none").pairs
    except OmniVatError:
        if not folder.is_dir():
            raise
        return []
    photos = dict.fromkeys(pair.vis for pair in pairs if pair.alone != "tac")
    return [_picture("vis", path) for path in photos] + [
        replace(_picture("tac", p.tac), crop=p.tac_crop, rest=p.tac_rest)
        for p in pairs
        if p.alone != "vis"
    ]


def _images(folder: Path) -> list[Path]:
    """Return the image files of a folder, at any depth."""
    files = [folder / entry.name for entry in visible(folder) if is_image_name(entry.name)]
    deeper = [path for place in folders_in(folder) for path in _images(place)]
    return [path for path in files if path.is_file()] + deeper


def profile_of_pictures(
    encoder: Encoder, pictures: Sequence[Picture], *, domain: str = "", on_step: OnStep = ignore
) -> tuple[Profile, tuple[Skipped, ...]]:
    """Embed pictures and return their profile, with the lamps if touches give them, and those
    that could not be read.

    Lamps need an encoder that fills dots; one that draws the relief of touch uses them, and
    another's profile also holds the statistics of the reliefs.
    Raises DataError if no picture can be read.
    """
    rows: dict[str, list[np.ndarray]] = {name: [] for name in (*IMAGES, "relief")}
    touches = [p for p in pictures if p.modality == "tac" and isinstance(encoder, DotsFilled)]
    lit = lamps_or_reason([(p.source, p.crop, p.rest, p.way) for p in touches]) if touches else None
    skipped: list[Skipped] = []
    bent: ReliefDrawn | None = None
    if isinstance(lit, str):
        skipped, lit = [Skipped(what="the lamps of the gel", why=lit)], None
    elif lit is not None:
        if isinstance(encoder, ReliefDrawn):
            encoder = ReliefDrawn(encoder, {domain: lit}, encoder.touch)
        else:
            bent = ReliefDrawn(encoder, {domain: lit})
    for done, picture in enumerate(pictures):
        on_step(Step(done=done, total=len(pictures), text=picture.name))
        looks = {picture.modality: encoder}
        if bent and picture.modality == "tac":
            looks["relief"] = bent
        try:
            embedded = {
                look: embed_image(
                    for_modality(encoder, picture.modality, domain),
                    picture.source,
                    crop=picture.crop,
                    rest=picture.rest,
                    way=picture.way,
                    name=picture.name,
                )
                for look, encoder in looks.items()
            }
        except DataError as error:
            skipped.append(Skipped(what=picture.name, why=str(error)))
        else:
            for look, row in embedded.items():
                rows[look].append(row)
    on_step(Step(done=len(pictures), total=len(pictures), text=""))
    rested = RESTED if any(picture.rest for picture in pictures) else ""
    key = encoder.name, encoder.weights_hash, encoder.preprocessing + rested
    channels = {name: channels_of(np.stack(some)) for name, some in rows.items() if some}
    relief = channels.pop("relief", None)
    if not channels:
        first = next((f" The first: {skip.why}" for skip in skipped), "")
        raise DataError(f"None of the pictures could be read.{first}")
    made = Profile(channels=channels, key=key, domain=domain, lamps=lit, relief=relief)
    return made, tuple(skipped)
