"""Predict the material of VIS + TAC pairs.

    python -m omnivat predict VIS TAC [VIS TAC ...] [--head DIR] [--order P] [--tac-rest FILE]
        [--profile FILE] [--json]

Without --head, the head for one's own pictures predicts; with --order, in which that head has no
part, the head of one domain. Write "-" for a missing VIS or TAC. Of --pairs, pairs with an
unreadable image are named on stderr and left out.
"""

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from omnivat.cli.arguments import as_json, declare, download, flag, passed, path, progress_bar, text
from omnivat.head.heads import default_head, own_head
from omnivat.kit.errors import DataError, SettingsError
from omnivat.kit.progress import Step

if TYPE_CHECKING:
    from omnivat.data.pairs import Pair

MISSING = "-"
WORDS = {"vis": "photo only", "tac": "touch only"}


def add(parser: argparse.ArgumentParser) -> None:
    words = "a photo and a tactile image, once or many times; '-' for one that is missing"
    parser.add_argument("images", nargs="*", metavar="VIS TAC", help=words)
    declare(
        parser,
        "head",
        "order",
        "tac_rest",
        "flip",
        "channels",
        "weights",
        "device",
        "json",
        pairs=text("a folder or CSV of pairs, instead of single images"),
        profile=path("profile of the sensor (`omnivat profile`)", "FILE"),
        tac_weights=path("checkpoint of the encoder of tactile images, if another"),
        no_cache=flag("encode anew"),
    )
    parser.set_defaults(head=None)
    download(parser)


def run(options: argparse.Namespace) -> None:
    """Load the head and its encoder, embed the pairs, print the predictions."""
    given = len(options.images)
    if options.pairs and given:
        raise SettingsError("Give either images or --pairs, not both.")
    if not options.pairs and (not given or given % 2):
        raise SettingsError(
            f"Got {given} image{'' if given == 1 else 's'}; give VIS and TAC for each pair, with"
            " '-' for a missing one."
        )
    import torch

    from omnivat.data.dots import dots_of
    from omnivat.data.profile_file import load_profile
    from omnivat.data.relief.files import reading_of, touch_of
    from omnivat.data.rest import RESTED
    from omnivat.encoders import load_encoder
    from omnivat.encoders.cache import default_cache, embed_pair
    from omnivat.head.checkpoint import load_head
    from omnivat.head.predict import predict_embeddings
    from omnivat.kit.devices import current, precise

    folder = options.head or (own_head() if options.order is None else default_head())
    head = load_head(folder, dtype=precise(current()))
    profile = load_profile(options.profile) if options.profile else None
    rested = head.encoder["preprocessing"].endswith(RESTED)
    way = profile.way if profile and not (options.flip or options.channels) else ""
    pairs = _pairs(options, _rest(options, rested), way)
    where = passed(options, "weights", "tac_weights", "device", "download")
    preprocessing, lamps = head.encoder["preprocessing"], profile.lamps if profile else None
    touch = touch_of(preprocessing)
    encoder = load_encoder(
        head.encoder["name"],
        **where,
        weights_hash=head.encoder["weights_hash"],
        dots=dots_of(preprocessing),
        touch=touch,
        lamps={"": lamps} if lamps else {},
    )
    head.require(
        (encoder.name, encoder.weights_hash, encoder.preprocessing + (RESTED if rested else "")),
        encoder.width,
        what="Embeddings of these images",
    )
    cache = None if options.no_cache else default_cache()
    predictions: list[dict[str, Any]] = []
    with progress_bar("predict") as show:
        for done, (vis, tac, crop, rest, way) in enumerate(pairs):
            show(Step(done=done, total=len(pairs)))
            try:
                embedded = embed_pair(
                    encoder, vis, tac, cache, tac_crop=crop, tac_rest=rest, tac_way=way
                )
            except DataError as error:
                if not options.pairs:
                    raise
                print(f"skipped: {error}", file=sys.stderr)
                continue
            rows = [None if e is None else torch.from_numpy(e[None].copy()) for e in embedded]
            predicted = predict_embeddings(head, *rows, order=options.order, profile=profile)[0]
            predictions.append({"vis": vis and str(vis), "tac": tac and str(tac), **predicted})
    if not predictions:
        raise DataError(f"None of the {len(pairs)} pairs in '{options.pairs}' could be read.")
    context = {"head": str(folder), "source": head.source, "encoder": encoder.name, "touch": touch}
    if touch != "colours":
        context["lamps"] = f"of {lamps.pictures} touches" if lamps else "of each touch alone"
    records = [predicted | context for predicted in predictions]
    if options.json:
        print(as_json(records[0] if len(records) == 1 and not options.pairs else records))
    else:
        print("\n".join(_readable(predicted, head.source) for predicted in records))
        if any(predicted["tac"] for predicted in records):
            unlit = touch != "colours" and profile and not lamps
            why = ", as the profile has none" if unlit else ""
            print(f"Touch was read {reading_of(touch, lamps, ' of the profile')}{why}.")


def _rest(options: argparse.Namespace, rested: bool) -> str:
    """Return --tac-rest for a head that was trained with no-contact pictures or without.

    Raises SettingsError if the two do not fit.
    """
    choice = options.tac_rest or ("none" if not rested else "auto" if options.pairs else "")
    if not rested and choice != "none":
        raise SettingsError(
            f"--tac-rest is '{choice}', and this head was trained on tactile images as they come;"
            " leave it out."
        )
    if not choice and any(name != MISSING for name in options.images[1::2]):
        raise SettingsError(
            "This head was trained on tactile images minus a no-contact picture; name the picture"
            " of your untouched sensor with --tac-rest FILE (none: predict without)."
        )
    return choice or "none"


def _pairs(
    options: argparse.Namespace, rest: str, of_profile: str
) -> list[tuple[Path | None, Path | None, int, Path | None, str]]:
    """Return VIS, TAC, the side of its square crop, its no-contact picture and arrangement, of
    pairs.

    of_profile  the arrangement that the sensor's profile records, where no option names another
    """
    from omnivat.data.arranged import ways_in, with_ways

    if options.pairs:
        from omnivat.data.readers import read_pairs
        from omnivat.data.rest import with_rest

        loaded = with_rest(read_pairs(options.pairs), rest)
        ways = ways_in(options.flip, options.channels, loaded.domains())
        if of_profile:
            ways = dict.fromkeys(loaded.domains(), of_profile)
        found = with_ways(loaded, ways).pairs

        def image(pair: "Pair", name: str) -> Path | None:
            return getattr(pair, name) if pair.alone in ("", name) else None

        return [
            (image(p, "vis"), image(p, "tac"), p.tac_crop, p.tac_rest, p.tac_way) for p in found
        ]
    paths = [None if name == MISSING else Path(name) for name in options.images]
    calm = None if rest == "none" else Path(rest)
    way = ways_in(options.flip, options.channels, [""]).get("", of_profile)
    return [(vis, tac, 0, calm, way) for vis, tac in zip(paths[::2], paths[1::2], strict=True)]


def _readable(predicted: dict[str, Any], source: str) -> str:
    """Return a prediction as lines of text."""
    alone = {WORDS[name]: column for name, column in predicted["modalities"].items()}
    columns = {"both": predicted["probabilities"], **alone} if len(alone) > 1 else alone
    lines = [
        (
            f"{predicted['vis'] or 'no VIS'} + {predicted['tac'] or 'no TAC'}:"
            f" {predicted['prediction']}  (order p = {predicted['order']:.3f}, head trained on"
            f" {source})"
        ),
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
