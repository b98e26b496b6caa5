"""Read requests safely (limited bytes, JSON objects, numbers); run each as a job that ends when
its visitor leaves.

A question is a JSON object. If pictures come with it, they follow it in the body, `?sizes=` has the
bytes of the object and of each picture, and the object names them "file:0", "file:1", ….
"""

import asyncio
import json
import os
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from itertools import accumulate
from pathlib import Path
from time import monotonic
from typing import Any, TypeVar
from weakref import WeakValueDictionary

from starlette.requests import Request

from app.shared.connections import visitor_at
from app.shared.jobs import Jobs
from app.shared.limits import (
    BODY_S,
    IDLE_S,
    MAX_IMAGE_BYTES,
    MAX_PICTURES_BYTES,
    MAX_QUESTION_BYTES,
    PICTURES,
    SMALL_QUESTION_BYTES,
    UPLOADS,
)
from app.shared.resources import Resources
from app.shared.scratch import Scratch
from app.shared.state import Question
from app.shared.visitor_sets import VisitorSets
from omnivat.kit.errors import DataError

T = TypeVar("T")
LOOK_S = 0.25  # seconds between two checks for a disconnected visitor
QUESTION_S = 120  # longest time for a reply, in seconds
FILES = "files"  # the pictures that came with a question, in it
ARRIVING: WeakValueDictionary[str, asyncio.Semaphore] = WeakValueDictionary()  # by visitor


class TooLargeError(DataError):
    """A body is over its limit."""

    status = 413


class StalledError(DataError):
    """An upload stalled."""

    status = 408


def set_of(sets: VisitorSets, request: Any) -> Resources:
    """Return the visitor set named in a request's address: the server's own, or a loaded one."""
    return sets.named(request.query_params.get("set", "")[:64])


def visitor_of(request: Request) -> str:
    """Return the visitor's address, as `visitor_at` does.

    Behind a proxy on this machine it is the address that the proxy reports (X-Forwarded-For).
    """
    return visitor_at(request.client.host if request.client else "")


async def blocks(request: Request, limit: int, what: str) -> AsyncIterator[bytes]:
    """Yield the request's bytes as they arrive, at most `limit`.

    Raises TooLargeError for more bytes, StalledError if the upload stalls or takes too long.
    """
    size, began, stream = 0, monotonic(), aiter(request.stream())
    while True:
        left = BODY_S - (monotonic() - began)
        try:
            block = await asyncio.wait_for(anext(stream), min(IDLE_S, left))
        except StopAsyncIteration:
            return
        except TimeoutError as error:
            raise StalledError(f"{what} did not arrive in time; send it again.") from error
        size += len(block)
        if size > limit:
            raise TooLargeError(
                f"{what} is larger than {limit / 1e6:.3g} MB; scale it down and try again."
            )
        yield block


@asynccontextmanager
async def asked(request: Request, scratch: Scratch) -> AsyncIterator[Callable[[], Question]]:
    """Yield what reads the question in a request, with the pictures after it as FILES; a large one
    waits on the disk for its job. Raises the errors of `blocks`; reading, those of `question_from`
    and `split`.
    """
    sizes = request.query_params.get("sizes", "")
    length = request.headers.get("content-length", "")[:20]
    if not sizes and length.isdecimal() and int(length) <= SMALL_QUESTION_BYTES:
        body = b"".join([block async for block in blocks(request, int(length), "The question")])
        yield lambda: question_from(body)
        return
    limit = MAX_PICTURES_BYTES if sizes else MAX_QUESTION_BYTES
    async with received(request, scratch, limit, "The question") as file:

        def read() -> Question:
            content = file.read_bytes()
            text, *files = split(content, sizes, 1 + PICTURES) if sizes else [content]
            if len(max([b"", *files], key=len)) > MAX_IMAGE_BYTES:
                raise TooLargeError("A picture is larger than 20 MB; scale it down and try again.")
            return {**question_from(text), FILES: files} if files else question_from(text)

        yield read


def split(content: bytes, sizes: str, most: int) -> list[bytes]:
    """Return the parts of a body by their sizes, with commas; raises DataError if they are not all
    of it, or more than `most`.
    """
    numbers = [int(size) if size.isdecimal() else 0 for size in sizes[: 9 * most].split(",")]
    if len(numbers) > most or not all(numbers) or sum(numbers) != len(content):
        raise DataError(
            f"sizes is '{sizes:.40}' for {len(content):,} bytes; give the bytes of each of at most"
            f" {most} parts, with commas."
        )
    ends = list(accumulate(numbers))
    return [content[end - size : end] for end, size in zip(ends, numbers, strict=True)]


def question_from(content: bytes) -> Question:
    """Return the JSON object in `content`. Raises DataError if it is anything else."""
    try:
        question = json.loads(content)
    except (ValueError, RecursionError) as error:
        raise DataError("The request is not JSON; send an object such as {} instead.") from error
    if not isinstance(question, dict):
        raise DataError("The request is not a JSON object; send one such as {} instead.")
    question.pop(FILES, None)  # they come after it
    return question


async def done(
    request: Request,
    jobs: Jobs,
    work: Callable[[], T],
    *,
    priority: int = 0,
    lane: str = "quick",
    deadline_s: float = QUESTION_S,
) -> T:
    """Run `work` as a job of a lane, cancelled when the visitor disconnects; return its result
    or raise its error.
    """
    job = jobs.start(
        lambda _: work(),
        lane=lane,
        visitor=visitor_of(request),
        priority=priority,
        deadline_s=deadline_s,
    )
    end = asyncio.wrap_future(job.future)
    try:
        while not (await asyncio.wait({end}, timeout=LOOK_S))[0]:
            if await request.is_disconnected():
                job.cancel()
        return end.result()
    except asyncio.CancelledError:
        job.cancel()
        raise


@asynccontextmanager
async def received(
    request: Request, scratch: Scratch, limit: int, what: str
) -> AsyncIterator[Path]:
    """Yield a temporary file with the request's bytes; raises the errors of `blocks`.

    Of one visitor, UPLOADS arrive at a time, which bounds what they take of the disk.
    """
    file = scratch.folder("images") / os.urandom(8).hex()
    try:
        async with ARRIVING.setdefault(visitor_of(request), asyncio.Semaphore(UPLOADS)):
            with file.open("wb") as handle:
                async for block in blocks(request, limit, what):
                    handle.write(block)
        yield file
    finally:
        file.unlink(missing_ok=True)
