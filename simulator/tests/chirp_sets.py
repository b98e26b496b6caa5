"""A set of chirps in memory, without pictures."""

from pathlib import Path

from omnivat.data.embeddings import indices
from omnivat.data.store import ROW_NAMES
from simulator.chirps import CLASSES, DOMAINS, pairs_of, signals
from tests.builders import embeddings_of


def chirp_embeddings(settings):
    pairs = pairs_of(settings, Path())
    return embeddings_of(
        **signals(settings),
        domain=indices(DOMAINS, [pair.domain for pair in pairs]),
        label=indices(CLASSES, [pair.material for pair in pairs]),
        domains=DOMAINS,
        classes=CLASSES,
        rows={name: [str(getattr(pair, name)) for pair in pairs] for name in ROW_NAMES},
    )
