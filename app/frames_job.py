"""The map's frames: a file that is there, or one computed in the background, coarse first."""

import logging
import os
from dataclasses import dataclass
from hashlib import blake2b
from pathlib import Path
from threading import Condition, Lock, Thread
from typing import Any

from app.messages import UNEXPECTED
from omnivat.errors import DataError, OmniVatError
from omnivat.progress import Step

log = logging.getLogger(__name__)
COARSE = tuple(k / 10 for k in range(11))
FINE = tuple(k / 100 for k in range(101))


class Turns:
    """One map at a time, as two would only slow one another down; first looks go before last touches."""

    def __init__(self) -> None:
        self._changed = Condition()
        self._busy = False
        self._first_looks = 0  # that wait

    def take(self, *, first_look: bool) -> None:
        """Wait for one's turn."""
        with self._changed:
            self._first_looks += first_look
            self._changed.wait_for(lambda: not self._busy and (first_look or not self._first_looks))
            self._first_looks -= first_look
            self._busy = True

    def end(self) -> None:
        """Let the next one work."""
        with self._changed:
            self._busy = False
            self._changed.notify_all()

    def give_way(self) -> None:
        """In the middle of a last touch: let first looks that wait go before."""
        if self._first_looks:
            self.end()
            self.take(first_look=False)


TURNS = Turns()


@dataclass(frozen=True, slots=True, kw_only=True)
class FramesState:
    """What can be shown now (`file`), whether more is coming (`step`), or why nothing is."""

    file: Path | None = None
    step: Step | None = None
    problem: str = ""


def cache_folder() -> Path:
    """Return where computed frames are kept between runs."""
    base = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(base) / "omnivat" / "frames"


def cache_name(head: Path, embeddings: Path) -> str:
    """Return a name made from the content of both, so that neither can change unseen.

    Raises DataError when a file is missing.
    """
    digest = blake2b(digest_size=12)
    for file in (head / "weights.safetensors", head / "settings.json", embeddings):
        if not file.is_file():
            raise DataError(
                f"'{file}' is missing, so there is no map. Train a head with `python -m omnivat "
                "train` and make embeddings with `python -m omnivat embed`."
            )
        with file.open("rb") as handle:
            while block := handle.read(1 << 20):
                digest.update(block)
    return digest.hexdigest()


class FramesJob:
    """Gives the frames, computing them in one background thread where no file holds them."""

    def __init__(
        self, head: Path, embeddings: Path, ready: Path | None, folder: Path | None = None
    ) -> None:
        self._head, self._embeddings = head, embeddings
        self._folder = folder
        self._state = FramesState(file=ready)
        self._lock = Lock()
        self._thread: Thread | None = None

    def state(self) -> FramesState:
        """Return what there is; the first call starts the work where work is needed."""
        with self._lock:
            if self._state.file is None and self._thread is None:
                self._thread = Thread(target=self._run, name="frames", daemon=True)
                self._state = FramesState(step=Step(done=0, total=0, text="loading the head"))
                self._thread.start()
            return self._state

    def wait(self) -> FramesState:
        """Return the state once the work has ended."""
        self.state()
        if self._thread is not None:
            self._thread.join()
        return self._state

    def _run(self) -> None:
        try:
            self._compute()
        except OmniVatError as error:
            log.warning("no frames: %s", error)
            self._state = FramesState(problem=str(error))
        except (ArithmeticError, RuntimeError, OSError, MemoryError):
            log.exception("no frames")
            self._state = FramesState(problem=UNEXPECTED)

    def _compute(self) -> None:
        folder = self._folder or cache_folder()
        name = cache_name(self._head, self._embeddings)
        fine = folder / f"{name}.bin"
        if fine.is_file():
            self._state = FramesState(file=fine)
            return
        from omnivat.checkpoint import load_head
        from omnivat.data.store import load_embeddings

        head, embeddings = load_head(self._head), load_embeddings(self._embeddings)
        head.require_embeddings(embeddings)
        coarse = folder / f"{name}-coarse.bin"
        self._state = FramesState(step=Step(done=0, total=0, text="waiting for another map"))
        for orders, file, shown in ((COARSE, coarse, None), (FINE, fine, coarse)):
            TURNS.take(first_look=shown is None)
            try:
                self._build(head, embeddings, orders, file, shown=shown)
            finally:
                TURNS.end()
        self._state = FramesState(file=fine)

    def _build(
        self, head: Any, embeddings: Any, orders: tuple[float, ...], to: Path, shown: Path | None
    ) -> None:
        from omnivat.checkpoint import head_hash
        from omnivat.frames import build_frames, write_frames

        def report(step: Step) -> None:
            self._state = FramesState(file=shown, step=step)
            if shown is not None:
                TURNS.give_way()

        frames = build_frames(
            head.model,
            embeddings,
            orders=orders,
            provenance={"hash": head_hash(self._head), "source": head.source},
            on_step=report,
        )
        write_frames(to, frames)
