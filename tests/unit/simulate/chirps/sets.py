"""A set of chirps in memory, without pictures."""

from pathlib import Path

from omnivat.data.embeddings import Embeddings, Header, indices
from omnivat.data.store import ROW_NAMES
from omnivat.simulate.chirps import CLASSES, DOMAINS, pairs_of, signals


def chirp_embeddings(settings):
    pairs = pairs_of(settings, Path())
    header = Header(
        encoder="strip", weights_hash="1", preprocessing="", domains=DOMAINS, classes=CLASSES
    )
    return Embeddings(
        header=header,
        **signals(settings),
        domain=indices(DOMAINS, [pair.domain for pair in pairs]),
        label=indices(CLASSES, [pair.material for pair in pairs]),
        rows={name: [str(getattr(pair, name)) for pair in pairs] for name in ROW_NAMES},
    )
