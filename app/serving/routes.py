"""The page's routes: scripts, data files, and JSON requests.

Only listed files are served. Every error is one sentence. `?set=NAME` selects a head or set that
was loaded through the page.
"""

from collections.abc import AsyncIterator, Awaitable, Callable, Mapping
from functools import cache, partial
from gzip import compress
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from starlette.background import BackgroundTask
from starlette.concurrency import run_in_threadpool
from starlette.middleware.gzip import GZipMiddleware
from starlette.requests import Request
from starlette.responses import FileResponse, JSONResponse, Response, StreamingResponse
from starlette.routing import Route
from starlette.types import Receive, Scope, Send

from app.explore import nodes, predictors
from app.explore import tab as explore
from app.pair import pictures, sensor, sensor_card, teaching, touch_relief
from app.pair import tab as pair
from app.serving import about
from app.serving.api import api_routes
from app.serving.guard import is_loopback
from app.serving.mcp import mcp
from app.shared.components import WEB
from app.shared.familiar import familiar, first
from app.shared.fit import fit
from app.shared.frame_parts import HEAD, part_of, tag_of
from app.shared.limits import MAX_IMAGE_BYTES, PARTS
from app.shared.map_place import journey
from app.shared.messages import Handler, in_sentences, readable, refusal
from app.shared.modes import mode_files, modes
from app.shared.requests import asked, done, received, set_of, visitor_of
from app.shared.resources import Resources, require_name
from app.shared.saving import head_zip, save_figure
from app.shared.state import VISITOR, InTwo, Reply
from app.shared.visitor_sets import VisitorSets
from omnivat.head.heads import EXAMPLES
from omnivat.kit.errors import OmniVatError

Find = Callable[..., Path | None]  # of the resources and the parts of an address
Work = Callable[..., Any]  # of the resources and a question; a JSON value, or the bytes of a file


def real(resources: Resources) -> Reply:
    """Return the fetched sets of real pairs with their terms."""
    return resources.shared.real.listing(local=is_loopback(VISITOR.get()))


def head_file(resources: Resources) -> bytes:
    """Return a zip of a head that was trained here."""
    return head_zip(resources.head(), "trained-head")


QUESTIONS: dict[str, Work] = {
    "pair": pair.answered,
    "many": pair.many,
    "rivals": pair.rivals,
    "attention": pair.attention,
    "tree": nodes.tree,
    "votes": nodes.votes,
    "neighbours": explore.neighbours,
    "known": explore.known,
    "journey": journey,
    "predictions": predictors.predictions,
    "familiar": familiar,
    "profile": sensor.profile,
    "teach": teaching.teach,
    "curve": teaching.curve,
    "taught": teaching.taught,
    "live": pictures.live,
    "occlusion": pictures.occlusion,
    "relief": touch_relief.relief,
    "card": sensor_card.card,
    "save/set": teaching.save_set,
    "save/head": teaching.save_taught,
    "save/sensor": sensor.save_sensor,
    "save/figure": save_figure,
}
FACTS: dict[str, Work] = {  # questions without anything in them
    "about": about.about,
    "fit": fit,
    "own": about.own,
    "heads": predictors.heads,
    "modes": modes,
    "first": first,
    "pairs": explore.pairs,
    "toy": explore.mechanism,
    "unseen": explore.unseen,
    "ladder": explore.ladder,
    "examples": pair.gallery,
}
# of those that come many a second, or take seconds
PRIORITIES: dict[Work, int] = {pictures.live: 0, pictures.occlusion: 2}
LATER = 2  # of the rest of a reply, for which predictions of others do not wait
SERVED: dict[str, Work] = {"real": real, "head.zip": head_file}  # of no use without a server
# what comes as a file in the body: its work, priority and largest size
SENT: dict[str, tuple[Work, int, int]] = {
    "image": (pictures.taken, 1, MAX_IMAGE_BYTES),
    "sensor": (sensor.load_sensor, 0, PARTS["profile.safetensors"]),
}
PROJECT_FILES = {  # the same for every set
    "glossary": WEB / "shared" / "glossary.json",
    "twins": EXAMPLES / "twins.json",
    "twins/map": EXAMPLES / "twins.map.json",
    **{f"twins/{file.name}": file for file in sorted((EXAMPLES / "twins").glob("*.webp"))},
}
PACKED = {"/", *(f"/omnivat/{name}" for name in (*FACTS, "glossary", "twins", "twins/map"))}
MISSING = "There is no such file here; the page goes on without it."
TYPES = {".js": "text/javascript", ".css": "text/css"}
DAMAGED = (
    "The head gives values that are not finite numbers; its weights are damaged. Train it again."
)
HOLDS = "X-Holds"  # a page that was opened on another head or set shows a notice
FRESH = {"Cache-Control": "no-cache"}  # revalidate each time


class Packed(GZipMiddleware):
    """Packs the page and the facts: Gradio packs only what is named .js, .css or .json."""

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve a request."""
        path = scope.get("path", "").removeprefix(scope.get("root_path", ""))
        await (super().__call__ if path in PACKED else self.app)(scope, receive, send)


def routes(sets: VisitorSets, *, api: bool = False) -> list[Route]:
    """Return all routes; each turns errors into a sentence.

    api  True opens the API for programs (app/serving/api.py)
    """
    files: dict[str, Find] = {
        "web/{name:path}": lambda _, name: web_files().get(name),
        "thumbnails.{kind}": thumbnails,
        "example/{name:path}/{modality}": Resources.example,
        "plotly.js": lambda _: plotly(),
        **{name: lambda _, path=path: path for name, path in PROJECT_FILES.items()},
    }
    gets: dict[str, Handler] = {
        **{name: partial(file, sets, find) for name, find in files.items()},
        "frames": partial(frames, sets),
        "real/{name:path}": partial(real_picture, sets),
        **{name: partial(compute, sets, work) for name, work in (FACTS | SERVED).items()},
    }
    sent = {**SENT, "part": (sets.take_part, 1, max(PARTS.values()))}
    posts: dict[str, Handler] = {
        **{name: partial(compute, sets, work) for name, work in QUESTIONS.items()},
        "load": partial(compute, sets, sets.load, priority=1),
        **{name: partial(of_file, sets, *row) for name, row in sent.items()},
    }
    return [
        Route(f"/omnivat/{name}", in_sentences(handler), methods=[method])
        for method, handlers in (("GET", gets), ("POST", posts))
        for name, handler in handlers.items()
    ] + api_routes(sets, partial(mcp, sets), opened=api)


async def compute(
    sets: VisitorSets, work: Work, request: Request, *, priority: int = 0
) -> Response:
    """Run one request as a job: with the question in its body, or a fact without one."""
    resources, jobs = set_of(sets, request), sets.shared.jobs
    if request.method == "GET":
        reply = await done(request, jobs, partial(work, resources), priority=priority)
        return as_sent(reply, {HOLDS: resources.holds})
    async with asked(request, sets.shared.scratch) as read:
        priority = PRIORITIES.get(work, 1 if request.query_params.get("sizes") else priority)
        reply = await done(
            request,
            jobs,
            lambda: pictures.with_pictures(work, resources, read()),
            priority=priority,
        )
    if isinstance(reply, InTwo):
        rest = partial(done, request, jobs, reply.rest, priority=LATER)
        return in_two(as_sent(reply.first, {HOLDS: resources.holds}), rest)
    return as_sent(reply, {HOLDS: resources.holds})


def in_two(first: Response, rest: Callable[[], Awaitable[Reply]]) -> Response:
    """Return a reply whose first line is sent before the rest is computed; a problem of the rest is
    its line.
    """
    if first.status_code != 200:
        return first

    async def lines() -> AsyncIterator[bytes]:
        yield bytes(first.body) + b"\n"
        try:
            more = JSONResponse(await rest())
        except OmniVatError as error:
            more = JSONResponse({"problem": readable(str(error))})
        except ValueError:
            more = JSONResponse({"problem": DAMAGED})
        yield bytes(more.body)

    headers = {HOLDS: first.headers[HOLDS]}
    return StreamingResponse(lines(), headers=headers, media_type="application/x-ndjson")


async def of_file(
    sets: VisitorSets, work: Work, priority: int, largest: int, request: Request
) -> Response:
    """Run one request on the file in its body, with the parameters of its address; the file is not
    kept.
    """
    resources, question = set_of(sets, request), request.query_params
    async with received(request, sets.shared.scratch, largest, "The file") as file:
        computed = partial(work, resources, file, question)
        return as_sent(await done(request, sets.shared.jobs, computed, priority=priority))


def as_sent(value: Any, headers: Mapping[str, str] = FRESH) -> Response:
    """Return a response of a file's bytes or of a JSON value; non-finite numbers, from a damaged
    head, are an error.
    """
    if isinstance(value, bytes):
        page = value.startswith(b"<!")
        return Response(value, media_type="text/html" if page else "application/octet-stream")
    try:
        return JSONResponse(value, headers=headers)
    except ValueError:
        return refusal(DAMAGED)


async def file(sets: VisitorSets, find: Find, request: Request) -> Response:
    """Serve one of the page's files, and no other file of its folder."""
    path = find(set_of(sets, request), **request.path_params)
    if path is None or not path.is_file():
        return refusal(MISSING, 404)
    return file_response(request, path, media_type=TYPES.get(path.suffix))


@cache
def web_files() -> dict[str, Path]:
    """Return the page's scripts and styles by their names in URLs."""
    return {p.relative_to(WEB).as_posix(): p for p in WEB.rglob("*") if p.suffix in TYPES}


def plotly() -> Path | None:
    """Return the script of Plotly, which the page loads for a figure in three dimensions."""
    found = find_spec("plotly")
    return (
        Path(found.origin).parent / "package_data/plotly.min.js" if found and found.origin else None
    )


def file_response(
    request: Request, file: Path, headers: Mapping[str, str] = FRESH, **options: Any
) -> Response:
    """Serve a file with `headers`, or 304 if the browser has the current version."""
    headers = {**FRESH, **headers}
    sent = FileResponse(file, stat_result=file.stat(), headers=headers, **options)
    tag = sent.headers["etag"]
    if tag not in request.headers.get("if-none-match", ""):
        return sent
    return Response(
        status_code=304, headers={**headers, "ETag": tag}, background=options.get("background")
    )


async def frames(sets: VisitorSets, request: Request) -> Response:
    """Serve the frames of a head, or their progress (202), or the reason of a failure (404).

    `part` names one part of them, as `app.shared.frame_parts` has it; `of` the version of the file
    that it has to belong to. A header marks frames of which finer ones will follow. Then head and
    set load, so that the first request is fast.
    """
    resources = set_of(sets, request)
    headers, after = {HOLDS: resources.holds, "X-Frames": "fine"}, None
    if mode := request.query_params.get("mode", ""):  # another one than the loaded head's
        file = mode_files(resources.where).get(mode)
        if file is None:
            return refusal(f"There are no frames of the kind '{mode:.20}' beside this set.", 404)
    else:
        name = request.query_params.get("head", "")
        require_name(name, resources.frame_jobs)
        state = resources.frame_jobs[name].state()
        if state.problem:
            return refusal(state.problem, 404)
        file = state.file
        if file is None or "progress" in request.query_params:
            step = state.step and {
                "done": state.step.done,
                "total": state.step.total,
                "text": ", ".join(filter(None, (state.step.text, state.step.left))),
            }
            return JSONResponse({"step": step, "ready": file is not None}, status_code=202)
        headers["X-Frames"] = "coarse" if state.step else "fine"
        headers["X-Thumbnails"] = "sheet" if resources.sheet else "none"
        after = BackgroundTask(resources.warm)
    if part := request.query_params.get("part", ""):
        return await frame_part(request, file, part, headers, after)
    binary = "application/octet-stream"
    return file_response(request, file, headers, media_type=binary, background=after)


async def frame_part(
    request: Request,
    file: Path,
    part: str,
    headers: Mapping[str, str],
    background: BackgroundTask | None,
) -> Response:
    """Serve one part of a frames file, packed where that makes it smaller; 304 if the browser has
    it.
    """
    query = request.query_params
    tag = f'"{tag_of(file)}-{part}"'
    headers = {**FRESH, **headers, "ETag": tag, "Vary": "Accept-Encoding"}
    if query.get("of", tag_of(file)) != tag_of(file):
        return refusal("These frames were computed again; the new ones follow.", 410)
    if tag in request.headers.get("if-none-match", ""):
        return Response(status_code=304, headers=headers, background=background)
    start = query.get("from", "0")
    number = int(start) if start.isascii() and start.isdigit() and len(start) < 6 else -1
    content = await run_in_threadpool(part_of, file, part, number)
    if not part.startswith("map:") and "gzip" in request.headers.get("accept-encoding", ""):
        content = await run_in_threadpool(partial(compress, content, 6, mtime=0))
        headers["Content-Encoding"] = "gzip"
    kind = "application/json" if part == HEAD else "application/octet-stream"
    return Response(content, headers=headers, media_type=kind, background=background)


def thumbnails(resources: Resources, kind: str) -> Path | None:
    """Return the thumbnail sheet or its description; None for a set without one."""
    found = resources.sheet
    return found.with_suffix(f".{kind}") if found and kind in ("webp", "json") else None


async def real_picture(sets: VisitorSets, request: Request) -> Response:
    """Serve a picture of a fetched set."""
    local = is_loopback(visitor_of(request))
    return file_response(
        request, sets.shared.real.picture(request.path_params["name"], local=local)
    )
