"""The page's own routes: its scripts, its data files, and the questions it asks.

Only what is listed here is served. Questions are JSON; every refusal is one sentence. `?set=NAME`
asks of a head or set that was loaded through the page.
"""

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

from anyio import CapacityLimiter, to_thread
from starlette.background import BackgroundTask
from starlette.requests import Request
from starlette.responses import FileResponse, JSONResponse, Response
from starlette.routing import Route

from app.components import WEB
from app.desks import Desks
from app.examples import example_named, listed
from app.limits import LANES, MAX_IMAGE_BYTES, MAX_QUESTION_BYTES
from app.live import live
from app.measuring import measured
from app.messages import Handler, in_sentences, refusal
from app.occlusion import occlusion
from app.requests import body, file_name, number_from, preview, question_from
from app.resources import Resources, require_name
from app.state import order_from, ref_from
from app.views import compare, data, explore, pair, tree

Answer = Callable[[Resources, Mapping[str, Any]], dict[str, Any]]
QUESTIONS: dict[str, Answer] = {
    "pair": pair.answer,
    "attention": pair.attention,
    "tree": tree.answer,
    "neighbours": explore.neighbours,
    "place": explore.place,
    "answers": compare.answers,
    "measure": measured,
}
FACTS: dict[str, Callable[[Resources], Any]] = {
    "about": data.about,
    "heads": compare.heads,
    "matrix": compare.matrix,
    "retrained": explore.retrained,
    "examples": lambda resources: listed(resources.examples()),
}
TYPES = {".js": "text/javascript", ".css": "text/css"}
HOLDS = "X-Holds"  # a page that was opened on another head or set is told to load again
FRESH = {"Cache-Control": "no-cache"}  # ask each time, take nothing where it is unchanged


def routes(first: Resources) -> list[Route]:
    """Return all routes, each answering errors with a sentence."""
    desks, lanes = Desks(first), CapacityLimiter(LANES)
    gets: dict[str, Handler] = {
        "/omnivat/web/{name}": web_file,
        "/omnivat/frames": partial(frames, desks),
        "/omnivat/thumbnails.{kind}": partial(thumbnails, desks),
        "/omnivat/example/{name:path}": partial(example_image, desks),
        **{
            f"/omnivat/{name}": partial(facts, desks, lanes, found) for name, found in FACTS.items()
        },
    }
    posts: dict[str, Handler] = {
        f"/omnivat/{name}": partial(ask, desks, lanes, answer) for name, answer in QUESTIONS.items()
    }
    posts["/omnivat/image"] = partial(take_image, desks, lanes)
    posts["/omnivat/occlusion"] = partial(occlude, desks, lanes)
    posts["/omnivat/live"] = partial(live_picture, desks, lanes)
    posts["/omnivat/part"] = partial(take_part, desks)
    posts["/omnivat/load"] = partial(load, desks, lanes)
    posts["/gradio_api/{anything:path}"] = nothing_here
    return [
        *(Route(path, in_sentences(handler)) for path, handler in gets.items()),
        *(Route(path, in_sentences(handler), methods=["POST"]) for path, handler in posts.items()),
    ]


def desk_of(desks: Desks, request: Request) -> Resources:
    """Return what the request asks of: the head and set that the server started with, or others."""
    return desks.named(request.query_params.get("set", "")[:64])


async def nothing_here(_: Request) -> Response:
    """Refuse what is sent to Gradio itself: it only lays out the tabs, and the page sends it nothing."""
    return refusal("The page takes nothing here; its own routes are under omnivat/.", 404)


async def web_file(request: Request) -> Response:
    """Serve one of the page's scripts or styles; nothing else lies under that folder's name."""
    known = {path.name: path for path in WEB.iterdir() if path.suffix in TYPES}
    path = known.get(request.path_params["name"])
    if path is None:
        return refusal("The page has no such file.", 404)
    return FileResponse(path, media_type=TYPES[path.suffix], headers=FRESH)


async def frames(desks: Desks, request: Request) -> Response:
    """Serve the frames of a head, or say how far they are (202), or why there are none (404).

    A header tells that finer frames are on their way. The map being there, head and set are loaded
    beside whatever the visitor does, so that the first question is answered at once.
    """
    resources = desk_of(desks, request)
    name = request.query_params.get("head", "")
    require_name(name, resources.frame_jobs)
    state = resources.frame_jobs[name].state()
    step = (
        {"done": state.step.done, "total": state.step.total, "text": state.step.text}
        if (state.step)
        else None
    )
    if state.problem:
        return refusal(state.problem, 404)
    if state.file is None or "progress" in request.query_params:
        return JSONResponse({"step": step, "ready": state.file is not None}, status_code=202)
    headers = {**FRESH, HOLDS: resources.holds, "X-Frames": "coarse" if step else "fine"}
    return FileResponse(
        state.file,
        media_type="application/octet-stream",
        headers=headers,
        background=BackgroundTask(resources.warm),
    )


async def thumbnails(desks: Desks, request: Request) -> Response:
    """Serve the sprite of thumbnails or its description; sets without one show names only."""
    sprite = desk_of(desks, request).where.sprite
    file = {
        "webp": sprite,
        "json": sprite.with_suffix(".json") if sprite else None,
    }.get(request.path_params["kind"])
    if file is None or not file.is_file():
        return refusal("This set has no thumbnails; the page shows names instead.", 404)
    return FileResponse(file, headers=FRESH)


async def example_image(desks: Desks, request: Request) -> Response:
    """Serve one image of an example: `<name>/vis` or `<name>/tac`."""
    name, _, modality = request.path_params["name"].rpartition("/")
    if modality not in ("vis", "tac"):
        return refusal("An example's image is its name and then /vis or /tac.", 404)
    file = example_named(desk_of(desks, request).examples(), name).file(modality)
    if not file.is_file():
        return refusal("This example's image is no longer there; reload the page.", 404)
    return FileResponse(file, headers=FRESH)


async def facts(
    desks: Desks, lanes: CapacityLimiter, found: Callable[[Resources], Any], request: Request
) -> Response:
    """Say what is known of what is loaded."""
    resources = desk_of(desks, request)
    known = await to_thread.run_sync(found, resources, limiter=lanes)
    return JSONResponse(known, headers={HOLDS: resources.holds})


async def ask(desks: Desks, lanes: CapacityLimiter, answer: Answer, request: Request) -> Response:
    """Answer one JSON question in a thread of its own."""
    resources = desk_of(desks, request)
    question = question_from(await body(request, MAX_QUESTION_BYTES, "The question"))
    said = await to_thread.run_sync(answer, resources, question, limiter=lanes)
    return JSONResponse(said, headers={HOLDS: resources.holds})


async def take_image(desks: Desks, lanes: CapacityLimiter, request: Request) -> Response:
    """Take the bytes of one image, embed it, and return its name and a small preview."""
    resources = desk_of(desks, request)
    content = await body(request, MAX_IMAGE_BYTES, "The image")

    def taken() -> dict[str, Any]:
        ref, image = resources.take_image(content, file_name(request))
        return {
            "ref": str(ref),
            "width": image.width,
            "height": image.height,
            "preview": preview(image),
        }

    return JSONResponse(await to_thread.run_sync(taken, limiter=lanes))


async def occlude(desks: Desks, lanes: CapacityLimiter, request: Request) -> Response:
    """Take the bytes of one image; say which parts of it the answer depends on."""
    return await of_image(occlusion, desks, lanes, request)


async def live_picture(desks: Desks, lanes: CapacityLimiter, request: Request) -> Response:
    """Take one picture of a camera; answer it and forget it."""
    return await of_image(live, desks, lanes, request)


async def of_image(
    work: Callable[..., dict[str, Any]], desks: Desks, lanes: CapacityLimiter, request: Request
) -> Response:
    """Do `work` on an image that is sent, with what the address says of it."""
    asked = request.query_params
    resources = desk_of(desks, request)
    content = await body(request, MAX_IMAGE_BYTES, "The image")
    todo = partial(
        work,
        resources,
        content,
        modality=asked.get("modality", ""),
        other=ref_from(asked.get("other")),
        order=order_from(number_from(asked.get("order"))),
        name=file_name(request),
    )
    return JSONResponse(await to_thread.run_sync(todo, limiter=lanes))


async def take_part(desks: Desks, request: Request) -> Response:
    """Take one file of a head or set, as it comes."""
    name = request.query_params.get("name", "")
    return JSONResponse({"part": await desks.keep_part(name, request.stream())})


async def load(desks: Desks, lanes: CapacityLimiter, request: Request) -> Response:
    """Make a desk of the files that were sent: `{"parts": {file: part}, "compare": false}`."""
    question = question_from(await body(request, MAX_QUESTION_BYTES, "The question"))
    parts = question.get("parts")
    if not isinstance(parts, dict) or not all(isinstance(part, str) for part in parts.values()):
        return refusal("parts has to name the files that were sent; choose them again.")
    work = partial(
        desks.load,
        parts,
        beside=request.query_params.get("set", "")[:64],
        compare=question.get("compare") is True,
    )
    return JSONResponse({"set": await to_thread.run_sync(work, limiter=lanes)})
