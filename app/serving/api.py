"""The API for programs, over HTTP and MCP: `about`, `predict`, `gaps`, `report`; `--api` opens it.

It obeys the page's rules (`app.serving.guard`), limits and queue (`limits` and `jobs` of
`app.shared`).
"""

from base64 import b64decode
from collections.abc import Callable
from functools import partial
from typing import Any

from starlette.requests import Request
from starlette.responses import JSONResponse, Response
from starlette.routing import Route

from app.serving.about import without_nan
from app.serving.api_schema import TOOLS, document
from app.shared.limits import MAX_API_BYTES, REPORT_S
from app.shared.map_place import kept_features
from app.shared.messages import Handler, in_sentences, refusal
from app.shared.pair_input import pair_request
from app.shared.requests import done, question_from, received
from app.shared.resources import Resources
from app.shared.state import Question, Reply, one_of, order_from
from app.shared.visitor_sets import VisitorSets
from omnivat.kit.errors import DataError
from omnivat.kit.progress import checkpoint
from omnivat.kit.stages import IMAGES

Work = Callable[[Resources, Question], Reply]
KINDS: dict[str, Any] = {"string": str, "number": int | float}
CLOSED = "The API is off; whoever runs this page can open it with --api."
UNKNOWN = f"There is no such tool; there are {', '.join(TOOLS)}, and schema."
ONE_AT_A_TIME = ("report",)  # tools of the long lane


def about(resources: Resources, _: Question) -> Reply:
    """Return the names that the other tools take."""
    from omnivat.head.heads import shipped_sets

    head, data = resources.head(), resources.embeddings().header
    return {
        "classes": list(head.settings.classes),
        "domains": list(data.domains),
        "pairs": len(resources.embeddings()),
        "simulated": data.simulated,
        "encoder": data.encoder,
        "source": head.source,
        "learned_order": head.model.order,
        "examples": list(resources.examples()),
        "heads": [name for name in resources.heads if name],
        "sets": list(shipped_sets()),
    }


def predict(resources: Resources, arguments: Question) -> Reply:
    """Return the record of `omnivat.head.predict` for one pair."""
    from omnivat.head.predict import predict_embeddings

    images = {name: _image(resources, arguments.get(name), name) for name in IMAGES}
    named = pair_request(resources, {**arguments, **images})
    found = predict_embeddings(named.head, *named.pair.values(), order=named.order)[0]
    found.pop("profile")
    return {**found, "source": named.head.source}


def _image(resources: Resources, value: Any, name: str) -> Any:
    """Return the reference of an image; a data: address is decoded and embedded."""
    if not isinstance(value, str) or not value.startswith("data:"):
        return value
    kind, comma, text = value.partition(";base64,")
    try:
        content = b64decode(text, validate=True)
    except ValueError:
        comma = ""
    if not comma or len(kind) > 40:
        raise DataError(f"{name} is no data address; send 'data:image/png;base64,' and the file.")
    return str(resources.take_image(content, name)[0])


def gaps(resources: Resources, arguments: Question) -> Reply:
    """Return the record of `omnivat gaps --json`."""
    import torch

    from omnivat.measure.gaps.domain import gap_record
    from omnivat.measure.gaps.large import parts_of

    stage, measure = arguments.get("stage", "f_hat"), arguments.get("measure", "centroid")
    order, data = order_from(arguments.get("order")), resources.embeddings()
    order = resources.head().model.order if order is None else order
    points = torch.from_numpy(kept_features(resources, stage, order))
    sets, rows = parts_of(points, data.domain, data.header.domains)
    return {
        "stage": stage,
        "order": None if stage == "raw" else order,
        "measure": measure,
        "pairs": len(data),
        "simulated": data.header.simulated,
        **gap_record(rows, sets, measure),
    }


def report(resources: Resources, _: Question) -> Reply:
    """Return the numbers of `omnivat report`; they are computed once for a set."""
    from omnivat.study.shift.reading import features_of
    from omnivat.study.shift.report import numbers
    from omnivat.study.shift.words import methods, notes

    def made() -> Reply:
        features = features_of(resources.embeddings())
        return {
            "pairs": len(features.embeddings),
            "domains": features.domains,
            "simulated": features.embeddings.header.simulated,
            "numbers": numbers(features, lambda _: checkpoint()),
            "notes": notes(features),
            "methods": methods(features, 0),
        }

    return resources.results.once("report", made)


WORK: dict[str, Work] = {"about": about, "predict": predict, "gaps": gaps, "report": report}


def checked(name: str, arguments: Question) -> Question:
    """Return the arguments of a tool without nulls; raises DataError for one that it does not
    take.
    """
    takes = TOOLS[name][1]["properties"]
    if unknown := [key for key in arguments if key not in takes]:
        raise DataError(f"{name} takes no '{unknown[0]:.40}'; it takes {', '.join(takes)}.")
    stated = {key: value for key, value in arguments.items() if value is not None}
    for key, value in stated.items():
        kind, names = takes[key]["type"], takes[key].get("enum")
        if isinstance(value, bool) or not isinstance(value, KINDS[kind]):
            raise DataError(f"{key} has to be a {kind}; '{type(value).__name__}' came.")
        if names:
            one_of(key, value, names)
    return stated


async def used(
    sets: VisitorSets, request: Request, read: Callable[[bytes], tuple[str, Question] | None]
) -> Reply | None:
    """Run the tool that `read` finds in a request's body; None if it finds none.

    The body waits on the disk and is read in turn, so that many large ones hold no memory.
    """

    def begun() -> Any:
        if (found := read(file.read_bytes())) is None:
            return None
        name, given = found[0], checked(*found)
        work = partial(WORK[name], sets.named(given.get("set", "")[:64]), given)
        return work if name in ONE_AT_A_TIME else work()

    jobs = sets.shared.jobs
    async with received(request, sets.shared.scratch, MAX_API_BYTES, "The request") as file:
        result = await done(request, jobs, begun, priority=1)
    if isinstance(result, partial):
        result = await done(request, jobs, result, lane="long", deadline_s=REPORT_S)
    return None if result is None else dict(without_nan(result))


async def serve(sets: VisitorSets, name: str, request: Request) -> Response:
    """Run one tool with the JSON object in the body."""
    return JSONResponse(await used(sets, request, lambda body: (name, question_from(body))))


async def schema(_: Request) -> Response:
    """Serve the OpenAPI document."""
    return JSONResponse(document())


async def missing(sentence: str, _: Request) -> Response:
    """Refuse an address without a tool, and any while the API is off."""
    return refusal(sentence, 404)


def only(method: str, handler: Handler) -> Handler:
    """Refuse other methods in a sentence."""

    async def one(request: Request) -> Response:
        if request.method == method:
            return await handler(request)
        reply = refusal(f"Send {method} to this address, not {request.method:.10}.", 405)
        reply.headers["allow"] = method
        return reply

    return one


def api_routes(sets: VisitorSets, mcp: Handler, *, opened: bool) -> list[Route]:
    """Return the routes of the API; while it is not opened, each refuses."""
    handlers: dict[str, Handler] = {
        "/omnivat/api/schema": only("GET", schema),
        **{f"/omnivat/api/{name}": only("POST", partial(serve, sets, name)) for name in TOOLS},
        "/omnivat/mcp": only("POST", mcp),
        "/omnivat/api/{rest:path}": partial(missing, UNKNOWN),
    }
    methods = ["GET", "POST", "PUT", "PATCH", "DELETE", "OPTIONS"]
    return [
        Route(path, in_sentences(handler if opened else partial(missing, CLOSED)), methods=methods)
        for path, handler in handlers.items()
    ]
