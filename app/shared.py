"""What all heads and sets of one server share: the runner of jobs, the decoder, the encoders."""

from functools import partial
from threading import Lock
from typing import TYPE_CHECKING

from app.decoder import Decoder
from app.jobs import Jobs
from app.once import Once
from app.scratch import Scratch

if TYPE_CHECKING:
    from omnivat.encoders.base import Encoder


class Shared:
    """Made once by the server; nothing heavy is loaded for it."""

    def __init__(self) -> None:
        self.jobs = Jobs()
        self.decoder = Decoder()
        self.scratch = Scratch()
        self._encoders: dict[str, Once[Encoder]] = {}
        self._lock = Lock()

    def encoder(self, name: str, weights_hash: str = "") -> "Encoder":
        """Return the encoder of that name and weights, loaded once for all who use it.

        Its weights are read where weights of that hash were read last; nothing is downloaded.
        """
        from omnivat.encoders.base import load_encoder

        load = partial(load_encoder, name, weights_hash=weights_hash, download="no")
        with self._lock:
            once = self._encoders.setdefault(f"{name} {weights_hash}", Once(load))
        return once()

    def close(self) -> None:
        """Stop all jobs and processes."""
        self.jobs.close()
        self.decoder.close()
