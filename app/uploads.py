"""Upload routes for an image, or for the files of a head or set."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

from starlette.requests import Request
from starlette.responses import JSONResponse, Response

from app.jobs import Job
from app.limits import MAX_IMAGE_BYTES, PARTS
from app.messages import Handler, refusal
from app.pictures import Sent, live, occlusion, taken
from app.requests import blocks, done, number_from, question_of, received, set_of
from app.resources import Resources
from app.sensor import load_sensor
from app.state import order_from, ref_from
from app.visitor_sets import VisitorSets

LIVE, SENT, LOADED, SLOW = 0, 1, 1, 2  # priorities in the quick lane


def upload_routes(sets: VisitorSets) -> dict[str, Handler]:
    """Return the handlers by address."""
    return {
        "/omnivat/image": partial(of_image, taken, SENT, sets),
        "/omnivat/occlusion": partial(of_image, occlusion, SLOW, sets),
        "/omnivat/live": partial(of_image, live, LIVE, sets),
        "/omnivat/sensor": partial(take_sensor, sets),
        "/omnivat/part": partial(take_part, sets),
        "/omnivat/load": partial(load, sets),
    }


async def of_image(
    work: Callable[[Resources, Sent], dict[str, Any]],
    priority: int,
    sets: VisitorSets,
    request: Request,
) -> Response:
    """Run `work` on an uploaded image with the parameters of the address; the file is not kept."""
    query = request.query_params
    resources = set_of(sets, request)
    split = query.get("split", "")[:9]  # of two pictures in one body
    sent = Sent(
        content=b"",
        modality=query.get("modality", ""),
        split=int(split) if split.isdecimal() else 0,
        other=ref_from(query.get("other")),
        order=order_from(number_from(query.get("order"))),
        name=query.get("name", "")[:120] or "the image",
        taught=query.get("taught", ""),
        head=query.get("head", ""),
        profile=query.get("profile", ""),
    )
    async with received(request, sets.shared.scratch, MAX_IMAGE_BYTES, "The image") as file:

        def computed(_: Job[dict[str, Any]]) -> dict[str, Any]:
            return work(resources, replace(sent, content=file))

        return JSONResponse(await done(request, sets.shared.jobs, computed, priority=priority))


async def take_sensor(sets: VisitorSets, request: Request) -> Response:
    """Receive a saved profile of a sensor."""
    resources = set_of(sets, request)
    async with received(
        request, sets.shared.scratch, PARTS["profile.safetensors"], "The profile"
    ) as file:
        return JSONResponse(
            await done(request, sets.shared.jobs, lambda _: load_sensor(resources, file))
        )


async def take_part(sets: VisitorSets, request: Request) -> Response:
    """Receive one file of a head or set."""
    name = request.query_params.get("name", "")
    content = blocks(request, max(PARTS.values()), "The file")
    return JSONResponse({"part": await sets.parts.keep(name, content)})


async def load(sets: VisitorSets, request: Request) -> Response:
    """Make a visitor set of the uploaded files: `{"parts": {file: part}, "compare": false}`."""
    question = await question_of(request)
    parts = question.get("parts")
    if not isinstance(parts, dict) or not all(isinstance(part, str) for part in parts.values()):
        return refusal("parts has to name the files that were sent; choose them again.")
    compare = question.get("compare") is True

    def loaded(_: Job[str]) -> str:
        return sets.load(parts, beside=set_of(sets, request).owner, compare=compare)

    return JSONResponse({"set": await done(request, sets.shared.jobs, loaded, priority=LOADED)})
