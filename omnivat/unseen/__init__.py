"""Results of a head in unseen domains."""

from omnivat.tables import late
from omnivat.unseen.masks import counted

__all__ = ["counted", "unseen_summary"]
__getattr__ = late(__name__, {"unseen_summary": "omnivat.unseen.summary:unseen_summary"})  # imports torch
