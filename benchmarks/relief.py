"""Touches of the shipped set by relief, as each seed of the table knows their sensors.

    python -m benchmarks.relief FOLDER [--seeds 0] [--out examples/relief]

FOLDER is what `python -m simulator set --touches` drew. Lamps are knowledge of a target like a
profile: those of a source come from 50 of its training pairs, those of a target from the 5 or 20
training pairs that a seed knows without labels, or from its 5 labelled pairs of each class. With
nothing known, each touch is read by its own lamps. Written are

    source.npz       every touch by the lamps of its domain as a source, and mirrored copies
    alone.npz        every touch by its own lamps
    SEED-KNOWN.npz   the touches of test pairs and known pairs by a target's lamps

A target whose lamps are refused is read by each touch's own. A value is one byte of a unit row, as
in twins (`omnivat.measure.twins`), so that the shipped folder stays small.
"""

import argparse
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from omnivat.cli.arguments import numbers
from omnivat.data.dots import fill_dots
from omnivat.data.embeddings import Embeddings
from omnivat.data.relief import Lamps, NoLampsError, drawn, lamps
from omnivat.data.store import load_embeddings
from omnivat.encoders import load_encoder
from omnivat.head.heads import EXAMPLES, default_embeddings
from omnivat.kit.files import replacing
from omnivat.kit.stages import IMAGES
from omnivat.kit.threads import pin_thread
from omnivat.measure.known import known_rows
from omnivat.measure.rungs import Known, labels, pairs
from omnivat.measure.twins import LEVELS

Array = NDArray[Any]
FOLDER = EXAMPLES / "relief"
KNOWN = (pairs(5), pairs(20), labels(5))
MOST = 50  # pictures of a source that give its lamps


def order(embeddings: Embeddings, stream: str, seed: int, domain: str, pool: Array) -> Array:
    """Return a pool in the order of the records; pairs without labels and with are the same."""
    place = [seed, embeddings.header.domains.index(domain), *[1] * (stream == "sensors")]
    mixed: Array = np.random.default_rng(place).permutation(pool)
    return mixed


def known(embeddings: Embeddings, what: Known, seed: int, domain: str) -> Array:
    """Return the rows of a domain that a seed of the table knows."""

    def draw(stream: str, seed: int, domain: str, pool: Array) -> Array:
        return order(embeddings, stream, seed, domain, pool)

    return known_rows(embeddings, replace(what, draw=draw), domain, seed)


def spread(rows: Array, most: int = MOST) -> Array:
    """Return at most `most` rows, spread evenly."""
    places = np.linspace(0, len(rows) - 1, min(most, len(rows))).round().astype(int)
    some: Array = rows[np.unique(places)]
    return some


class Reliefs:
    """A set whose touches are read by relief.

    colours  the set itself
    source   every domain by the lamps that it has as a source
    alone    every touch by its own lamps
    """

    def __init__(self, colours: Embeddings, folder: Path = FOLDER) -> None:
        self.colours, self.folder = colours, folder
        origin = f"{colours.header.origin}, touches by relief"
        self.source, self.alone = (
            replace(
                colours,
                **read(folder / f"{name}.npz"),
                header=replace(colours.header, origin=origin),
            )
            for name in ("source", "alone")
        )

    def target(self, what: Known, seed: int) -> Embeddings:
        """Return the set as a seed reads its targets."""
        tac = np.array(self.alone.tac)
        held = read(self.folder / f"{seed}-{what.name}.npz")
        tac[held["rows"]] = held["tac"]
        return replace(self.source, tac=tac)


class Wide(Reliefs):
    """A set whose touches are read in colours and by relief, as `embed --touch both` reads them."""

    def __init__(self, relief: Reliefs) -> None:
        self.colours, self.relief = relief.colours, relief
        self.source, self.alone = map(self.beside, (relief.source, relief.alone))

    def target(self, what: Known, seed: int) -> Embeddings:
        """Return the set as a seed reads its targets."""
        return self.beside(self.relief.target(what, seed))

    def beside(self, lit: Embeddings) -> Embeddings:
        """Return colours beside relief, and photos beside zeros; mirrored pairs are left out."""
        photo, touch = (np.asarray(getattr(self.colours, n), np.float32) for n in IMAGES)
        vis, tac = np.hstack([photo, np.zeros_like(photo)]), np.hstack([touch, lit.tac])
        return replace(lit, vis=vis, tac=tac, vis_flip=None, tac_flip=None)


class Drawn:
    """Touches of a set as pictures, without dots, and their embeddings by relief."""

    def __init__(self, embeddings: Embeddings, folder: Path) -> None:
        self.set, self.folder = embeddings, folder
        self.encoder = load_encoder("efficientnet-lite0")

    def picture(self, row: int) -> Array:
        """Return the touch of a row, (H, W, 3) uint8, its dots filled."""
        image = Image.open(self.folder / self.set.rows["tac"][row]).convert("RGB")
        return fill_dots(np.asarray(image))[0]

    def lamps(self, rows: Array) -> Lamps | None:
        """Return the lamps from some rows of one domain; None where they give none."""
        try:
            return lamps((self.picture(row) for row in rows), dots="keep")
        except NoLampsError as error:
            print(error, flush=True)
            return None

    def embedded(self, rows: Array, by: Lamps | None, *, mirror: bool = False) -> Array:
        """Return embeddings (n, W) of touches by lamps, None: their own; `mirror`: mirrored."""
        found = np.empty((len(rows), self.encoder.width), np.float32)
        for k, row in enumerate(rows):
            image = drawn(self.picture(row), by, dots="keep")
            prepared = self.encoder.preprocess(Image.fromarray(image[:, ::-1] if mirror else image))
            found[k] = self.encoder.embed(prepared[None]).numpy()[0]
        return found

    def every(self, *, alone: bool) -> dict[str, Array]:
        """Return the contents of source.npz, or of alone.npz."""
        tac = np.empty((len(self.set), self.encoder.width), np.float32)
        flip = np.zeros_like(tac)  # of training pairs, for heads that learn mirrored ones, too
        for domain in self.set.header.domains:
            rows, train = (self.set.rows_of(domain, split=part) for part in ("", "train"))
            by = None if alone else self.lamps(spread(train))
            tac[rows] = self.embedded(rows, by)
            if not alone:
                flip[train] = self.embedded(train, by, mirror=True)
        return {"tac": tac} if alone else {"tac": tac, "tac_flip": flip}

    def target(self, what: Known, seed: int) -> dict[str, Array]:
        """Return the contents of SEED-KNOWN.npz."""
        rows, tac = [], []
        for domain in self.set.header.domains:
            some = known(self.set, what, seed, domain)
            rows.append(np.union1d(self.set.rows_of(domain, split="test"), some))
            tac.append(self.embedded(rows[-1], self.lamps(some)))
        return {"rows": np.concatenate(rows), "tac": np.concatenate(tac)}


def write(path: Path, content: Mapping[str, Array]) -> None:
    """Write arrays, completely or not at all; rows of features as bytes and their lengths."""
    path.parent.mkdir(parents=True, exist_ok=True)
    held: dict[str, Any] = {name: values for name, values in content.items() if name == "rows"}
    for name in content.keys() - held.keys():
        length = np.linalg.norm(content[name], axis=-1).astype(np.float32)
        level = LEVELS * content[name] / np.maximum(length, 1e-9)[:, None]
        held |= {name: np.rint(level).clip(0, 255).astype(np.uint8), f"{name}_length": length}
    with replacing(path) as temporary, temporary.open("wb") as file:
        np.savez_compressed(file, **held)


def read(path: Path) -> dict[str, Any]:
    """Return the arrays of a file of this module."""
    with np.load(path) as file:
        return {
            name: file[name]
            if name == "rows"
            else file[name] * (file[f"{name}_length"] / LEVELS)[:, None]
            for name in file.files
            if not name.endswith("_length")
        }


def main(arguments: Sequence[str] | None = None) -> None:
    """Embed what is missing."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folder", type=Path)
    parser.add_argument("--seeds", default="0")
    parser.add_argument("--out", type=Path, default=FOLDER)
    options = parser.parse_args(arguments)
    pin_thread()
    made = Drawn(load_embeddings(default_embeddings()), options.folder)
    for name in ("source", "alone"):
        if not (file := options.out / f"{name}.npz").is_file():
            write(file, made.every(alone=name == "alone"))
    for seed in numbers(options.seeds):
        for what in KNOWN:
            if not (file := options.out / f"{seed}-{what.name}.npz").is_file():
                write(file, made.target(what, seed))


if __name__ == "__main__":
    main()
