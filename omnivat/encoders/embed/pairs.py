"""Embed every pair of a set into one file: resumable, in bounded memory."""

import os
import time
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from types import MappingProxyType

from omnivat.data.pairs import PairSet, Skipped
from omnivat.data.relief import Lamps
from omnivat.data.store import Header, manifest_place, require_own, vector_type
from omnivat.encoders import load_encoder
from omnivat.encoders.base import require_filled
from omnivat.encoders.embed.job import Part, Parts, chunks_of, merge
from omnivat.encoders.embed.relief import lamps_of_domains
from omnivat.kit.errors import DataError, SettingsError
from omnivat.kit.files import path_of, require_writable
from omnivat.kit.progress import OnStep, Step, ignore
from omnivat.kit.tables import load

ENGINES = {
    "local": "omnivat.encoders.embed.engines:run_local",
    "ray": "omnivat.encoders.embed.engines:run_on_ray",
}


@dataclass(frozen=True, slots=True, kw_only=True)
class EmbedReport:
    """The result of `embed_pairs`."""

    out: Path
    header: Header
    embedded: int  # pairs in the file
    resumed: int  # of these and the skipped ones, done by an earlier, interrupted run
    skipped: tuple[Skipped, ...]  # pairs with an unreadable image, and the reasons
    seconds: float


def embed_pairs(
    pairs: PairSet,
    encoder_name: str,
    out: str | Path,
    *,
    weights: str | Path | None = None,
    tac_weights: str | Path | None = None,
    device: str = "cpu",
    precision: str = "fp32",
    download: str = "ask",
    engine: str = "local",
    flips: bool = True,
    dots: str = "fill",
    touch: str = "colours",
    lamps: Mapping[str, Lamps] | None = MappingProxyType({}),
    workers: int | None = None,
    dtype: str = "float32",
    manifest: str = "csv",
    on_step: OnStep = ignore,
) -> EmbedReport:
    """Embed `pairs` with the encoder of that name and write the set of embeddings to `out`.

    encoder_name, weights, tac_weights, device, precision, download  as for `load_encoder`
    engine      "local", or "ray" for a cluster; both write the same file
    flips       also embed mirrored images, for training
    dots        "fill": printed dots of touch are filled first (`omnivat.data.dots`); or "keep"
    touch       "colours", or "relief": touch is drawn as its relief (`omnivat.data.relief`), by the
                lamps of its domain, from at most 50 of its touches. In a domain without lamps each
                touch is drawn by itself, and the header has the reason. "both": the embedding in
                colours is followed by that of the relief, and a photo's by as many zeros
    lamps       domain -> lamps that are known, for the relief; None: each touch is drawn by itself,
                so that nothing is known of a sensor
    workers     images in parallel; default: every core
    dtype       of the file: "float32", or "float16" for half the size
    manifest    "csv" or "parquet": the readable table next to `out`

    Finished parts are in `<out>.parts` until the end; the same call resumes from them.
    Raises DataError if there are no pairs or none can be read, WriteError if `out` cannot be
    written or its table would replace another; settings are checked first.

    >>> from tempfile import TemporaryDirectory
    >>> from omnivat import load_embeddings, read_pairs
    >>> from omnivat.head.heads import EXAMPLES
    >>> with TemporaryDirectory() as folder:
    ...     file = Path(folder) / "set.safetensors"
    ...     report = embed_pairs(read_pairs(EXAMPLES / "pairs"), "strip", file, workers=1)
    ...     load_embeddings(file).vis.shape == (report.embedded, 64)
    True
    """
    out = path_of(out)
    _require_sound(pairs, out, workers, dtype, manifest)
    run = load(ENGINES, engine, kind="engine")
    load_here = partial(
        load_encoder,
        encoder_name,
        weights=weights,
        tac_weights=tac_weights,
        device=device,
        precision=precision,
        download=download,
        dots=dots,
    )
    lit: dict[str, Lamps | str] = {}
    if touch != "colours":
        require_filled(encoder_name, dots)
        lit = {} if lamps is None else lamps_of_domains(pairs.pairs, lamps)
        found = {name: lamps for name, lamps in lit.items() if not isinstance(lamps, str)}
        load_here = partial(load_here, touch=touch, lamps=found)
    begun = time.monotonic()
    encoder, parts, total = load_here(), Parts(out), len(pairs.pairs)
    with parts.claimed():
        chunks = list(chunks_of(pairs.pairs, encoder, (False, True) if flips else (False,)))
        waiting = [chunk for chunk in chunks if parts.read(chunk) is None]
        resumed = total - sum(len(chunk.pairs) for chunk in waiting)
        done = resumed

        def on_pairs(count: int) -> None:
            nonlocal done
            done += count
            on_step(Step(done=done, total=total, text="pairs"))

        on_pairs(0)
        for chunk, content in run(
            waiting, encoder, load_here, workers=workers or usable_cores(), on_pairs=on_pairs
        ):
            parts.write(chunk, content)
        finished = [part for chunk in chunks if (part := parts.read(chunk)) is not None]
        _require_all(finished, len(chunks), pairs, parts)
        header = merge(
            out,
            finished,
            pairs,
            encoder,
            chunks[0].columns,
            dtype=dtype,
            manifest=manifest,
            lamps=lit,
        )
        parts.remove()
    return EmbedReport(
        out=out,
        header=header,
        embedded=sum(len(part.pairs) for part in finished),
        resumed=resumed,
        skipped=tuple(skipped for part in finished for skipped in part.skipped),
        seconds=time.monotonic() - begun,
    )


def _require_sound(
    pairs: PairSet, out: Path, workers: int | None, dtype: str, manifest: str
) -> None:
    """Check input and output before loading the encoder."""
    vector_type(dtype)
    require_writable(out, ".safetensors")
    require_own(manifest_place(out, manifest))
    if workers is not None and workers < 1:
        raise SettingsError(f"workers is {workers}; choose 1 or more.")
    if not pairs.pairs:
        place = pairs.origin or "what was given"
        raise DataError(
            f"There are no pairs to embed in {place}; check the items that the reader skipped."
        )


def usable_cores() -> int:
    """Return the number of cores for this process."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _require_all(finished: list[Part], wanted: int, pairs: PairSet, parts: Parts) -> None:
    if len(finished) < wanted:
        raise DataError(
            f"Of {wanted} parts {len(finished)} can be read; their part files were removed or"
            " damaged meanwhile. Run the same command again to embed the others."
        )
    if not any(part.pairs for part in finished):
        first = finished[0].skipped[0]
        parts.remove()
        raise DataError(f"None of {len(pairs.pairs)} pairs could be read; the first: {first.why}")
