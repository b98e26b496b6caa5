"""One sheet of thumbnails for a set of embeddings, shown in the page."""

import math
from pathlib import Path

from PIL import Image

from omnivat.data.images import read_image
from omnivat.data.store import Embeddings
from omnivat.kit.errors import DataError
from omnivat.kit.files import replacing, write_json
from omnivat.kit.progress import OnStep, Step, ignore

TILE = 64  # pixels for each side
QUALITY = 60  # of WebP
SIDE_LIMIT = 16383  # pixels, WebP's limit


def sheet_of(embeddings: Path) -> Path:
    """Return the path of the thumbnails of an embeddings file, next to the file."""
    return embeddings.with_suffix(".thumbnails.webp")


def write_thumbnails(
    embeddings: Embeddings,
    root: str | Path,
    out: str | Path,
    *,
    tile: int = TILE,
    on_step: OnStep = ignore,
) -> int:
    """Write the sheet (WebP) and its description (JSON); return the number of missing images.

    root  base folder of the file names in the embeddings
    tile  side of one thumbnail in pixels

    Tile i is pair i's photo, tile N + i its tactile image, in rows from the top left. An image that
    cannot be read leaves a grey tile and is counted.
    Raises DataError if there is no pair, no image is found, or the sheet would exceed the format's
    limit.
    """
    names = [*embeddings.rows["vis"], *embeddings.rows["tac"]]
    if not names:
        raise DataError("There are no pairs in these embeddings; choose a set with pairs.")
    columns = math.ceil(math.sqrt(len(names)))
    if columns * tile > SIDE_LIMIT:
        raise DataError(
            f"{len(names)} thumbnails of {tile} pixels do not fit one sheet of {SIDE_LIMIT} "
            f"pixels a side; choose --tile {SIDE_LIMIT // columns} or less."
        )
    sheet = Image.new("RGB", (columns * tile, math.ceil(len(names) / columns) * tile), "#808080")
    missing = 0
    for index, name in enumerate(names):
        place = (index % columns * tile, index // columns * tile)
        try:
            image = read_image(Path(root) / name)
        except DataError:
            missing += 1
        else:
            sheet.paste(image.resize((tile, tile), Image.Resampling.LANCZOS), place)
        on_step(Step(done=index + 1, total=len(names), text=name))
    if missing == len(names):
        raise DataError(
            f"None of the {missing} images is under '{root}'; pass the folder that was embedded."
        )
    with replacing(out) as temporary:
        sheet.save(temporary, format="WEBP", quality=QUALITY, method=6)
    description = {"tile": tile, "columns": columns, "count": len(names)}
    write_json(Path(out).with_suffix(".json"), description)
    return missing
