"""Copy a few pairs of a simulated set as small examples."""

from collections import defaultdict
from pathlib import Path

from omnivat.data.images import read_image
from omnivat.data.pairs import Pair, PairSet
from omnivat.errors import DataError
from omnivat.files import replacing

QUALITY = 94  # of JPEG: over a quarter of the PNG
FULL_COLOUR = 0  # no subsampling: a gel's information is in its colours


def write_examples(made: PairSet, folder: Path, *, each: int = 2) -> list[Path]:
    """Write `<folder>/<domain>/<class>/<name>_{vis,tac}.jpg`; return the files.

    made  a simulated set on disk
    each  pairs of each class of each domain, of test objects; fewer if there are not enough

    Images keep their full size, with JPEG's loss. Raises DataError if the set has no test pairs.
    """
    classes: dict[tuple[str, str], list[Pair]] = defaultdict(list)
    for pair in made.pairs:
        if pair.split == "test":
            classes[pair.domain, pair.material].append(pair)
    if not classes:
        raise DataError(
            "The set has no test objects to take examples from; ask for 4 pairs per class or more."
        )
    written = []
    for (domain, material), things in classes.items():
        for pair in chosen(things, each):
            for kind, image in (("vis", pair.vis), ("tac", pair.tac)):
                stem = image.stem.removesuffix(f"_{kind}")
                file = folder / domain / material / f"{stem}_{kind}.jpg"
                _write(image, file)
                written.append(file)
    return written


def chosen(things: list[Pair], count: int) -> list[Pair]:
    """Return `count` of `things`, half of them (rounded down) visual imitators if possible."""
    alike = [pair for pair in things if pair.looks_like]
    plain = [pair for pair in things if not pair.looks_like]
    few = max(min(count // 2, len(alike)), count - len(plain))
    return spread(plain, count - few) + spread(alike, few)


def spread(things: list[Pair], count: int) -> list[Pair]:
    """Return `count` of `things`, evenly spaced, or all of them."""
    count = min(count, len(things))
    return [things[(2 * index + 1) * len(things) // (2 * count)] for index in range(count)]


def _write(image: Path, file: Path) -> None:
    with replacing(file) as temporary:
        read_image(image).save(temporary, format="JPEG", quality=QUALITY, subsampling=FULL_COLOUR)
