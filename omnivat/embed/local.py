"""The local engine: every core reads, decodes and encodes one image at a time."""

from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from functools import partial
from itertools import islice
from typing import TypeVar

from omnivat.embed.job import Chunk, Job, embed_one
from omnivat.embed.parts import part_bytes
from omnivat.encoders import Encoder
from omnivat.encoders.cache import EmbeddingCache
from omnivat.encoders.running import pinned_workers

A = TypeVar("A")
B = TypeVar("B")
AHEAD = 4  # waiting pairs for each worker; bounds the memory


def run(
    chunks: Sequence[Chunk],
    job: Job,
    encoder: Encoder,
    *,
    workers: int,
    on_pairs: Callable[[int], None],
) -> Iterator[tuple[Chunk, bytes]]:
    """Yield each chunk with the content of its part file, in order.

    While one worker reads or decodes, the others encode. An image that recurs soon, such as one
    photo for many touches, is encoded once.
    """
    work = partial(embed_one, encoder, job, cache=EmbeddingCache(in_memory=1024))
    pairs = (pair for chunk in chunks for pair in chunk.pairs)
    with pinned_workers(workers) as pool:
        results = in_order(pool, work, pairs, window=AHEAD * workers)
        for chunk in chunks:
            found = []
            for result in islice(results, len(chunk.pairs)):
                found.append(result)
                on_pairs(1)
            yield chunk, part_bytes(chunk, job, found)


def in_order(
    pool: ThreadPoolExecutor, work: Callable[[A], B], items: Iterable[A], *, window: int
) -> Iterator[B]:
    """Yield `work(item)` for each item in order, with at most `window` items in progress."""
    under_way: deque[Future[B]] = deque()
    for item in items:
        under_way.append(pool.submit(work, item))
        if len(under_way) == window:
            yield under_way.popleft().result()
    while under_way:
        yield under_way.popleft().result()
