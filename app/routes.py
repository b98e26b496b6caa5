"""The page's own routes: its scripts, its data files, and the questions it asks.

Only what is listed here is served. Questions are JSON; every refusal is one sentence.
"""

import base64
import json
from collections.abc import Callable, Mapping
from functools import partial
from io import BytesIO
from typing import TYPE_CHECKING, Any

from anyio import CapacityLimiter, to_thread
from starlette.requests import Request
from starlette.responses import FileResponse, JSONResponse, Response
from starlette.routing import Route

from app.components import WEB
from app.examples import example_named, listed
from app.limits import LANES, MAX_IMAGE_BYTES, MAX_QUESTION_BYTES
from app.messages import Handler, in_sentences, refusal
from app.occlusion import occlusion
from app.resources import PREVIEW_SIDE, Resources
from app.state import order_from, ref_from
from app.views import data, explore, pair, tree
from omnivat.errors import DataError

if TYPE_CHECKING:
    from PIL import Image

Answer = Callable[[Resources, Mapping[str, Any]], dict[str, Any]]
QUESTIONS: dict[str, Answer] = {
    "pair": pair.answer,
    "tree": tree.answer,
    "neighbours": explore.neighbours,
}
TYPES = {".js": "text/javascript", ".css": "text/css"}
FRESH = {"Cache-Control": "no-cache"}  # ask each time, take nothing where it is unchanged


def routes(resources: Resources) -> list[Route]:
    """Return all routes, each answering errors with a sentence."""
    lanes = CapacityLimiter(LANES)
    gets: dict[str, Handler] = {
        "/omnivat/web/{name}": web_file,
        "/omnivat/frames": partial(frames, resources),
        "/omnivat/thumbnails.{kind}": partial(thumbnails, resources),
        "/omnivat/examples": partial(example_list, resources),
        "/omnivat/example/{name:path}": partial(example_image, resources),
        "/omnivat/about": partial(about, resources, lanes),
    }
    posts: dict[str, Handler] = {
        f"/omnivat/{name}": partial(ask, resources, lanes, answer)
        for name, answer in QUESTIONS.items()
    }
    posts["/omnivat/image"] = partial(take_image, resources, lanes)
    posts["/omnivat/occlusion"] = partial(occlude, resources, lanes)
    return [
        *(Route(path, in_sentences(handler)) for path, handler in gets.items()),
        *(Route(path, in_sentences(handler), methods=["POST"]) for path, handler in posts.items()),
    ]


async def web_file(request: Request) -> Response:
    """Serve one of the page's scripts or styles; nothing else lies under that folder's name."""
    known = {path.name: path for path in WEB.iterdir() if path.suffix in TYPES}
    path = known.get(request.path_params["name"])
    if path is None:
        return refusal("The page has no such file.", 404)
    return FileResponse(path, media_type=TYPES[path.suffix], headers=FRESH)


async def frames(resources: Resources, request: Request) -> Response:
    """Serve the frames, or say how far they are (202), or why there are none (404).

    A header tells that finer frames are on their way.
    """
    state = resources.frames.state()
    step = (
        {"done": state.step.done, "total": state.step.total, "text": state.step.text}
        if (state.step)
        else None
    )
    if state.problem:
        return refusal(state.problem, 404)
    if state.file is None or "progress" in request.query_params:
        return JSONResponse({"step": step, "ready": state.file is not None}, status_code=202)
    headers = {**FRESH, "X-Frames": "coarse" if step else "fine"}
    return FileResponse(state.file, media_type="application/octet-stream", headers=headers)


async def thumbnails(resources: Resources, request: Request) -> Response:
    """Serve the sprite of thumbnails or its description; sets without one show names only."""
    sprite = resources.where.sprite
    file = {
        "webp": sprite,
        "json": sprite.with_suffix(".json") if sprite else None,
    }.get(request.path_params["kind"])
    if file is None or not file.is_file():
        return refusal("This set has no thumbnails; the page shows names instead.", 404)
    return FileResponse(file, headers=FRESH)


async def example_list(resources: Resources, _: Request) -> Response:
    """List the pairs of the gallery."""
    return JSONResponse(listed(resources.examples()))


async def example_image(resources: Resources, request: Request) -> Response:
    """Serve one image of an example: `<name>/vis` or `<name>/tac`."""
    name, _, modality = request.path_params["name"].rpartition("/")
    if modality not in ("vis", "tac"):
        return refusal("An example's image is its name and then /vis or /tac.", 404)
    file = example_named(resources.examples(), name).file(modality)
    return FileResponse(file, headers=FRESH)


async def about(resources: Resources, lanes: CapacityLimiter, _: Request) -> Response:
    """Say what is loaded."""
    return JSONResponse(await to_thread.run_sync(data.about, resources, limiter=lanes))


async def ask(
    resources: Resources, lanes: CapacityLimiter, answer: Answer, request: Request
) -> Response:
    """Answer one JSON question in a thread of its own."""
    question = question_from(await body(request, MAX_QUESTION_BYTES, "The question"))
    return JSONResponse(await to_thread.run_sync(answer, resources, question, limiter=lanes))


async def take_image(resources: Resources, lanes: CapacityLimiter, request: Request) -> Response:
    """Take the bytes of one image, embed it, and return its name and a small preview."""
    content = await body(request, MAX_IMAGE_BYTES, "The image")
    name = request.query_params.get("name", "")[:120] or "the image"

    def taken() -> dict[str, Any]:
        ref, image = resources.take_image(content, name)
        return {
            "ref": str(ref),
            "width": image.width,
            "height": image.height,
            "preview": preview(image),
        }

    return JSONResponse(await to_thread.run_sync(taken, limiter=lanes))


async def occlude(resources: Resources, lanes: CapacityLimiter, request: Request) -> Response:
    """Take the bytes of one image; say which parts of it the answer depends on."""
    asked = request.query_params
    content = await body(request, MAX_IMAGE_BYTES, "The image")
    work = partial(
        occlusion,
        resources,
        content,
        modality=asked.get("modality", ""),
        other=ref_from(asked.get("other")),
        order=order_from(_number(asked.get("order"))),
        name=asked.get("name", "")[:120] or "the image",
    )
    return JSONResponse(await to_thread.run_sync(work, limiter=lanes))


def _number(text: str | None) -> float | str | None:
    """Return the number that `text` writes; the text itself where it writes none."""
    try:
        return float(text) if text else None
    except ValueError:
        return text


async def body(request: Request, limit: int, what: str) -> bytes:
    """Return the request's bytes, reading no more than `limit` of them.

    Raises DataError when there are more.
    """
    content = bytearray()
    async for part in request.stream():
        content += part
        if len(content) > limit:
            raise DataError(
                f"{what} is larger than {limit / 1e6:.3g} MB; scale it down and try again."
            )
    return bytes(content)


def question_from(content: bytes) -> Mapping[str, Any]:
    """Return the JSON object in `content`.

    Raises DataError when it is anything else.
    """
    try:
        question = json.loads(content)
    except (ValueError, RecursionError) as error:
        raise DataError("The question is not JSON; send an object such as {} instead.") from error
    if not isinstance(question, dict):
        raise DataError("The question is not a JSON object; send one such as {} instead.")
    return question


def preview(image: "Image.Image") -> str:
    """Return a small JPEG of the image, upright, as a data URL."""
    small = image.copy()
    small.thumbnail((PREVIEW_SIDE, PREVIEW_SIDE))
    with BytesIO() as handle:
        small.save(handle, "JPEG", quality=85)
        return "data:image/jpeg;base64," + base64.b64encode(handle.getvalue()).decode()
