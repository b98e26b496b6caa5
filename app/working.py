"""Do a request's work as a job that ends when its visitor goes, and take what a visitor sends."""

import asyncio
import os
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from pathlib import Path
from typing import TypeVar

from starlette.requests import Request

from app.jobs import Job, Jobs
from app.requests import blocks
from app.scratch import Scratch

T = TypeVar("T")
LOOK_S = 0.25  # how often it is seen whether the visitor is still there
QUESTION_S = 120  # seconds that the answer to a question may take


async def done(
    request: Request,
    jobs: Jobs,
    work: Callable[[Job[T]], T],
    *,
    priority: int = 0,
    deadline_s: float = QUESTION_S,
) -> T:
    """Return what `work` returns, as a job of the quick lane.

    The job is cancelled when the visitor goes. Raises its OmniVatError.
    """
    job = jobs.start(work, lane="quick", priority=priority, deadline_s=deadline_s)
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
    """Give a file of the request's bytes, which is gone afterwards.

    Raises DataError when there are more than `limit`, or none come for a while.
    """
    file = scratch.folder("images") / os.urandom(8).hex()
    try:
        with file.open("wb") as handle:
            async for block in blocks(request, limit, what):
                handle.write(block)
        yield file
    finally:
        file.unlink(missing_ok=True)
