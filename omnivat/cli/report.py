"""Report the domain shift of any features, without a head: gaps, retrieval, neighbours, probes,
maps.

python -m omnivat report FEATURES --out DIR [--encoder NAME] [--column vis=THEIRS]
"""

import argparse
from pathlib import Path

from omnivat.cli.arguments import declare, progress_bar, text
from omnivat.cli.imports import add_foreign, foreign
from omnivat.kit.errors import SettingsError
from omnivat.kit.files import require_writable


def add(parser: argparse.ArgumentParser) -> None:
    words = (
        "embeddings .safetensors, or .npz, .parquet, .h5 or .csv as `omnivat import` reads them;"
        " one modality, one domain and no classes are accepted"
    )
    parser.add_argument("features", type=Path, metavar="FEATURES", help=words)
    add_foreign(parser)
    declare(
        parser,
        "target",
        encoder=text("name of the vectors' encoder", "NAME"),
        out="folder to write",
        seed="seed of maps and the random part of a large set; default: 0",
    )


def run(options: argparse.Namespace) -> None:
    """Read, measure, draw, write; print where the page is."""
    if options.out.is_file():
        raise SettingsError(f"--out is the file '{options.out}'; name a folder.")
    for name in ("report.html", "numbers.csv", "methods.txt", "figures/x.svg"):
        require_writable(options.out / name)
    from omnivat.measure.card.of_set import differences
    from omnivat.study.comparison import predicted_numbers, sentence
    from omnivat.study.shift import read_features, write_report
    from omnivat.study.shift.measure import record

    features = read_features(
        options.features,
        encoder=options.encoder,
        **foreign(options),
        numbers=tuple(filter(None, [options.target])),
        seed=options.seed,
    )
    measured = predicted_numbers(features, options.target) if options.target else []
    more = [
        record(
            options.target, result["title"], result["value"], low=result["low"], high=result["high"]
        )
        for result in measured
    ]
    with progress_bar("report") as show:
        files = write_report(features, options.out, seed=options.seed, more=more, on_step=show)
    what = " and ".join(features.modalities) + ("" if features.labelled else ", without classes")
    print(f"{len(features.embeddings)} pairs, domains: {', '.join(features.domains)}; {what}")
    if measured:
        print(sentence(options.target, measured))
    for line in differences(features.embeddings):
        print(line)
    print(f"{len(files)} files written; open {files[-1]}")
