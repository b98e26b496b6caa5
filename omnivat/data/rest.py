"""No-contact pictures: a tactile image minus that of the same sensor while it touches nothing.

Subtracting one, for each sensor unit, is a habit of the field: Sparsh (Higuera et al., CoRL 2024),
TVL (Fu et al., ICML 2024), gsrobotics (the mean of the first frames).
"""

from collections import defaultdict
from collections.abc import Callable
from dataclasses import replace
from hashlib import blake2b
from pathlib import Path

from PIL import Image, ImageChops

from omnivat.data.arranged import arranged
from omnivat.data.domains import DOMAINS, paper_name
from omnivat.data.images import central_square, read_bytes, read_image
from omnivat.data.pairs import Pair, PairSet
from omnivat.kit.errors import DataError

REST = "rest.png"  # in the folder of a domain, or of one sensor unit inside it
RESTED = "; TAC minus its rest picture"  # at the end of a set's preprocessing
LEVELS = 3  # folders above a tactile image in which REST is looked for: object, class, domain
CHOICES = ("none", "auto", "all")
MARKERS = ("GelSight", "GelSlim", "DuraGel", "Tac3D")  # printed dots shift, and would show twice


def minus_rest(image: Image.Image, rest: Image.Image, *, offset: int = 128) -> Image.Image:
    """Return clip(image - rest + offset) in 8 bits; `rest` is resized to the image's size."""
    still = rest.resize(image.size, Image.Resampling.BICUBIC)
    return ImageChops.subtract(image, still, offset=offset)


def seen(
    content: bytes | Image.Image,
    name: str,
    *,
    crop: int = 0,
    rest: bytes = b"",
    way: str = "",
    clean: Callable[[Image.Image], Image.Image] = lambda image: image,
) -> Image.Image:
    """Return a picture as an encoder gets it: upright, cropped to its central square, less the
    picture of the untouched sensor if `rest` has that file's bytes.

    way    turns or mirrors it last, or swaps channels (`omnivat.data.arranged`)
    clean  fills printed dots: they move, and would show twice in a difference

    Raises DataError as `read_image` does.
    """
    image = central_square(read_image(content, name, reduced=not crop), crop)
    if not rest:
        return arranged(image, way)
    still = central_square(read_image(rest, "the no-contact picture", reduced=not crop), crop)
    return arranged(minus_rest(clean(image), clean(still)), way)


def with_rest(loaded: PairSet, choice: str) -> PairSet:
    """Return the pairs with the no-contact picture of each tactile image.

    choice  "none"; "auto": the nearest `rest.png` in the folders above an image, but not for
            sensors with markers; "all": also for those; otherwise the file to use for every pair

    Raises DataError if no pair has one, or the file cannot be read.

    >>> from tempfile import TemporaryDirectory
    >>> from omnivat import EXAMPLES, read_pairs
    >>> with TemporaryDirectory() as folder:
    ...     file = Path(folder) / "untouched.png"
    ...     Image.new("RGB", (8, 8)).save(file)
    ...     rested = with_rest(read_pairs(EXAMPLES / "pairs"), str(file))
    >>> rested.pairs[0].tac_rest.name  # what `embed_pairs` subtracts from the touch
    'untouched.png'
    """
    if choice == "none":
        return loaded
    if choice in CHOICES:
        seen: dict[Path, Path | None] = {}
        pairs = tuple(
            pair
            if choice == "auto" and has_markers(pair.domain)
            else replace(pair, tac_rest=_nearest(pair.tac.parent, LEVELS, seen))
            for pair in loaded.pairs
        )
    else:
        read_bytes(Path(choice))
        pairs = tuple(replace(pair, tac_rest=Path(choice)) for pair in loaded.pairs)
    if not any(pair.tac_rest for pair in pairs):
        beside = " for a sensor without markers ('all' takes every one)" if choice == "auto" else ""
        raise DataError(
            f"No '{REST}' lies in the folders of these tactile images{beside}; put one into the "
            "domain's folder, or name a file."
        )
    return replace(loaded, pairs=pairs)


def has_markers(domain: str) -> bool:
    """True for a domain of the paper, real or simulated, whose sensor has markers."""
    known = DOMAINS.get(paper_name(domain))
    return known is not None and known.sensor in MARKERS


def rests_of(pairs: tuple[Pair, ...]) -> dict[str, list[str]]:
    """Return domain -> hashes of the no-contact pictures that its pairs use, for a set's header."""
    found: dict[str, set[str]] = defaultdict(set)
    for domain, file in dict.fromkeys((pair.domain, pair.tac_rest) for pair in pairs):
        if file is not None:
            found[domain].add(blake2b(read_bytes(file), digest_size=8).hexdigest())
    return {domain: sorted(hashes) for domain, hashes in found.items()}


def _nearest(folder: Path, levels: int, seen: dict[Path, Path | None]) -> Path | None:
    """Return the nearest `rest.png` in `folder` or the folders above it, or None."""
    if folder not in seen:
        here = folder / REST
        above = folder.parent if levels > 1 and folder.parent != folder else None
        seen[folder] = here if here.is_file() else above and _nearest(above, levels - 1, seen)
    return seen[folder]
