"""Write the page's pictures, Explore as one HTML file, or the page as a folder.

python -m omnivat export --what map|curves|page --out FILE [--order P] [--stage STAGE]
python -m omnivat export --site DIR [--head H] [--embeddings E] [--sets NAME …]
"""

import argparse
from dataclasses import replace

from omnivat.cli.arguments import declare, flag, one_of, passed, path, progress_bar, text
from omnivat.kit.errors import SettingsError
from omnivat.kit.stages import STAGES


def add(parser: argparse.ArgumentParser) -> None:
    target = parser.add_mutually_exclusive_group(required=True)
    declare(
        target,
        site=path("folder for the whole page, to be served by any file server"),
        out=path(".html (interactive), .svg, .png or .json (Plotly); .html for the page"),
    )
    parser.add_argument(
        "--sets", nargs="+", metavar="NAME", help="sets of the project in the site; default: all"
    )
    words = "leave out of the site what the browser computes with: own pictures, trees"
    colours = "domain, class, modality, correctness, confidence, or a column's colour of the page"
    declare(
        parser,
        "order",
        runtime=path(
            "folder of the npm package onnxruntime-web for the site; default: npm fetches it", "DIR"
        ),
        no_models=flag(words),
        head=path("head folder; default: the project's own"),
        embeddings=path("embeddings file; default: the project's own"),
        frames=path("frames from `sweep`, instead of computing them"),
        what=one_of(("map", "curves", "page"), "the picture to write"),
        stage=one_of(STAGES, "stage of the head to draw", "f_hat"),
        map=one_of(("pca", "umap"), "projection of the map"),
        colour=text(f"meaning of colours: {colours}; default: domain") | {"default": "domain"},
    )


def run(options: argparse.Namespace) -> None:
    """Find or make the frames, then write."""
    if options.site:
        from app.shared.places import places
        from app.site.folder import export_site

        where = places(options.head, options.embeddings)
        if options.frames:
            where = replace(where, frames=options.frames)
        with progress_bar("site") as show:
            sizes = export_site(
                where,
                options.site,
                options.sets,
                models=not options.no_models,
                runtime=options.runtime,
                on_step=show,
            )
        print(
            f"{len(sizes)} files, {sum(sizes.values()) / 1e6:.1f} MB, in {options.site}; "
            f"`python -m http.server --directory {options.site}` serves them"
        )
        return
    if options.sets or options.runtime or options.no_models:
        raise SettingsError("--sets, --runtime and --no-models belong to --site; leave them out.")
    wanted = (".html",) if options.what == "page" else (".html", ".svg", ".png", ".json")
    if options.out.suffix.lower() not in wanted:
        raise SettingsError(
            f"--out is '{options.out.name}'; for the {options.what} it ends in"
            f" {' or '.join(wanted)}."
        )
    from app.shared.places import places
    from app.site.export import export_page, export_picture, frames_file

    where = places(options.head, options.embeddings)
    with progress_bar("export") as show:
        frames = options.frames or frames_file(where, show)
    if options.what == "page":
        export_page(where, frames, options.out)
    else:
        look = passed(options, "what", "order", "stage", "colour")
        export_picture(where, frames, options.out, **look, kind=options.map)
    print(f"{options.what} written to {options.out}")
