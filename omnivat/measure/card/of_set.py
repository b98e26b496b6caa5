"""What differs between the sensors of a set's domains, from the pictures behind its embeddings."""

import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from omnivat.data.embeddings import Embeddings
from omnivat.data.images import read_bytes
from omnivat.data.relief.files import spread
from omnivat.data.rest import seen
from omnivat.encoders.hub import images_key, recall
from omnivat.kit.errors import DataError, printable
from omnivat.measure.card.card import SensorCard, card_of
from omnivat.measure.card.changes import changes_between
from omnivat.measure.card.traits import Array

TOUCHES = 25  # of each domain
MOST = 8  # domains that are compared
CLAUSE = re.compile(r"\. |\.$|: | \(")  # ends the first clause of an evidence


def differences(embeddings: Embeddings, source: str = "") -> list[str]:
    """Return a sentence for each domain whose sensor differs from that of `source`, by default the
    first domain with a card.

    [] where the pictures are not on this machine, or are no touches of a gel.
    """
    header = embeddings.header
    root = recall(images_key(header))
    if root is None or "tac" not in header.modalities or header.encoder == "strip":
        return []
    domains = sorted(header.domains, key=lambda name: name != source)[:MOST]
    cards: dict[str, SensorCard] = {}
    for name in domains if len(domains) > 1 else ():
        try:
            cards[name] = card_of(_touches(embeddings, name, root))
        except DataError:  # too few, or not there any more
            continue
    lines = []
    first = next(iter(cards), "")
    for name in [*cards][1:]:
        found = changes_between(cards[first], cards[name])
        clauses = [CLAUSE.split(change.evidence)[0] for change in found]
        words = "; ".join(clause[:1].lower() + clause[1:] for clause in clauses)
        if words:
            lines.append(
                f"{printable(name)} against {printable(first)}: {words}; the rest is as before."
            )
    return lines


def _touches(embeddings: Embeddings, domain: str, root: Path) -> Iterator[Array]:
    rows = spread(embeddings.rows_of(domain).tolist(), TOUCHES)
    crops = embeddings.rows.get("tac_crop")
    for row in rows:
        file = root / embeddings.rows["tac"][row]
        way = embeddings.header.tac_way.get(domain, "")
        crop = int(crops[row] or 0) if crops else 0
        yield np.asarray(seen(read_bytes(file), file.name, crop=crop, way=way))
