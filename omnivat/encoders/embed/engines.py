"""Embed on this machine with threads, or on a Ray cluster."""

import pickle
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import Any

from omnivat.encoders import Encoder
from omnivat.encoders.cache import EmbeddingCache
from omnivat.encoders.embed.job import Chunk, embed_one, part_bytes
from omnivat.kit.errors import DataError
from omnivat.kit.tables import need
from omnivat.kit.threads import pin_thread


def run_local(
    chunks: Sequence[Chunk],
    encoder: Encoder,
    load: Callable[[], Encoder],
    *,
    workers: int,
    on_pairs: Callable[[int], None],
) -> Iterator[tuple[Chunk, bytes]]:
    """Yield each chunk with the content of its part file, in order.

    While one worker reads or decodes, the others encode. An image that recurs soon, such as one
    photo for many touches, is encoded once.
    """
    cache = EmbeddingCache(in_memory=1024)
    pool = ThreadPoolExecutor(workers, "embed", initializer=pin_thread)
    try:
        for chunk in chunks:
            found = []
            for result in pool.map(partial(embed_one, encoder, chunk.flips, cache), chunk.pairs):
                found.append(result)
                on_pairs(1)
            yield chunk, part_bytes(chunk, found)
    finally:
        pool.shutdown(cancel_futures=True)  # of what has not started


def run_on_ray(
    chunks: Sequence[Chunk],
    encoder: Encoder,
    load: Callable[[], Encoder],
    *,
    workers: int,
    on_pairs: Callable[[int], None],
) -> Iterator[tuple[Chunk, bytes]]:
    """Yield each chunk with the content of its part file, in the order of completion.

    It uses the connected cluster, or the one of $RAY_ADDRESS, or starts Ray here.
    workers     number of worker processes, each on one core of the cluster
    """
    ray, data = (
        need(n, purpose="embedding over a cluster", install="'ray[data]'")
        for n in ("ray", "ray.data")
    )
    if not chunks:
        return
    ray.init(ignore_reinit_error=True)
    rows = [{"index": i, "chunk": pickle.dumps(chunk)} for i, chunk in enumerate(chunks)]
    finished = data.from_items(rows, override_num_blocks=len(rows)).map(
        Worker,
        fn_constructor_args=(load, encoder.weights_hash),
        concurrency=min(workers, len(rows)),
        num_cpus=1,
    )
    for row in finished.iter_rows():
        chunk = chunks[row["index"]]
        on_pairs(len(chunk.pairs))
        yield chunk, row["part"]


class Worker:
    """One process of the cluster: loads the encoder once, then turns chunks into part files."""

    def __init__(self, load: Callable[[], Encoder], weights_hash: str) -> None:
        self._encoder = load()
        self._cache = EmbeddingCache(in_memory=1024)
        if self._encoder.weights_hash != weights_hash:
            raise DataError(
                f"A worker has other weights of {self._encoder.name} than the sender of the"
                f" pictures ({self._encoder.weights_hash}, not {weights_hash}); put the same"
                " checkpoint on both."
            )

    def __call__(self, row: dict[str, Any]) -> dict[str, Any]:
        """Return the content of the part file of the chunk in `row`."""
        chunk: Chunk = pickle.loads(row["chunk"])  # sent by `run_on_ray` above, not from a file
        work = partial(embed_one, self._encoder, chunk.flips, self._cache)
        return {"index": row["index"], "part": part_bytes(chunk, [*map(work, chunk.pairs)])}
