"""The routes of Train here: start, state, cancel, save."""

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

from starlette.requests import Request
from starlette.responses import JSONResponse, Response

from app.limits import MAX_QUESTION_BYTES
from app.messages import Handler
from app.request_work import done
from app.requests import body, desk_name, question_from, visitor_of
from app.training import Trainings
from app.visitor_sets import VisitorSets


def training_routes(sets: VisitorSets) -> dict[str, Handler]:
    """Return the handlers by address; all use POST."""
    trainings = Trainings(sets)
    return {
        "/omnivat/trainings": partial(offers, sets, trainings),
        "/omnivat/train": partial(start, sets, trainings),
        "/omnivat/training": partial(look, trainings.state),
        "/omnivat/training/cancel": partial(look, trainings.cancel),
        "/omnivat/save/trained": partial(saved, sets, trainings),
    }


async def offers(sets: VisitorSets, trainings: Trainings, request: Request) -> Response:
    """Return the choices."""
    resources = sets.named(desk_name(request))
    await question_of(request)  # it has no content, but it is a request like the others
    found = await done(request, sets.shared.jobs, lambda _: trainings.offers(resources))
    return JSONResponse(found)


async def start(sets: VisitorSets, trainings: Trainings, request: Request) -> Response:
    """Queue a training on the visitor's set."""
    name = desk_name(request)
    resources = sets.named(name)
    question = await question_of(request)
    work = partial(trainings.start, resources, question, name, visitor_of(request))
    return JSONResponse(await done(request, sets.shared.jobs, lambda _: work()))


async def look(state: Callable[[Mapping[str, Any]], dict[str, Any]], request: Request) -> Response:
    """Return the state of a training."""
    return JSONResponse(state(await question_of(request)))


async def saved(sets: VisitorSets, trainings: Trainings, request: Request) -> Response:
    """Return a finished head as a zip."""
    question = await question_of(request)
    content = await done(request, sets.shared.jobs, lambda _: trainings.saved(question))
    return Response(content, media_type="application/zip")


async def question_of(request: Request) -> Mapping[str, Any]:
    """Return the JSON object of a request."""
    return question_from(await body(request, MAX_QUESTION_BYTES, "The question"))
