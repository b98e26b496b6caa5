"""Write the page's pictures, Explore as one HTML file, or the page as a folder.

python -m omnivat export --what map|curves|page --out FILE [--order P] [--stage STAGE]
python -m omnivat export --site DIR [--head H] [--embeddings E] [--sets NAME …]
"""

import argparse
from dataclasses import replace
from pathlib import Path

from omnivat.cli.arguments import choice, passed, progress_bar, shared
from omnivat.kit.errors import SettingsError
from omnivat.kit.stages import STAGES


def add(parser: argparse.ArgumentParser) -> None:
    target = parser.add_mutually_exclusive_group(required=True)
    target.add_argument(
        "--site", type=Path, help="folder for the whole page, to be served by any file server"
    )
    text = ".html (interactive), .svg, .png or .json (Plotly); .html for the page"
    target.add_argument("--out", type=Path, help=text)
    parser.add_argument(
        "--sets", nargs="+", metavar="NAME", help="sets of the project in the site; default: all"
    )
    text = "folder of the npm package onnxruntime-web for the site; default: npm fetches it"
    parser.add_argument("--runtime", type=Path, metavar="DIR", help=text)
    text = "leave out of the site what the browser computes with: own pictures, trees"
    parser.add_argument("--no-models", dest="models", action="store_false", help=text)
    parser.add_argument("--head", type=Path, help="head folder; default: the project's own")
    parser.add_argument(
        "--embeddings", type=Path, help="embeddings file; default: the project's own"
    )
    parser.add_argument(
        "--frames", type=Path, help="frames from `sweep`, instead of computing them"
    )
    shared(parser, "order")
    choice(parser, "--what", ("map", "curves", "page"), "the picture to write")
    choice(parser, "--stage", STAGES, "stage of the head to draw", "f_hat")
    choice(parser, "--map", ("pca", "umap"), "projection of the map")
    choice(
        parser,
        "--colour",
        ("domain", "class", "modality", "correctness", "confidence"),
        "meaning of colours",
    )


def run(options: argparse.Namespace) -> None:
    """Find or make the frames, then write."""
    if options.site:
        from app.export import where_from
        from app.site import export_site

        where = where_from(options.head, options.embeddings)
        if options.frames:
            where = replace(where, frames=options.frames)
        with progress_bar("site") as show:
            sizes = export_site(
                where,
                options.site,
                options.sets,
                **passed(options, "models", "runtime"),
                on_step=show,
            )
        print(
            f"{len(sizes)} files, {sum(sizes.values()) / 1e6:.1f} MB, in {options.site}; "
            f"`python -m http.server --directory {options.site}` serves them"
        )
        return
    if options.sets or options.runtime or not options.models:
        raise SettingsError("--sets, --runtime and --no-models belong to --site; leave them out.")
    wanted = (".html",) if options.what == "page" else (".html", ".svg", ".png", ".json")
    if options.out.suffix.lower() not in wanted:
        raise SettingsError(
            f"--out is '{options.out.name}'; for the {options.what} it ends in"
            f" {' or '.join(wanted)}."
        )
    from app.export import export_page, export_picture, frames_file, where_from

    where = where_from(options.head, options.embeddings)
    with progress_bar("export") as show:
        frames = options.frames or frames_file(where, show)
    if options.what == "page":
        export_page(where, frames, options.out)
    else:
        look = passed(options, "what", "order", "stage", "colour")
        export_picture(frames, options.out, **look, kind=options.map)
    print(f"{options.what} written to {options.out}")
