"""Image encoders with one small contract, listed by name and loaded on first use."""

from omnivat.encoders.base import DEFAULT_ENCODER, ENCODERS, Encoder, PairEncoder, load_encoder, text_encoder
from omnivat.kit.tables import late

__all__ = ["DEFAULT_ENCODER", "ENCODERS", "Encoder", "PairEncoder", "TorchEncoder", "load_encoder", "text_encoder"]

__getattr__ = late(__name__, {"TorchEncoder": "omnivat.encoders.wrapping:TorchEncoder"})
