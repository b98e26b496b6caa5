"""Draw the contact sheet of the simulated domains: two rows for each domain.

    python -m benchmarks.simulated_sheet [--pairs DIR] [--out docs/simulated.webp]

The upper row shows the first test pair of each class that imitates no other, the lower one the
first visual imitator, with the imitated class's name; the examples are not selected. Without a
table in the folder, imitations are unknown, and the first two pairs are shown.
"""

import argparse
from pathlib import Path

from PIL import Image, ImageDraw, ImageFont

from omnivat.data.domains import DOMAINS, simulated
from omnivat.data.images import read_image
from omnivat.data.materials import MATERIALS
from omnivat.data.pairs import Pair
from omnivat.data.readers import read_pairs
from omnivat.kit.errors import DataError

TILE = 112  # pixels of a side
GAP = 10  # between classes and between domains
LEFT, TOP = 118, 26  # room for names
QUALITY = 84


def main() -> None:
    """Write the sheet."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--pairs", type=Path, default=Path("examples/pairs"))
    parser.add_argument("--out", type=Path, default=Path("docs/simulated.webp"))
    given = parser.parse_args()
    sheet(given.pairs).save(given.out, quality=QUALITY, method=6)
    print(f"'{given.out}', {given.out.stat().st_size / 1e3:.0f} kB")


def sheet(folder: Path) -> Image.Image:
    """Return the sheet; raises DataError when `folder` holds no pair of the simulated domains."""
    step, height = 2 * TILE + GAP, 2 * TILE + GAP
    size = (LEFT + len(MATERIALS) * step, TOP + len(DOMAINS) * height)
    picture = Image.new("RGB", size, "white")
    draw, font = ImageDraw.Draw(picture), ImageFont.load_default(14)
    for column, material in enumerate(MATERIALS):
        draw.text((LEFT + column * step, 4), f"{material}: VIS, TAC", fill="black", font=font)
    found = _by_class(folder)
    for row, (name, domain) in enumerate(DOMAINS.items()):
        top = TOP + row * height
        draw.text((4, top + TILE - 20), f"{name}-sim\n{domain.sensor}", "black", font)
        for column, material in enumerate(MATERIALS):
            pairs = two_of(found.get((simulated(name), material), []))
            for line, pair in enumerate(pairs):
                _paste(picture, pair, (LEFT + column * step, top + line * TILE))
    return picture


def _by_class(folder: Path) -> dict[tuple[str, str], list[Pair]]:
    found: dict[tuple[str, str], list[Pair]] = {}
    for pair in read_pairs(folder).pairs if folder.is_dir() else ():
        if pair.split in ("test", "") and pair.domain in map(simulated, DOMAINS):
            found.setdefault((pair.domain, pair.material), []).append(pair)
    if not found:
        raise DataError(f"'{folder}' holds no pair; make some with `simulate --examples`.")
    return found


def two_of(pairs: list[Pair]) -> list[Pair]:
    """Return the first pair that imitates nothing and the first that looks like another class.

    If imitations are unknown, return the first two.
    """
    plain = [pair for pair in pairs if not pair.looks_like and not pair.feels_like]
    alike = [pair for pair in pairs if pair.looks_like]
    return [*plain[:1], *alike[:1]] if alike else pairs[:2]


def _paste(picture: Image.Image, pair: Pair, place: tuple[int, int]) -> None:
    """Paste both images of a pair at `place`, with the name of the class that it looks like."""
    for index, file in enumerate((pair.vis, pair.tac)):
        tile = read_image(file).resize((TILE, TILE), Image.Resampling.LANCZOS)
        picture.paste(tile, (place[0] + index * TILE, place[1]))
    if pair.looks_like:
        draw, font = ImageDraw.Draw(picture), ImageFont.load_default(11)
        corner = (place[0] + 2, place[1] + TILE - 14)
        name = f"looks like {pair.looks_like}"
        draw.rectangle(draw.textbbox(corner, name, font=font), fill="black")
        draw.text(corner, name, fill="white", font=font)


if __name__ == "__main__":
    main()
