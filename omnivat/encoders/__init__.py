"""Image encoders with one small contract, listed by name and loaded on first use."""

from typing import Any

from omnivat.encoders.base import DEFAULT_ENCODER, ENCODERS, Encoder, load_encoder, text_encoder

__all__ = [
    "DEFAULT_ENCODER",
    "ENCODERS",
    "Encoder",
    "PairEncoder",
    "TorchEncoder",
    "load_encoder",
    "text_encoder",
]

_LATE = {
    "TorchEncoder": "omnivat.encoders.wrapping:TorchEncoder",
    "PairEncoder": "omnivat.encoders.paired:PairEncoder",
}


def __getattr__(name: str) -> Any:
    if name not in _LATE:
        raise AttributeError(f"module 'omnivat.encoders' has no attribute {name!r}")
    from omnivat.tables import load

    return load(_LATE, name, kind="name of omnivat.encoders")
