"""Pictures and words to vectors: frozen encoders behind one small contract, loaded on first use.

Imports `data` and `kit`. A new encoder is a function in any module, named as
`module:function`, or a line in the table of `base`; nothing here is trained.
"""

from omnivat.encoders.base import DEFAULT_ENCODER, ENCODERS, Encoder, PairEncoder, load_encoder
from omnivat.kit.tables import late

__all__ = [
    "DEFAULT_ENCODER",
    "ENCODERS",
    "Encoder",
    "PairEncoder",
    "TorchEncoder",
    "load_encoder",
    "text_encoder",
]

LATE = {
    "TorchEncoder": "omnivat.encoders.wrapping:TorchEncoder",
    "text_encoder": "omnivat.encoders.clip_text:text_encoder",
}
__getattr__ = late(__name__, LATE)
