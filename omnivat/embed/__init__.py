"""Embed a set of pairs into one file, on this machine or on a cluster."""

from omnivat.embed.pairs import ENGINES, EmbedReport, embed_pairs
from omnivat.encoders.cache import embed_image, embed_pair

__all__ = ["ENGINES", "EmbedReport", "embed_image", "embed_pair", "embed_pairs"]
