"""What a report states in words: what the set cannot show, and one paragraph of methods for a
paper.
"""

import platform

import numpy as np
import torch

from omnivat import __version__
from omnivat.data.foreign import PREFIX
from omnivat.measure import rungs
from omnivat.study.shift.measure import BLOCKS, DRAWS, LEAST, MOST_DOMAINS, NEAR
from omnivat.study.shift.probe import FOLDS
from omnivat.study.shift.reading import Features

VIEWS = {"vis": "photos", "tac": "touches", "both": "both", "": "photo to touch"}
NEIGHBOURS = 15  # of the trust in a map


def notes(features: Features) -> list[str]:
    """Return what the set cannot show, one sentence each."""
    words = []
    if len(features.domains) < 2:
        words.append("One domain: there is no gap between domains, and no probe meets another one.")
    if len(features.modalities) < 2:
        view = VIEWS[features.modalities[0]]
        words.append(f"One modality ({view}): there is no gap between modalities and no retrieval.")
    if not features.labelled:
        words.append("No classes: probes and mAP are left out.")
    sizes = {name: len(features.members(name)) for name in features.domains}
    if few := [name for name, size in sizes.items() if size < LEAST]:
        words.append(f"Fewer than {LEAST} pairs, so no gap and no probe: {', '.join(few)}.")
    if len(sizes) - len(few) > MOST_DOMAINS:
        words.append(f"Gaps are of the {MOST_DOMAINS} largest domains.")
    if len(features.embeddings) < features.drawn_of:
        words.append(
            f"{len(features.embeddings):,} of {features.drawn_of:,} pairs were drawn at random."
        )
    return words


def methods(features: Features, seed: int) -> str:
    """Return one paragraph for a paper: what was measured, how, and with which versions.

    What the set has no part of (other domains, another modality, classes) is not named.
    """
    two, labelled = len(features.modalities) == 2, features.labelled
    members = [len(features.members(name)) for name in features.domains]
    large = sum(size >= LEAST for size in members)
    parts = [_made(features)]
    between = ["modalities"] * (two and large > 0) + ["domains"] * (large > 1)
    if between:
        parts.append(
            f"The gap between {' and between '.join(between)} was measured as the distance of"
            " centroids, the squared maximum mean discrepancy (MMD; linear and Gaussian kernels,"
            " biased; Gretton et al., 2012), the squared Fréchet distance (Dowson and Landau, 1982)"
            " and the Proxy-A distance of a ridge classifier in five folds (Ben-David et al.,"
            f" 2007). Their intervals are a jackknife over {BLOCKS} blocks of objects with"
            " Student's t; as the level of no gap, each was also measured between two random halves"
            " of one domain, since finite samples raise all but Proxy-A, which is cross-validated."
        )
    if two and max(members) > 1:
        parts.append(
            "In retrieval, each photo ranks the touches of its domain by cosine, and each touch the"
            " photos."
        )
    if len(members) > 1:
        parts.append(
            f"Neighbours across domains are the {NEAR} nearest rows of other objects by cosine."
        )
    if labelled and large:
        parts.append(
            "A probe is three linear maps, of photo, touch and both, averaged, on rows"
            f" standardised by the profile of one domain; its accuracy at home is that of {FOLDS}"
            " folds of objects. Where the largest class has at least 1.5 times the mean size,"
            " balanced accuracy (the mean over classes) and the share of that class are given, too."
        )
        if large > 1:
            parts.append(
                "A profile moves the mean and deviation of each channel of the target to the"
                f" source's, from {rungs.FEW} pictures of the target without labels (half of a"
                f" small domain) that are not tested: the mean of {rungs.DRAWS} draws."
            )
    drawn = "objects, of domains for probes" if labelled and large > 2 else "objects"
    parts.append(f"Other intervals are 95 % percentiles of {DRAWS:,} bootstrap draws of {drawn}.")
    parts.append(
        f"Maps are PCA and UMAP (McInnes et al., 2018; {NEIGHBOURS} exact neighbours, seed {seed});"
        f" trustworthiness and recall compare {NEIGHBOURS} neighbours on the map and in the"
        f" features. omnivat {__version__}, torch {torch.__version__}, numpy {np.__version__},"
        f" Python {platform.python_version()}."
    )
    return " ".join(parts)


def _made(features: Features) -> str:
    data = features.embeddings
    sizes = ", ".join(f"{name} {len(features.members(name))}" for name in features.domains)
    objects = int(features.embeddings.objects.max()) + 1
    of = "each an object" if objects == len(data) else f"of {objects} objects"
    made = (
        f"Features of {data.header.encoder.removeprefix(PREFIX)} ({data.width} values) of"
        f" {len(data)} pairs, {of} ({sizes}), were scaled to unit length."
    )
    if data.header.simulated:
        made += " The pairs are simulated."
    if len(data) < features.drawn_of:
        made += f" They are a random part of {features.drawn_of:,} pairs."
    return made
