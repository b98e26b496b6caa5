"""Fill the dots that are printed on a gel, and show each picture before and after.

python -m omnivat dots PICTURES [PICTURES ...] --out DIR
"""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from omnivat.cli.arguments import declare, path
from omnivat.kit.errors import DataError
from omnivat.kit.files import nothing_left, replacing

if TYPE_CHECKING:
    from omnivat.data.dots import Dots


def add(parser: argparse.ArgumentParser) -> None:
    words = "tactile pictures, or folders of them"
    parser.add_argument("pictures", nargs="+", type=Path, metavar="PICTURES", help=words)
    declare(parser, out=path("folder to write", "DIR", required=True))


def run(options: argparse.Namespace) -> None:
    """Print one line a picture; write before and after, side by side, of those with dots."""
    import numpy as np
    from PIL import Image

    from omnivat.data.dots import fill_dots
    from omnivat.data.images import read_image

    pictures = [file for place in options.pictures for file in images_of(place)]
    filled = 0
    with nothing_left(options.out):
        for picture in pictures:
            before = np.asarray(read_image(picture))
            after, dots = fill_dots(before)
            print(f"{picture}: {words(dots)}")
            if dots is not None:
                filled += 1
                with replacing(options.out / f"{filled:03d}_{picture.stem}.png") as temporary:
                    Image.fromarray(np.concatenate([before, after], 1)).save(temporary, "PNG")
    where = f"; before and after are in {options.out}" if filled else ""
    print(f"{filled} of {len(pictures)} pictures have dots{where}")


def images_of(place: Path) -> list[Path]:
    """Return the images under a folder, or the file itself; raises DataError if there are none."""
    from omnivat.data.naming import is_image_name

    if not place.is_dir():
        return [place]
    files = sorted(file for file in place.rglob("*") if is_image_name(file.name) and file.is_file())
    if not files:
        raise DataError(f"'{place}' holds no pictures; name a folder of tactile pictures.")
    return files


def words(dots: "Dots | None") -> str:
    """Return what was filled in one picture, in words."""
    if dots is None:
        return "no grid of dots, unchanged"
    across, down = dots.pitch
    return (
        f"{dots.number} {'light' if dots.light else 'dark'} dots filled: {across:.0f} by {down:.0f}"
        f" pixels apart, {dots.size:.0f} wide, {dots.darkness:.0%} of the light, {dots.share:.0%}"
        " of the grid present"
    )
