"""Show what a sensor is like from a folder of its touches, and what changed against another.

python -m omnivat sensor NEW [--against OLD] [--json] [--figure FILE.png] [--mend FOLDER]
"""

import argparse
import json
from dataclasses import replace
from pathlib import Path

from omnivat.cli.arguments import declare, path
from omnivat.cli.dots import images_of
from omnivat.kit.errors import SettingsError
from omnivat.kit.files import replacing, require_writable

NOTHING = (
    "Nothing was written: beside the pictures of --against these are neither turned nor mirrored,"
    " and their channels are not swapped."
)


def add(parser: argparse.ArgumentParser) -> None:
    words = "tactile images of one sensor, or a folder of them; 25 show most"
    parser.add_argument("pictures", nargs="+", type=Path, metavar="PICTURES", help=words)
    declare(
        parser,
        "json",
        against=path("a folder of touches of another sensor, or of this one before", "FOLDER"),
        figure=path("draw the lamps into this file: .png, .svg or .html", "FILE"),
        mend=path(
            "write the pictures turned, mirrored or with swapped channels as those of --against",
            "FOLDER",
        ),
    )


def run(options: argparse.Namespace) -> None:
    """Print the card; draw its lamps and write mended pictures if they are wanted."""
    import numpy as np

    from omnivat.data.arranged import arranged
    from omnivat.data.images import read_image
    from omnivat.measure.card.card import MOST, card_of
    from omnivat.measure.card.changes import AS_IT_IS, arrangement_of, changes_between
    from omnivat.measure.card.report import markdown, record

    if options.mend and not options.against:
        raise SettingsError("--mend needs --against FOLDER: the pictures that show the right way.")
    for file in filter(None, (options.figure, options.mend)):
        require_writable(file)
    files = [file for place in options.pictures for file in images_of(place)]

    def read(names: list[Path]) -> list[np.ndarray]:
        spread = np.linspace(0, len(names) - 1, min(len(names), MOST)).round().astype(int)
        return [np.asarray(read_image(names[k])) for k in spread]

    card, old = card_of(read(files)), None
    if options.against:
        old = card_of(read(images_of(options.against)))
        card = replace(card, changes=changes_between(old, card))
    title = f"The sensor of {options.pictures[0].name}"
    print(json.dumps(record(card), indent=1) if options.json else markdown(card, title))
    if options.figure:
        from omnivat import figures

        before = [] if old is None else [("before", old.lamps)]
        figures.write(options.figure, figures.rose([*before, ("now", card.lamps)], title=title))
    if options.mend and old is not None:
        way, _ = arrangement_of(old, card)
        if way is AS_IT_IS:
            raise SettingsError(NOTHING)
        for file in files:
            picture = arranged(read_image(file), way.back)
            with replacing(options.mend / f"{file.stem}.png") as temporary:
                picture.save(temporary, "PNG")
        print(f"{len(files)} pictures are written to {options.mend} as the old sensor shows them.")
