"""Draw a map of a set at one stage: a CSV of every VIS and TAC point, or an interactive figure.

python -m omnivat project [--out MAP.csv] [--figure MAP.html] [--stage S] [--order P] [--method
umap|pca|umap-learn]
"""

import argparse
from collections.abc import Iterator
from typing import TYPE_CHECKING

from omnivat.cli.arguments import declare, figure, one_of, path
from omnivat.cli.features import StageFeatures, add_stage, stage_features
from omnivat.kit.errors import SettingsError
from omnivat.kit.files import require_writable, write_csv
from omnivat.maps.projection import PROJECTIONS

if TYPE_CHECKING:
    from torch import Tensor

    from omnivat.maps.projection.quality import Quality

COLUMNS = ("modality", "domain", "class", "pair", "name")
NEIGHBOURS = 15
LEAST = 2 * NEIGHBOURS + 1  # fewest points for a faithfulness value


def add(parser: argparse.ArgumentParser) -> None:
    add_stage(parser)
    declare(
        parser,
        method=one_of(list(PROJECTIONS), "method of the map", "umap"),
        out=path("the CSV to write"),
        dimensions=one_of((2, 3), "of the map"),
        seed="seed of the layout; default: 0",
    )
    figure(parser, "the map")


def run(options: argparse.Namespace) -> None:
    """Compute the features, map them, write the CSV, print the faithfulness."""
    if options.out is None and options.figure is None:
        raise SettingsError("There is no output; give --out MAP.csv or --figure MAP.html.")
    if options.out is not None:
        if options.out.suffix.lower() != ".csv":
            raise SettingsError(f"--out is '{options.out}'; name a file that ends in .csv.")
        require_writable(options.out)
    from omnivat.kit.tables import load, need

    if options.method == "umap-learn":  # before the features are computed
        need("umap", purpose="the umap-learn projection", install="umap-learn")
    from omnivat.maps.projection.quality import quality
    from omnivat.maps.projection.torch_umap import MOST_ROWS

    found = stage_features(options)
    points = found.points()
    project = load(PROJECTIONS, options.method, kind="map")
    flat = project(points, seed=options.seed, dimensions=options.dimensions)
    if options.out is not None:
        write_csv(options.out, (*"xyz"[: flat.shape[1]], *COLUMNS), _rows(found, flat))
    print(f"{options.method} of {options.stage}: {found.about}")
    trust = ""
    if len(points) >= LEAST:
        trust = faithfulness(quality(points, flat, k=NEIGHBOURS))
        print(trust)
    if options.figure is not None:
        _draw(options, found, flat, trust)
    if options.method == "umap" and len(points) > MOST_ROWS:
        print(f"{MOST_ROWS:,} points were mapped; the others are placed between their neighbours")
    written = " and ".join(str(path) for path in (options.out, options.figure) if path)
    print(f"{len(points)} points written to {written}")


def _draw(options: argparse.Namespace, features: StageFeatures, flat: "Tensor", trust: str) -> None:
    from omnivat.figures import map_figure, pictures, write
    from omnivat.kit.stages import STAGE_TITLES
    from omnivat.maps.thumbnails import sheet_of

    header, domain = features.embeddings.header, features.embeddings.domain
    classes = [header.classes[k] for k in features.embeddings.label]
    figure = map_figure(
        flat.cpu().numpy(),
        domain,
        header.domains,
        title=f"{STAGE_TITLES[options.stage]}: {options.method}",
        caption=". ".join(part for part in (features.about, trust) if part),
        hover=[f"{header.domains[d]} · {c}" for d, c in zip(domain, classes, strict=True)],
        pictures=None if options.sample else pictures(sheet_of(options.embeddings)),
    )
    write(options.figure, figure)


def faithfulness(quality: "Quality") -> str:
    """Return a line with the faithfulness of a map, with intervals if rows were sampled."""
    drawn = quality.trustworthiness_error > 0
    trust, recall = (
        f"{value:.4f}" + (f" ± {error:.4f}" if drawn else "")
        for value, error in (
            (quality.trustworthiness, quality.trustworthiness_error),
            (quality.recall, quality.recall_error),
        )
    )
    of = f", from {quality.rows:,} points drawn at random" if drawn else ""
    return (
        f"trustworthiness {trust}, recall {recall} at {NEIGHBOURS} neighbours (1 is a faithful"
        f" map){of}"
    )


def _rows(features: StageFeatures, flat: "Tensor") -> Iterator[list[str]]:
    """Yield one row for each point: all VIS, then all TAC, in the order of the pairs."""
    embeddings = features.embeddings
    header, count = embeddings.header, len(embeddings)
    for point, place in enumerate(flat):
        modality, pair = ("vis", "tac")[point // count], point % count
        yield [
            *(f"{x:.6g}" for x in place.tolist()),
            modality,
            header.domains[int(embeddings.domain[pair])],
            header.classes[int(embeddings.label[pair])],
            str(pair),
            embeddings.rows[modality][pair],
        ]
