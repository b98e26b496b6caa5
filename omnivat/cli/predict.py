"""Predict the material of VIS + TAC pairs.

    python -m omnivat predict VIS TAC [VIS TAC ...] [--head DIR] [--order P] [--json]

Write "-" for a missing VIS or TAC. Of --pairs, pairs with an unreadable image are named on stderr
and left out.
"""

import argparse
import json
import sys
from pathlib import Path
from typing import Any

from omnivat.cli.arguments import add_head, add_json, add_order
from omnivat.cli.computing import add_device, add_download
from omnivat.errors import DataError, SettingsError

MISSING = "-"
WORDS = {"vis": "photo only", "tac": "touch only"}


def add(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument(
        "images",
        nargs="*",
        metavar="VIS TAC",
        help="a photo and a tactile image, once or many times; '-' for one that is missing",
    )
    parser.add_argument("--pairs", help="a folder or CSV of pairs, instead of single images")
    add_head(parser)
    add_order(parser)
    parser.add_argument("--weights", type=Path, help="checkpoint of the encoder")
    parser.add_argument(
        "--tac-weights", type=Path, help="checkpoint of the encoder of tactile images, if another"
    )
    add_device(parser)
    add_download(parser)
    add_json(parser)
    parser.add_argument("--no-cache", action="store_true", help="encode anew")


def run(options: argparse.Namespace) -> None:
    """Load the head and its encoder, embed the pairs, print the predictions."""
    pairs = _pairs(options)
    import torch

    from omnivat.checkpoint import load_head
    from omnivat.devices import current, precise
    from omnivat.encoders import load_encoder
    from omnivat.encoders.cache import default_cache, embed_pair
    from omnivat.predict import predict_embeddings

    head = load_head(options.head, dtype=precise(current()))
    encoder = load_encoder(
        head.encoder["name"],
        weights=options.weights,
        tac_weights=options.tac_weights,
        device=options.device,
        download=options.download,
        weights_hash=head.encoder["weights_hash"],
    )
    head.require(
        (encoder.name, encoder.weights_hash, encoder.preprocessing),
        encoder.width,
        what="Embeddings of these images",
    )
    cache = None if options.no_cache else default_cache()
    predictions: list[dict[str, Any]] = []
    for vis, tac, crop in pairs:
        try:
            embedded = embed_pair(encoder, vis, tac, cache, tac_crop=crop)
        except DataError as error:
            if not options.pairs:
                raise
            print(f"skipped: {error}", file=sys.stderr)
            continue
        given = [None if e is None else torch.from_numpy(e[None].copy()) for e in embedded]
        predicted = predict_embeddings(head, *given, order=options.order)[0]
        predictions.append({"vis": vis and str(vis), "tac": tac and str(tac), **predicted})
    if not predictions:
        raise DataError(f"None of the {len(pairs)} pairs in '{options.pairs}' could be read.")
    context = {"head": str(options.head), "source": head.source, "encoder": encoder.name}
    if options.json:
        records = [predicted | context for predicted in predictions]
        value = records[0] if len(records) == 1 and not options.pairs else records
        json.dump(value, sys.stdout, indent=2, ensure_ascii=False)
        print()
    else:
        for predicted in predictions:
            print(_readable(predicted, head.source))


def _pairs(options: argparse.Namespace) -> list[tuple[Path | None, Path | None, int]]:
    """Return VIS, TAC and the side of the square crop of TAC, for each pair."""
    if options.pairs and options.images:
        raise SettingsError("Give either images or --pairs, not both.")
    if options.pairs:
        from omnivat.data.readers import read_pairs

        return [(pair.vis, pair.tac, pair.tac_crop) for pair in read_pairs(options.pairs).pairs]
    given = len(options.images)
    if not given or given % 2:
        raise SettingsError(
            f"Got {given} image{'' if given == 1 else 's'}; give VIS and TAC for each pair, with '-' for a "
            "missing one."
        )
    paths = [None if name == MISSING else Path(name) for name in options.images]
    return [(vis, tac, 0) for vis, tac in zip(paths[::2], paths[1::2], strict=True)]


def _readable(predicted: dict[str, Any], source: str) -> str:
    alone = {WORDS[name]: column for name, column in predicted["modalities"].items()}
    columns = {"both": predicted["probabilities"], **alone} if len(alone) > 1 else alone
    lines = [
        f"{predicted['vis'] or 'no VIS'} + {predicted['tac'] or 'no TAC'}: {predicted['prediction']}"
        f"  (order p = {predicted['order']:.3f}, head trained on {source})",
        "  " + f"{'class':>9} " + " ".join(f"{name:>10}" for name in columns),
    ]
    for name in predicted["probabilities"]:
        values = " ".join(f"{column[name]:10.3f}" for column in columns.values())
        lines.append(f"  {name:>9} {values}")
    for name, found in predicted["familiarity"].items():
        what = {"vis": "photo", "tac": "touch"}[name]
        lines.append(
            f"  {what}: {found['words']} (nearest training image: cosine {found['cosine']:.3f}, "
            f"quantile {found['quantile']:.2f} of the training images' own)"
        )
    return "\n".join(lines)
