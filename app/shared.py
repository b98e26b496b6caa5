"""Shared by all heads and sets of a server: jobs, decoder, encoders."""

from functools import partial
from threading import Lock
from typing import TYPE_CHECKING

from app.decoder import Decoder
from app.jobs import Jobs
from app.lazy import Lazy
from app.scratch import Scratch

if TYPE_CHECKING:
    from omnivat.encoders.base import Encoder


class Shared:
    """Created once by the server, without loading anything heavy."""

    def __init__(self) -> None:
        self.jobs = Jobs()
        self.decoder = Decoder()
        self.scratch = Scratch()
        self._encoders: dict[str, Lazy[Encoder]] = {}
        self._lock = Lock()

    def encoder(self, name: str, weights_hash: str = "") -> "Encoder":
        """Return the encoder with that name and weights, loaded once for all.

        Its weights are read from their last known location; nothing is downloaded.
        """
        from omnivat.encoders.base import load_encoder

        load = partial(load_encoder, name, weights_hash=weights_hash, download="no")
        with self._lock:
            lazy = self._encoders.setdefault(f"{name} {weights_hash}", Lazy(load))
        return lazy()

    def close(self) -> None:
        """Stop all jobs and processes."""
        self.jobs.close()
        self.decoder.close()
