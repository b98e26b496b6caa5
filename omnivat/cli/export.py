"""Write the page's pictures, or Explore as one HTML file.

python -m omnivat export --what map|curves|page --out FILE [--order P] [--stage STAGE]
"""

import argparse
from pathlib import Path

from omnivat.cli.arguments import order
from omnivat.cli.bar import progress_bar
from omnivat.errors import SettingsError
from omnivat.stages import STAGES

COLOURS = ("domain", "class", "modality", "correctness")


def add(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument(
        "--what",
        choices=("map", "curves", "page"),
        default="map",
        help="the picture to write; default: the map",
    )
    parser.add_argument("--out", type=Path, required=True, help=".svg or .png; .html for the page")
    parser.add_argument("--head", type=Path, help="head folder; default: the project's own")
    parser.add_argument(
        "--embeddings", type=Path, help="embeddings file; default: the project's own"
    )
    parser.add_argument(
        "--frames", type=Path, help="frames from `sweep`, instead of computing them"
    )
    parser.add_argument(
        "--order", type=order, help="p, -4 to 4 quarter turns; default: the learned one"
    )
    parser.add_argument(
        "--stage",
        choices=STAGES,
        default="f_hat",
        help="stage of the head to draw; default: f_hat",
    )
    parser.add_argument(
        "--map",
        choices=("pca", "umap"),
        default="pca",
        help="projection of the map; default: pca",
    )
    parser.add_argument(
        "--colour",
        choices=COLOURS,
        default="domain",
        help="meaning of colours; default: domain",
    )


def run(options: argparse.Namespace) -> None:
    """Find or make the frames, then write."""
    wanted = (".html",) if options.what == "page" else (".svg", ".png")
    if options.out.suffix.lower() not in wanted:
        raise SettingsError(
            f"--out is '{options.out.name}'; for the {options.what} it ends in "
            f"{' or '.join(wanted)}."
        )
    from app.export import export_page, export_picture, frames_file, where_from

    where = where_from(options.head, options.embeddings)
    with progress_bar("export") as show:
        frames = options.frames or frames_file(where, show)
    if options.what == "page":
        export_page(where, frames, options.out)
    else:
        export_picture(
            frames,
            options.out,
            what=options.what,
            order=options.order,
            stage=options.stage,
            kind=options.map,
            colour=options.colour,
        )
    print(f"{options.what} written to {options.out}")
