"""Score a fitted method on pairs, and keep every prediction so that tables can be recomputed.

`answers` has the predicted class of every pair, one character each, for every reading; `truth` and
`objects` have the same order, and so has `odds`: the log-odds of both images
(`omnivat.data.packing.odds`). A class is its index in the record's
`classes`, written 0 to 9, then a to z, then A to Z. Objects are numbered through the whole set.
"""

import math
from collections.abc import Mapping

import numpy as np
import torch

from omnivat.data.packing import DIGITS, compact, digits, odds
from omnivat.data.store import Embeddings
from omnivat.head.output import READINGS
from omnivat.head.predict_set import label_map
from omnivat.measure.gaps.calibration import aurc, ece, nll
from omnivat.measure.gaps.confusion import scores
from omnivat.measure.gaps.sums import cosine_margin
from omnivat.study.protocol.fitting import Outcome
from omnivat.study.protocol.records import Record


def score(
    outcome: Outcome, pairs: Embeddings, classes: tuple[str, ...], numbers: Mapping[str, int]
) -> Record:
    """Return counts, scores by reading, margins and every prediction.

    numbers  object -> its number (`object_numbers`)
    Pairs of classes that the method lacks are left out and counted.
    """
    labels = label_map(classes, pairs.header.classes)[pairs.label]
    known = np.flatnonzero(labels >= 0)
    record: Record = {"pairs": len(known), "left_out": len(labels) - len(known)}
    if not len(known):
        return record | {"scores": {}}
    pairs, truth = pairs.select(known), torch.from_numpy(labels[known])
    shares = outcome.probabilities(pairs)
    readings = {name: shares[name] for name in READINGS if name in shares}
    record["scores"] = {name: scores(truth, values.argmax(-1)) for name, values in readings.items()}
    record["scores"]["fused"] |= {
        n: float(m(shares["fused"], truth)) for n, m in CONFIDENCE.items()
    }
    margins = {
        name: float(cosine_margin(rows, truth)) for name, rows in outcome.features(pairs).items()
    }
    record["margins"] = {
        name: None if math.isnan(value) else value for name, value in margins.items()
    }
    if len(classes) <= len(DIGITS):
        record["truth"] = digits(truth.tolist())
        record["objects"] = compact([numbers[name] for name in named_objects(pairs)])
        record["answers"] = {name: digits(v.argmax(-1).tolist()) for name, v in readings.items()}
        record["odds"] = odds(shares["fused"].clamp_min(1e-12).log().numpy())
    return record


CONFIDENCE = {"ece": ece, "nll": nll, "aurc": aurc}


def named_objects(pairs: Embeddings) -> list[str]:
    """Return each pair's object with its domain; without an object, its file."""
    domains = pairs.header.domains
    files = zip(pairs.rows["object"], pairs.rows["vis"], pairs.rows["tac"], strict=True)
    return [
        f"{domains[int(domain)]}/{name or f'{vis}|{tac}'}"
        for domain, (name, vis, tac) in zip(pairs.domain, files, strict=True)
    ]


def object_numbers(embeddings: Embeddings) -> dict[str, int]:
    """Return a number for every object of a set, in order of first appearance."""
    return {name: i for i, name in enumerate(dict.fromkeys(named_objects(embeddings)))}
