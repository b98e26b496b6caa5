"""Embed a set of pairs into one file, on this machine or on a cluster."""

from omnivat.encoders.cache import embed_image, embed_pair
from omnivat.encoders.embed.pairs import ENGINES, EmbedReport, embed_pairs

__all__ = ["ENGINES", "EmbedReport", "embed_image", "embed_pair", "embed_pairs"]
