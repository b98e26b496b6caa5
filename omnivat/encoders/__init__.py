"""Image encoders behind one small contract, listed by name and loaded when asked for."""

from omnivat.encoders.base import DEFAULT_ENCODER, ENCODERS, Encoder, load_encoder, text_encoder

__all__ = ["DEFAULT_ENCODER", "ENCODERS", "Encoder", "load_encoder", "text_encoder"]
