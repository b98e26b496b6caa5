"""Chirps: synthetic pairs whose class shows at one fractional order only."""

from omnivat.simulate.chirps.settings import ChirpSettings
from omnivat.simulate.chirps.signals import chirp_embeddings, interference_orders

__all__ = ["ChirpSettings", "chirp_embeddings", "interference_orders"]
