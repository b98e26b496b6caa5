"""Results of a head in unseen domains."""

from omnivat.tables import late

_PUBLIC = {
    "counted": "omnivat.unseen.masks:counted",
    "unseen_domains": "omnivat.unseen.masks:unseen_domains",
    "unseen_summary": "omnivat.unseen.summary:unseen_summary",
}
__all__ = [*_PUBLIC]
__getattr__ = late(__name__, _PUBLIC)
