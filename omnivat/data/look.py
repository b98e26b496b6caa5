"""A contact sheet: a few pairs of each domain, split and class on one picture, to be checked by a
person.
"""

from pathlib import Path

from PIL import Image, ImageDraw, ImageFont

from omnivat.data.images import read_image
from omnivat.data.pairs import Pair, PairSet
from omnivat.kit.errors import DataError, printable
from omnivat.kit.files import replacing

TILE, LINE, EDGE = 112, 15, 6  # pixels: side of a picture, height of a line of text, margin
ACROSS = 6  # pairs
MOST = 60


def contact_sheet(pairs: PairSet, out: Path) -> int:
    """Write a few pairs as a PNG, photo and touch side by side above their names; return how many.

    Each domain, split and class has one pair before any has two, up to 60 pairs. A picture that
    cannot be read is a grey tile.
    """
    groups: dict[tuple[str, str, str], list[Pair]] = {}
    for pair in pairs.pairs:
        groups.setdefault((pair.domain, pair.split, pair.material), []).append(pair)
    rounds = (group[k] for k in range(MOST) for group in groups.values() if k < len(group))
    shown = sorted(
        (pair for pair, _ in zip(rounds, range(max(ACROSS, MOST)), strict=False)),
        key=lambda pair: [*groups].index((pair.domain, pair.split, pair.material)),
    )
    wide, high = 2 * TILE + EDGE, TILE + 2 * LINE + EDGE
    rows = -(-len(shown) // ACROSS)
    sheet = Image.new("RGB", (ACROSS * wide + EDGE, rows * high + EDGE), "white")
    draw, font = ImageDraw.Draw(sheet), ImageFont.load_default(size=11)
    for number, pair in enumerate(shown):
        left, top = EDGE + number % ACROSS * wide, EDGE + number // ACROSS * high
        halves = [pair.vis, pair.tac] if not pair.alone else [getattr(pair, pair.alone)]
        for k, file in enumerate(halves):
            sheet.paste(_tile(file), (left + (k + (pair.alone == "tac")) * TILE, top))
        lines = (
            f"{pair.domain} · {pair.material}",
            " · ".join(filter(None, (pair.object, pair.split))),
        )
        for k, line in enumerate(lines):
            draw.text((left, top + TILE + k * LINE), _fitting(line, font), "black", font)
    with replacing(out) as temporary:
        sheet.save(temporary, "PNG")
    return len(shown)


def _tile(file: Path) -> Image.Image:
    try:
        image = read_image(file)
    except DataError:
        return Image.new("RGB", (TILE - 2, TILE), "#808080")
    image.thumbnail((TILE - 2, TILE))
    return image


def _fitting(text: str, font: ImageFont.FreeTypeFont | ImageFont.ImageFont) -> str:
    """Return as much of a text as fits under a pair."""
    text = printable(text)
    while font.getlength(text) > 2 * TILE - EDGE:
        text = text[:-2].rstrip() + "…"
    return text
