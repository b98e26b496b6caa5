"""Draw the contact sheet of the simulated domains: a row a domain, VIS and TAC of each class.

    python -m benchmarks.simulated_sheet [--pairs examples/pairs] [--out docs/simulated.webp]

Takes the first example of each class; nobody chose it for its looks.
"""

import argparse
from pathlib import Path

from PIL import Image, ImageDraw, ImageFont

from omnivat.data.domains import DOMAINS, simulated
from omnivat.data.images import read_image
from omnivat.data.materials import MATERIALS
from omnivat.errors import DataError

TILE = 152  # pixels of a side
GAP = 10  # between classes
LEFT, TOP = 118, 26  # room for names
QUALITY = 88


def main() -> None:
    """Write the sheet."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--pairs", type=Path, default=Path("examples/pairs"))
    parser.add_argument("--out", type=Path, default=Path("docs/simulated.webp"))
    given = parser.parse_args()
    sheet(given.pairs).save(given.out, quality=QUALITY, method=6)
    print(f"'{given.out}', {given.out.stat().st_size / 1e3:.0f} kB")


def sheet(pairs: Path) -> Image.Image:
    """Return the sheet; raises DataError when `pairs` holds none at all."""
    step = 2 * TILE + GAP
    size = (LEFT + len(MATERIALS) * step, TOP + len(DOMAINS) * TILE)
    picture = Image.new("RGB", size, "white")
    draw, font = ImageDraw.Draw(picture), ImageFont.load_default(14)
    for column, material in enumerate(MATERIALS):
        draw.text((LEFT + column * step, 4), f"{material}: VIS, TAC", fill="black", font=font)
    found = 0
    for row, (name, domain) in enumerate(DOMAINS.items()):
        top = TOP + row * TILE
        draw.text((4, top + TILE // 2 - 20), f"{name}-sim\n{domain.sensor}", "black", font)
        for column, material in enumerate(MATERIALS):
            files = first_pair(pairs / simulated(name) / material)
            found += len(files) // 2
            for place, file in enumerate(files):
                tile = read_image(file).resize((TILE, TILE), Image.Resampling.LANCZOS)
                picture.paste(tile, (LEFT + column * step + place * TILE, top))
    if not found:
        raise DataError(f"'{pairs}' holds no pair; make some with `simulate --examples`.")
    return picture


def first_pair(folder: Path) -> tuple[Path, ...]:
    """Return the VIS and TAC files of the first pair in a folder, or nothing."""
    for vis in sorted(folder.glob("*_vis.*")):
        tac = vis.with_name(vis.name.replace("_vis.", "_tac."))
        if tac.exists():
            return vis, tac
    return ()


if __name__ == "__main__":
    main()
