"""The map's frames: an existing file, or one computed in the background, coarse first."""

import logging
from dataclasses import dataclass
from pathlib import Path
from threading import Lock
from time import monotonic
from typing import TYPE_CHECKING, Any

from app.shared.jobs import Job
from app.shared.limits import LARGE_SET
from omnivat.head.heads import SET
from omnivat.kit.errors import DataError, WriteError
from omnivat.kit.files import cache_folder, hash_of
from omnivat.kit.progress import Step
from omnivat.kit.stages import IMAGES, STOPS

if TYPE_CHECKING:
    from collections.abc import Mapping

    from omnivat.data.store import Embeddings
    from omnivat.head.checkpoint import Head

log = logging.getLogger(__name__)
COARSE = STOPS[::10]
RECIPE = 3  # version of the maps; those of other versions are computed again
FIRST_LOOK, LAST_TOUCH = 0, 2  # priorities; training is between them
LOADING = Step(done=0, total=0, text="loading the head")
RETRY_S = 5.0  # seconds after which a failed map is tried again
ENDED = ("failed", "cancelled")


@dataclass(frozen=True, slots=True, kw_only=True)
class FramesState:
    """The current file (`file`), the step in progress (`step`), or the reason of a failure."""

    file: Path | None = None
    step: Step | None = None
    problem: str = ""


def cache_name(head: Path, embeddings: Path, drawn: int, *beside: Path) -> str:
    """Return a hash of all files and of `drawn`, as `Places` has it. Raises DataError if a file
    is missing.
    """
    from omnivat.maps.frames.file import VERSION

    files = (head / "weights.safetensors", head / "settings.json", embeddings, *beside)
    for file in files:
        if not file.is_file():
            raise DataError(
                f"'{file}' is missing, so there is no map. Train a head with `python -m omnivat "
                "train` and make embeddings with `python -m omnivat embed`."
            )
    return hash_of(*files, start=f"frames {VERSION}, recipe {RECIPE}, {drawn}")[:24]


class FramesJob:
    """The frames of one of the heads and its set, computed as a job if there is no file.

    resources  their `app.shared.resources.Resources`, which makes the job
    name       of the head, "" for the first one: its set may be of another encoder, and then the
               features alone are drawn
    """

    def __init__(self, resources: Any, name: str) -> None:
        self._of, self._name = resources, name
        self._file: Path | None = None if name else resources.where.frames
        self._lock = Lock()
        self._job: Job[None] | None = None

    def state(self) -> FramesState:
        """Return the state; the first call starts the work if needed."""
        with self._lock:
            if self._wanted():
                self._job = self._of.shared.jobs.start(
                    self._compute, lane="long", owner=self._of.owner, priority=FIRST_LOOK
                )
            job = self._job
        if job is None or job.state == "done":  # the file is read after that, so it is the last
            return FramesState(file=self._file)
        if job.state in ENDED:
            return FramesState(file=self._file, problem="" if self._file else job.problem)
        if place := job.place:
            text = f"waiting: number {place} in the queue"
            return FramesState(file=self._file, step=Step(done=0, total=0, text=text))
        return FramesState(file=self._file, step=job.step or LOADING)

    def wait(self) -> FramesState:
        """Wait for the work to end; return the state."""
        self.state()
        if self._job is not None:
            self._job.future.exception()
        return self.state()

    def _wanted(self) -> bool:
        """True if work must start: the first time, and some time after a failure."""
        job = self._job
        if job is None:
            return self._file is None
        return job.state in ENDED and monotonic() - job.since > RETRY_S

    def _compute(self, job: Job[None]) -> None:
        """Find or build the frames' file, coarse maps first; finer files replace it as they are
        done.
        """
        from omnivat.maps.frames.builder import DEFAULT_MAPS

        where = self._of.where
        folder = where.computed or cache_folder() / "frames"
        names = self._of.folders[self._name], where.embeddings, where.drawn
        name = cache_name(*names, *self._beside())
        fine, coarse, first = (folder / f"{name}{kind}.bin" for kind in ("", "-coarse", "-first"))
        if readable(fine):
            self._file = fine
        else:
            job.report(LOADING)
            head, embeddings = self._read()
            passes = [(coarse, COARSE, DEFAULT_MAPS)] if head else []
            passes.append((fine, STOPS, DEFAULT_MAPS))
            if len(embeddings) > LARGE_SET and not readable(coarse):
                linear = {n: k for n, k in DEFAULT_MAPS.items() if n.startswith("pca/")}
                stops = first_stops(head.model.order) if head else COARSE
                passes.insert(0, (first, stops, linear))
            for file, orders, maps in passes:
                there = readable(file)
                self._file = (
                    file if there else self._build(job, head, embeddings, orders, maps, file)
                )
                job.priority = LAST_TOUCH
                job.check()

    def _beside(self) -> list[Path]:
        """Return the set beside a compared head, as `omnivat try` writes it, if there is one."""
        file = self._of.folders[self._name].parent / SET
        return [file] if self._name and file.is_file() else []

    def _read(self) -> "tuple[Head | None, Embeddings]":
        """Return head and pairs: no head if the first one is of another encoder than the set; of a
        compared head of another encoder, the same pairs from the set beside it.
        """
        pairs: Embeddings = self._of.embeddings()
        head: Head = self._of.heads[self._name]()
        try:
            head.require_embeddings(pairs)
        except DataError:
            if not self._name:
                return None, pairs
            if not (beside := self._beside()):
                raise
            from omnivat.data.store import load_embeddings
            from omnivat.study.comparison.matching import matched
            from omnivat.study.shift.reading import Features

            sets = {"the page's set": pairs, self._name: load_embeddings(beside[0])}
            both = {
                name: Features(
                    embeddings=embeddings,
                    modalities=IMAGES,
                    labelled=True,
                    drawn_of=len(embeddings),
                )
                for name, embeddings in sets.items()
            }
            pairs = matched(both)[self._name].embeddings
            head.require_embeddings(pairs)
        return head, pairs

    def _build(
        self,
        job: Job[None],
        head: "Head | None",
        embeddings: "Embeddings",
        orders: tuple[float, ...],
        maps: "Mapping[str, int]",
        to: Path,
    ) -> Path:
        """Compute the frames of some stops and write them to `to` or, if it cannot be written, to
        the server's temporary folder. Return the file.
        """
        from omnivat.head.checkpoint import head_hash
        from omnivat.maps.frames import build_frames, write_frames
        from omnivat.maps.frames.records import kind_of, with_learned

        provenance = head and {
            "hash": head_hash(self._of.folders[self._name]),
            "source": head.source,
            "kind": kind_of(head),
        }
        frames = build_frames(
            head.model if head else None,
            embeddings,
            orders=with_learned(orders, head.model.order if head else None),
            maps=maps,
            provenance=provenance,
            on_step=job.report,
        )
        job.check()
        try:
            write_frames(to, frames)
        except WriteError as error:
            log.warning("%s The map is kept until the server stops.", error)
            to = self._of.shared.scratch.folder("maps") / to.name
            write_frames(to, frames)
        return to


def first_stops(learned: float) -> tuple[float, ...]:
    """Return the first stops of a large set: the learned p and one end.

    >>> first_stops(0.498), first_stops(0.0)
    ((0.0, 0.498), (0.0, 1.0))
    """
    return (0.0, learned) if learned > 0.05 else (learned, 1.0)


def readable(file: Path) -> bool:
    """True if a file holds frames; a damaged one is removed, so that it is computed again."""
    if not file.is_file():
        return False
    from omnivat.maps.frames import read_frames

    try:
        read_frames(file)
    except DataError as error:
        log.warning("%s", error)
        file.unlink(missing_ok=True)
        return False
    return True
