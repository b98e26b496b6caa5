"""Heads, sets and encoders of the page; each is loaded on first use.

The first page needs none of them: the browser fetches frames and thumbnails as files.
"""

import logging
from collections.abc import Callable, Collection, Iterable
from functools import partial
from pathlib import Path
from threading import Lock
from typing import TYPE_CHECKING, Any

from app.shared.decoder import Decoder, Picture
from app.shared.frames_job import FramesJob
from app.shared.jobs import Jobs
from app.shared.limits import MAPPED_BYTES
from app.shared.mend import mended
from app.shared.places import Places, example_name, find_examples, head_names
from app.shared.real import RealPairs
from app.shared.scratch import Scratch
from app.shared.state import Lazy, Recent, Ref, Reply, content_name
from omnivat.head.heads import OWN
from omnivat.kit.errors import DataError
from omnivat.kit.stages import IMAGES

if TYPE_CHECKING:
    import numpy as np
    from PIL.Image import Image

    from omnivat.data.profile import Profile
    from omnivat.data.relief import Lamps
    from omnivat.data.store import Embeddings
    from omnivat.encoders.base import Encoder
    from omnivat.head.calibration import Familiarity
    from omnivat.head.checkpoint import Head
    from omnivat.head.head import PairCoefficients
    from omnivat.maps.frames import FrameSet
    from omnivat.maps.journey import MapStop

    Array = np.ndarray[Any, Any]

log = logging.getLogger(__name__)
KEPT_EXAMPLES = 100  # embeddings of examples that are not in the set
KEPT_TAUGHT = 8  # they share all weights except the classifier
KEPT_PROFILES = 200  # 20 kB each
MAPS_BYTES = 32_000_000  # of the features at all stops of the last maps; the newest may be above
KEPT_FEATURES = 6  # the whole set at one stage and order; some MB each


class Shared:
    """Shared by all heads and sets of a server: jobs, decoder, encoders. Making it loads nothing
    heavy.
    """

    def __init__(self) -> None:
        self.jobs, self.decoder, self.scratch = Jobs(), Decoder(), Scratch()
        self.real = RealPairs(Path())
        # frames of a map, and what places pairs at their stops
        self.drawn_frames: Recent[tuple[FrameSet, Callable[[], Iterable[MapStop]]]] = Recent(
            2, room=MAPS_BYTES
        )
        self._encoders: dict[str, Lazy[Encoder]] = {}
        self._lock = Lock()

    def encoder(
        self, name: str, weights_hash: str = "", dots: str = "keep", touch: str = "colours"
    ) -> "Encoder":
        """Return the encoder with that name and weights, loaded once for all; `dots` and `touch`
        as in `load_encoder`. A relief is drawn from each touch by itself.

        Its weights are read from their last known location; nothing is downloaded.
        """
        from omnivat.encoders.base import load_encoder

        made = partial(load_encoder, name, weights_hash=weights_hash, download="no")
        load = partial(made, dots=dots, touch=touch)
        with self._lock:
            lazy = self._encoders.setdefault(f"{name} {weights_hash} {dots} {touch}", Lazy(load))
        return lazy()

    def close(self) -> None:
        """Stop all jobs and processes."""
        self.jobs.close()
        self.decoder.close()


class Resources:
    """The loaded parts, shared by all visitors; it holds no data of single visitors."""

    def __init__(self, where: Places, shared: Shared | None = None, owner: str = "") -> None:
        self.where = where
        self.shared = shared or Shared()
        self.owner = owner  # owner of the jobs of this head and set
        self.folders = head_names(where)
        self.heads: dict[str, Lazy[Head]] = {
            name: Lazy(partial(_load_head, folder)) for name, folder in self.folders.items()
        }
        if where.own:
            self.heads[OWN] = Lazy(partial(_load_head, where.own))
        self.head = self.heads[""]
        self.embeddings: Lazy[Embeddings] = Lazy(partial(_load_embeddings, where))
        self.drawn: Lazy[bool] = Lazy(lambda: _pairs_in(where.embeddings) > where.drawn)
        self.encoder: Lazy[Encoder] = Lazy(self._load_encoder)
        self.examples: Lazy[dict[str, dict[str, Path]]] = Lazy(
            lambda: find_examples(where.pairs) if where.pairs else {}
        )
        self.frame_jobs = {name: FramesJob(self, name) for name in self.folders}
        self.frames = self.frame_jobs[""]
        self.features: Recent[Array] = Recent(KEPT_FEATURES)  # by stage and order
        self.results: Recent[Reply] = Recent(KEPT_FEATURES)  # by method or tree
        self.mode_heads: Recent[Head] = Recent(1)  # beside frames of their own
        # from visitors' labelled pairs, and of their sensors
        self.taught: Recent[tuple[Head, Familiarity | None]] = Recent(KEPT_TAUGHT, private=True)
        self.profiles: Recent[Profile] = Recent(KEPT_PROFILES, private=True)
        self.coefficients: Lazy[PairCoefficients] = Lazy(self._coefficients)
        self.example_rows: Lazy[dict[str, int]] = Lazy(self._example_rows)
        self._examples: Recent[Ref] = Recent(KEPT_EXAMPLES)  # read as any picture
        self.encoder_key: Lazy[str] = Lazy(
            lambda: content_name(repr(sorted(self.head().encoder.items())).encode())[:8]
        )

    @property
    def holds(self) -> str:
        """A hash of the head and set; other or newer files have another one."""
        files = [self.where.embeddings, *(f / "weights.safetensors" for f in self.folders.values())]
        return content_name(repr([state_of(file) for file in files]).encode())

    @property
    def touch(self) -> str:
        """How the head reads touches, a word of `omnivat.data.relief.files.TOUCH`."""
        from omnivat.data.relief.files import touch_of

        return touch_of(self.head().encoder["preprocessing"])

    @property
    def sheet(self) -> Path | None:
        """The set's sheet of thumbnails; None if it has none, or its pairs are in another order."""
        return None if self.drawn() else self.where.sheet

    def warm(self) -> None:
        """Load the head and the set, so that the first request is fast."""
        for part in (self.head, self.embeddings):
            try:
                part()
            except DataError as error:  # the page shows the error where it matters
                log.warning("%s", error)

    def head_named(self, name: Any) -> "Head":
        """Return the head named in a request, "" for the first one. Raises DataError if the page
        cannot use it.
        """
        require_name(name, self.heads)
        head = self.heads[name or ""]()
        if name and self.head().encoder != head.encoder:
            raise DataError(
                f"The head '{name}' was trained with another encoder than the first one; compare"
                " heads of one encoder."
            )
        return head

    def embedding(self, ref: Ref, modality: str, mend: str = "") -> "Array":
        """Return the embedding (input_width,) of an image of the modality "vis" or "tac"; the touch
        of an example that is not in the set is read as `mend` has it.

        Raises DataError if there is no such image.
        """
        import numpy as np

        row = self.row_of(ref)
        if row is not None:
            return self._from_set(row, modality)
        if ref.kind == "example":
            file = self.example(ref.name, modality)
            ref = self._examples.once(
                f"{file} {mend}", lambda: self.take_image(file, ref.name, mend)[0]
            )
        content, width = ref.numbers(self.encoder_key()), self.head().settings.input_width
        if len(content) not in (4 * width, 8 * width):
            raise DataError("The numbers of an image are cut short; choose its file again.")
        rows = np.frombuffer(content, np.float32).reshape(-1, width)
        if not np.isfinite(rows).all():
            raise DataError("The numbers of an image are not finite; choose its file again.")
        own: Array = rows[-1 if modality == "tac" else 0].copy()
        return own

    def row_of(self, ref: Ref) -> int | None:
        """Return the row of the set that an image is of; None if it is of none. Raises DataError
        for a number that no row has.
        """
        if ref.kind != "row":
            return self.example_rows().get(ref.name) if ref.kind == "example" else None
        count = len(self.embeddings())
        if not ref.name.isascii() or not ref.name.isdigit() or int(ref.name) >= count:
            raise DataError(f"No pair has the number '{ref.name:.20}'; there are 0 to {count - 1}.")
        return int(ref.name)

    def take_image(
        self, source: bytes | Path, name: str, mend: str = "", lamps: "Lamps | None" = None
    ) -> tuple[Ref, Picture]:
        """Embed an image from bytes or a file; return its embeddings and the decoded picture, as
        `Decoder.read` does. As a touch it is mended (`app.shared.mend`), and read under `lamps`.
        """
        found = self.shared.decoder.read(source, name)
        rows = self._embedded(found, mend, lamps)
        return Ref.of_numbers(self.encoder_key(), b"".join(row.tobytes() for row in rows)), found

    def reader(self, modality: str, lamps: "Lamps | None" = None) -> "Encoder":
        """Return the encoder of photos or touches, "vis" or "tac"; where the head reads the relief
        of touches, under the lamps of their sensor, or by those that each gives alone.
        """
        from omnivat.encoders.base import ReliefDrawn, for_modality

        encoder = self.encoder()
        if lamps and isinstance(encoder, ReliefDrawn):
            encoder = ReliefDrawn(encoder, {"": lamps}, encoder.touch)
        return for_modality(encoder, modality)

    def _embedded(self, picture: Picture, mend: str, lamps: "Lamps | None" = None) -> "list[Array]":
        """Return an image's vectors as photo and as touch; only one if they are the same."""
        import numpy as np

        from omnivat.encoders.wrapping import WithoutDots

        encoder = self.encoder()
        photo, touch = (self.reader(name, lamps) for name in IMAGES)

        def read(by: "Encoder", image: "Image") -> "Array":
            row: Array = by.embed(by.preprocess(image)[None])[0].numpy().astype(np.float32)
            return row

        vis = read(photo, picture.image)
        image = mended(picture.image, mend)
        if getattr(encoder, "one_network", photo is touch):
            if isinstance(touch, WithoutDots):
                image, touch = touch.drawn(image), photo
            if image is picture.image:
                return [vis]
        return [vis, read(touch, image)]

    def _from_set(self, row: int, modality: str) -> "Array":
        import numpy as np

        embeddings = self.embeddings()
        self.head().require_embeddings(embeddings)
        # a row of a memmap takes 20 times as long
        plain = np.asarray(getattr(embeddings, modality))
        return np.array(plain[row], np.float32)

    def example(self, name: str, modality: str) -> Path:
        """Return the image of an example, "vis" or "tac". Raises DataError if there is no such
        example.
        """
        file = self.examples().get(name, {}).get(modality)
        if file is None:
            raise DataError(f"No example is called '{name:.80}'; pick one of the gallery.")
        return file

    def _example_rows(self) -> dict[str, int]:
        """Return example -> row of the set, for the examples that are in it."""
        try:
            embeddings = self.embeddings()
            self.head().require_embeddings(embeddings)
        except DataError:
            return {}  # examples are then encoded like any image
        rows = {example_name(Path(photo)): i for i, photo in enumerate(embeddings.rows["vis"])}
        return {name: rows[name] for name in self.examples() if name in rows}

    def _coefficients(self) -> "PairCoefficients":
        from omnivat.maps.sweep.walk import coefficients_of

        return coefficients_of(self.head().model, self.embeddings())

    def _load_encoder(self) -> "Encoder":
        wanted = self.head().encoder
        from omnivat.data.dots import dots_of
        from omnivat.data.relief.files import touch_of

        how = dots_of(wanted["preprocessing"]), touch_of(wanted["preprocessing"])
        encoder = self.shared.encoder(wanted["name"], wanted["weights_hash"], *how)
        made = (encoder.name, encoder.weights_hash, encoder.preprocessing)
        self.head().require(made, encoder.width, what="Images encoded here")
        return encoder


def require_name(name: Any, known: Collection[str]) -> None:
    """Raise DataError for a head that is not loaded; None and "" are the first one."""
    if name is not None and (not isinstance(name, str) or name not in known):
        others = ", ".join(f"'{other}'" for other in known if other) or "none beside the first"
        raise DataError(f"No head is called {name!r:.40}; there are {others}.")


def _load_head(folder: Path) -> "Head":
    from omnivat.head.checkpoint import load_head

    return load_head(folder)


def _load_embeddings(where: Places) -> "Embeddings":
    from omnivat.data.store import load_embeddings

    return load_embeddings(where.embeddings, large=MAPPED_BYTES).sampled(where.drawn)


def _pairs_in(file: Path) -> int:
    """Return the number of pairs in a set, from its header; 0 if it cannot be read."""
    from omnivat.kit.schema import tensor_table

    try:
        return int(tensor_table(file)[1].get("pairs", "0")[:12])
    except (DataError, OSError, ValueError):  # loading reports the error
        return 0


def state_of(file: Path) -> tuple[str, int, int]:
    """Return the identity of a file: path, size and modification time."""
    try:
        found = file.stat()
    except OSError:
        return str(file), 0, 0
    return str(file.absolute()), found.st_size, found.st_mtime_ns
