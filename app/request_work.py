"""Run a request as a job that ends when its visitor leaves, and receive uploads."""

import asyncio
import os
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from pathlib import Path
from typing import TypeVar

from starlette.requests import Request

from app.jobs import Job, Jobs
from app.requests import blocks, visitor_of
from app.scratch import Scratch

T = TypeVar("T")
LOOK_S = 0.25  # seconds between two checks for a disconnected visitor
QUESTION_S = 120  # longest time for a reply, in seconds


async def done(
    request: Request,
    jobs: Jobs,
    work: Callable[[Job[T]], T],
    *,
    priority: int = 0,
    lane: str = "quick",
    deadline_s: float = QUESTION_S,
) -> T:
    """Run `work` as a job of a lane; return its result.

    The job is cancelled when the visitor disconnects. Raises its OmniVatError.
    """
    visitor = visitor_of(request)
    job = jobs.start(work, lane=lane, visitor=visitor, priority=priority, deadline_s=deadline_s)
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
async def received(request: Request, scratch: Scratch, limit: int, what: str) -> AsyncIterator[Path]:
    """Yield a temporary file with the request's bytes.

    Raises DataError for more than `limit` bytes, or if the upload stalls.
    """
    file = scratch.folder("images") / os.urandom(8).hex()
    try:
        with file.open("wb") as handle:
            async for block in blocks(request, limit, what):
                handle.write(block)
        yield file
    finally:
        file.unlink(missing_ok=True)
