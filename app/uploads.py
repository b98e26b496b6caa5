"""Upload routes for an image, or for the files of a head or set."""

from collections.abc import Callable
from functools import partial
from typing import Any

from starlette.requests import Request
from starlette.responses import JSONResponse, Response

from app.desks import Desks
from app.jobs import Job
from app.limits import MAX_IMAGE_BYTES, MAX_QUESTION_BYTES, PARTS
from app.live import live
from app.messages import Handler, refusal
from app.occlusion import occlusion
from app.requests import blocks, body, desk_name, file_name, number_from, preview, question_from
from app.state import order_from, ref_from
from app.working import done, received

LIVE, SENT, LOADED, SLOW = 0, 1, 1, 2  # priorities in the quick lane


def upload_routes(desks: Desks) -> dict[str, Handler]:
    """Return the handlers by address."""
    return {
        "/omnivat/image": partial(take_image, desks),
        "/omnivat/occlusion": partial(of_image, occlusion, SLOW, desks),
        "/omnivat/live": partial(of_image, live, LIVE, desks),
        "/omnivat/part": partial(take_part, desks),
        "/omnivat/load": partial(load, desks),
    }


async def take_image(desks: Desks, request: Request) -> Response:
    """Embed one uploaded image; return its name and a small preview."""
    resources = desks.named(desk_name(request))
    name = file_name(request)
    async with received(request, desks.shared.scratch, MAX_IMAGE_BYTES, "The image") as file:

        def taken(job: Job[dict[str, Any]]) -> dict[str, Any]:
            ref, found = resources.take_image(file, name, job.check)
            return {
                "ref": str(ref),
                "width": found.width,
                "height": found.height,
                "preview": preview(found.image),
            }

        return JSONResponse(await done(request, desks.shared.jobs, taken, priority=SENT))


async def of_image(
    work: Callable[..., dict[str, Any]], priority: int, desks: Desks, request: Request
) -> Response:
    """Run `work` on an uploaded image that is not kept, with the parameters of the address."""
    asked = request.query_params
    resources = desks.named(desk_name(request))
    known = {
        "modality": asked.get("modality", ""),
        "other": ref_from(asked.get("other")),
        "order": order_from(number_from(asked.get("order"))),
        "name": file_name(request),
    }
    async with received(request, desks.shared.scratch, MAX_IMAGE_BYTES, "The image") as file:

        def answered(job: Job[dict[str, Any]]) -> dict[str, Any]:
            return work(resources, file, check=job.check, **known)

        jobs = desks.shared.jobs
        return JSONResponse(await done(request, jobs, answered, priority=priority))


async def take_part(desks: Desks, request: Request) -> Response:
    """Receive one file of a head or set."""
    name = request.query_params.get("name", "")
    content = blocks(request, max(PARTS.values()), "The file")
    return JSONResponse({"part": await desks.keep_part(name, content)})


async def load(desks: Desks, request: Request) -> Response:
    """Make a desk of the uploaded files: `{"parts": {file: part}, "compare": false}`."""
    question = question_from(await body(request, MAX_QUESTION_BYTES, "The question"))
    parts = question.get("parts")
    if not isinstance(parts, dict) or not all(isinstance(part, str) for part in parts.values()):
        return refusal("parts has to name the files that were sent; choose them again.")
    compare = question.get("compare") is True

    def loaded(job: Job[str]) -> str:
        return desks.load(parts, beside=desk_name(request), compare=compare, check=job.check)

    name = await done(request, desks.shared.jobs, loaded, priority=LOADED)
    return JSONResponse({"set": name})
