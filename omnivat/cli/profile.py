"""Profile a sensor from pictures without labels: the statistics of its embeddings.

python -m omnivat profile PICTURES-OR-EMBEDDINGS --out FILE [--domain NAME] [--vis DIR] [--tac DIR]
"""

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from omnivat.cli.arguments import DOTS, declare, download, one_of, passed, path, progress_bar, text
from omnivat.data.relief.files import TOUCH
from omnivat.kit.errors import SettingsError
from omnivat.kit.files import require_writable

if TYPE_CHECKING:
    from omnivat.data.profile import Profile

EMBEDDINGS = ".safetensors"


def add(parser: argparse.ArgumentParser) -> None:
    words = (
        "an embeddings file, a CSV, or a folder of pictures: pairs as for `embed`, or files"
        " named *_vis.* and *_tac.*, or folders named vis and tac"
    )
    parser.add_argument("pictures", nargs="?", type=Path, help=words)
    declare(
        parser,
        "out",
        "weights",
        "tac_rest",
        "flip",
        "channels",
        "device",
        encoder="image encoder, named as for `embed`",
        vis=path("a folder of photos alone", "DIR"),
        tac=path("a folder of tactile images alone", "DIR"),
        domain=text("name of the domain; of a set: the one to take"),
        dots=one_of(DOTS, "printed dots of a gel in tactile images, as for `embed`"),
        touch=one_of(TOUCH, "read touch in its colours, as its relief, or both, as for `embed`"),
    )
    download(parser)


def run(options: argparse.Namespace) -> None:
    """Read the embeddings or embed the pictures, write the profile, print what it holds."""
    require_writable(options.out, EMBEDDINGS)
    from omnivat.data.profile import profile_of
    from omnivat.data.profile_file import save_profile
    from omnivat.data.store import load_embeddings

    named = [place for place in (options.pictures, options.vis, options.tac) if place]
    if not named or (options.pictures and len(named) > 1):
        raise SettingsError("Give PICTURES, or --vis and --tac: one of the two, or both.")
    if options.pictures and options.pictures.suffix.lower() == EMBEDDINGS:
        embeddings = load_embeddings(options.pictures)
        domains = embeddings.header.domains
        if not options.domain and len(domains) > 1:
            raise SettingsError(
                f"The set has {len(domains)} domains; name one: --domain {domains[0]!r}."
            )
        name = options.domain or domains[0]
        profile = profile_of(embeddings, embeddings.rows_of(name), domain=name)
    else:
        profile = _of_pictures(options)
    save_profile(options.out, profile)
    words = {"vis": "photos", "tac": "tactile images"}
    counts = " and ".join(f"{count:,} {words[name]}" for name, count in profile.counts.items())
    lamps = (
        profile.lamps
        and f", with the lamps of the gel (confidence {profile.lamps.confidence:.2f}), by which a"
        " head of relief, or of colours and relief, reads touch"
    )
    print(f"profile of {counts}{lamps or ''}, no labels read; written to {options.out}")


def _of_pictures(options: argparse.Namespace) -> "Profile":
    from dataclasses import replace

    from omnivat.data.arranged import ways_in
    from omnivat.encoders import load_encoder
    from omnivat.head.profile_pictures import pictures_in, profile_of_pictures

    found = pictures_in(options.pictures, vis=options.vis, tac=options.tac, rest=options.tac_rest)
    way = ways_in(options.flip, options.channels, [""]).get("", "")
    if way:
        found = [
            replace(picture, way=way) if picture.modality == "tac" else picture for picture in found
        ]
    encoder = load_encoder(
        options.encoder, **passed(options, "weights", "device", "download", "dots", "touch")
    )
    with progress_bar(f"embed with {encoder.name}") as show:
        profile, skipped = profile_of_pictures(encoder, found, domain=options.domain, on_step=show)
    for missing in skipped:
        print(f"skipped {missing.what}: {missing.why}", file=sys.stderr)
    return replace(profile, way=way)
