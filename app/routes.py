"""The page's routes: scripts, data files, and JSON requests.

Only listed files are served. Every error is one sentence. `?set=NAME` selects a head or set that
was loaded through the page.
"""

from collections.abc import Callable, Mapping
from functools import cache, partial
from pathlib import Path
from typing import Any

import orjson
from starlette.background import BackgroundTask
from starlette.requests import Request
from starlette.responses import FileResponse, JSONResponse, Response
from starlette.routing import Route

from app import about, nodes, predictors, sensor, teaching
from app.api import api_routes
from app.components import WEB
from app.familiar import familiar, first
from app.guard import is_loopback
from app.map_place import place
from app.mcp import mcp
from app.messages import Handler, in_sentences, refusal
from app.modes import mode_files, modes
from app.requests import done, question_of, set_of, visitor_of
from app.resources import Resources, require_name
from app.saving import save_figure
from app.training import Trainings
from app.uploads import upload_routes
from app.views import explore, pair
from app.visitor_sets import VisitorSets

Computed = Callable[[Resources, Mapping[str, Any]], dict[str, Any]]
QUESTIONS: dict[str, Computed] = {
    "pair": pair.predicted,
    "many": pair.many,
    "attention": pair.attention,
    "tree": nodes.tree,
    "votes": nodes.votes,
    "neighbours": explore.neighbours,
    "ladder": explore.ladder,
    "known": explore.known,
    "place": place,
    "predictions": predictors.predictions,
    "familiar": familiar,
    "profile": sensor.profile,
    "teach": teaching.teach,
    "curve": teaching.curve,
    "taught": teaching.taught_name,
}
DOWNLOADS: dict[str, Callable[[Resources, Mapping[str, Any]], bytes]] = {
    "save/set": teaching.save_set,
    "save/head": teaching.save_taught,
    "save/sensor": sensor.save_sensor,
    "save/figure": save_figure,
}
FACTS: dict[str, Callable[[Resources], Any]] = {
    "about": about.about,
    "fit": about.fit,
    "own": about.own,
    "glossary": about.glossary,
    "heads": predictors.heads,
    "modes": modes,
    "first": first,
    "pairs": explore.pairs,
    "toy": explore.mechanism,
    "unseen": explore.unseen,
    "twins": explore.twins,
    "twins/map": explore.twins_map,
    "examples": pair.gallery,
}
TYPES = {".js": "text/javascript", ".css": "text/css"}
HOLDS = "X-Holds"  # a page that was opened on another head or set shows a notice
FRESH = {"Cache-Control": "no-cache"}  # revalidate each time


def routes(first: Resources, *, api: bool = False) -> list[Route]:
    """Return all routes; each turns errors into a sentence.

    api  True opens the API for programs (app/api.py)
    """
    sets = VisitorSets(first)
    trainings = Trainings(sets)
    gets: dict[str, Handler] = {
        "/omnivat/web/{name:path}": web_file,
        "/omnivat/frames": partial(frames, sets),
        "/omnivat/thumbnails.{kind}": partial(thumbnails, sets),
        "/omnivat/example/{name:path}": partial(example_image, sets),
        "/omnivat/twins/{name}.webp": twin_picture,
        "/omnivat/real": partial(real, sets),
        "/omnivat/real/{name:path}": partial(real_picture, sets),
        **{f"/omnivat/{name}": partial(facts, sets, found) for name, found in FACTS.items()},
    }
    questions = {**QUESTIONS, "trainings": trainings.offers, "train": trainings.start}
    posts: dict[str, Handler] = {
        **{
            f"/omnivat/{name}": partial(compute, sets, computed)
            for name, computed in questions.items()
        },
        **{f"/omnivat/{name}": partial(download, sets, made) for name, made in DOWNLOADS.items()},
        "/omnivat/training": partial(look, trainings.state),
        "/omnivat/training/cancel": partial(look, trainings.cancel),
        "/omnivat/save/trained": partial(saved, sets, trainings),
        **upload_routes(sets),
    }
    return [
        *(Route(path, in_sentences(handler)) for path, handler in gets.items()),
        *(Route(path, in_sentences(handler), methods=["POST"]) for path, handler in posts.items()),
        *api_routes(sets, partial(mcp, sets), opened=api),
    ]


async def web_file(request: Request) -> Response:
    """Serve one of the page's scripts or styles, and no other file of the folder."""
    path = web_files().get(request.path_params["name"])
    if path is None:
        return refusal("The page has no such file.", 404)
    return file_response(request, path, media_type=TYPES[path.suffix])


@cache
def web_files() -> dict[str, Path]:
    """Return the page's scripts and styles by their names in URLs."""
    return {p.relative_to(WEB).as_posix(): p for p in WEB.rglob("*") if p.suffix in TYPES}


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

    A header marks frames of which finer ones will follow. Then head and set load, so that the first
    request is fast.
    """
    resources = set_of(sets, request)
    if mode := request.query_params.get("mode", ""):  # another one than the loaded head's
        file = mode_files(resources.where).get(mode)
        if file is None:
            return refusal(f"There are no frames of the kind '{mode:.20}' beside this set.", 404)
        return frames_response(request, resources, file, {"X-Frames": "fine"})
    name = request.query_params.get("head", "")
    require_name(name, resources.frame_jobs)
    state = resources.frame_jobs[name].state()
    if state.problem:
        return refusal(state.problem, 404)
    if state.file is None or "progress" in request.query_params:
        step = state.step and {
            "done": state.step.done,
            "total": state.step.total,
            "text": ", ".join(filter(None, (state.step.text, state.step.left))),
        }
        return JSONResponse({"step": step, "ready": state.file is not None}, status_code=202)
    headers = {
        "X-Frames": "coarse" if state.step else "fine",
        "X-Thumbnails": "sheet" if sheet(resources) else "none",
    }
    return frames_response(
        request, resources, state.file, headers, background=BackgroundTask(resources.warm)
    )


def frames_response(
    request: Request, resources: Resources, file: Path, headers: Mapping[str, str], **options: Any
) -> Response:
    """Serve frames under the name of head and set."""
    headers = {HOLDS: resources.holds, **headers}
    return file_response(request, file, headers, media_type="application/octet-stream", **options)


async def thumbnails(sets: VisitorSets, request: Request) -> Response:
    """Serve the thumbnail sheet or its description; sets without one show names only."""
    sprite = sheet(set_of(sets, request))
    file = {"webp": sprite, "json": sprite.with_suffix(".json") if sprite else None}.get(
        request.path_params["kind"]
    )
    if file is None:
        return refusal("This set has no thumbnails; the page shows names instead.", 404)
    return file_response(request, file)


def sheet(resources: Resources) -> Path | None:
    """Return the set's sheet of thumbnails; None if it has none."""
    sprite = None if resources.drawn() else resources.where.sprite  # its pairs are in another order
    return sprite if sprite and sprite.is_file() and sprite.with_suffix(".json").is_file() else None


async def twin_picture(request: Request) -> Response:
    """Serve a sheet of the twins' pictures."""
    file = explore.twin_pictures().get(f"{request.path_params['name']}.webp")
    if file is None:
        return refusal("There is no such sheet of pictures.", 404)
    return file_response(request, file)


async def example_image(sets: VisitorSets, request: Request) -> Response:
    """Serve one image of an example: `<name>/vis` or `<name>/tac`."""
    name, _, modality = request.path_params["name"].rpartition("/")
    if modality not in ("vis", "tac"):
        return refusal("An example's image is its name and then /vis or /tac.", 404)
    file = set_of(sets, request).example(name, modality)
    if not file.is_file():
        return refusal("This example's image is no longer there; reload the page.", 404)
    return file_response(request, file)


async def real(sets: VisitorSets, request: Request) -> Response:
    """Return the fetched sets of real pairs with their terms."""
    listing = partial(sets.shared.real.listing, local=is_loopback(visitor_of(request)))
    return JSONResponse(await done(request, sets.shared.jobs, lambda _: listing()))


async def real_picture(sets: VisitorSets, request: Request) -> Response:
    """Serve a picture of a fetched set."""
    local = is_loopback(visitor_of(request))
    return file_response(
        request, sets.shared.real.picture(request.path_params["name"], local=local)
    )


def in_json(value: Any, resources: Resources) -> Response:
    """Return a JSON response; non-finite values, from a damaged head, are an error."""
    headers = {HOLDS: resources.holds}
    try:
        content = orjson.dumps(value)
    except TypeError:  # half of a surrogate pair, an integer beyond 64 bits
        content = b"null"
    try:
        if b"null" in content:  # orjson writes NaN like None; json tells them apart
            return JSONResponse(value, headers=headers)
        return Response(content, media_type="application/json", headers=headers)
    except ValueError:
        return refusal(
            "The head gives values that are not finite numbers; its weights are damaged. Train it"
            " again."
        )


async def facts(
    sets: VisitorSets, compute: Callable[[Resources], Any], request: Request
) -> Response:
    """Return facts about the loaded head and set."""
    resources = set_of(sets, request)
    return in_json(await done(request, sets.shared.jobs, lambda _: compute(resources)), resources)


async def compute(sets: VisitorSets, computed: Computed, request: Request) -> Response:
    """Run one JSON request as a job."""
    resources, question = set_of(sets, request), await question_of(request)
    return in_json(
        await done(request, sets.shared.jobs, lambda _: computed(resources, question)), resources
    )


async def download(
    sets: VisitorSets, made: Callable[[Resources, Mapping[str, Any]], bytes], request: Request
) -> Response:
    """Return a file for one JSON request: a zip, or a page of figures."""
    resources, question = set_of(sets, request), await question_of(request)
    content = await done(request, sets.shared.jobs, lambda _: made(resources, question))
    return Response(content, media_type="text/html" if made is save_figure else "application/zip")


async def look(state: Callable[[Mapping[str, Any]], dict[str, Any]], request: Request) -> Response:
    """Return the state of a training, at once."""
    return JSONResponse(state(await question_of(request)))


async def saved(sets: VisitorSets, trainings: Trainings, request: Request) -> Response:
    """Return a finished head as a zip, even if the set of the address is gone."""
    question = await question_of(request)
    content = await done(request, sets.shared.jobs, lambda _: trainings.saved(question))
    return Response(content, media_type="application/zip")
