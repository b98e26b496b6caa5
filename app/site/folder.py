"""`python -m omnivat export --site DIR`: the page as a folder for any plain file server.

The folder holds the page's own scripts, the server's replies that are always the same, as files
named by their content, and the models with which the browser computes the others. Only `index.html`
and `sw.js` keep their names from one export to the next.
"""

import json
from collections.abc import Callable, Container, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from html import escape
from importlib import import_module
from pathlib import Path
from typing import Any
from urllib.parse import urlencode, urlsplit

from app.explore.predictors import METHODS
from app.serving.routes import FACTS, PROJECT_FILES, QUESTIONS, web_files
from app.shared.components import VIEWS, WEB, head, html_of, needed
from app.shared.frame_parts import HEAD, parts_of
from app.shared.messages import without_places
from app.shared.modes import modes
from app.shared.places import Places
from app.shared.resources import Resources
from app.shared.state import content_name
from app.shared.visitor_sets import VisitorSets
from app.site.export import document, frames_file, set_files
from app.site.models import files_in, write_models
from omnivat.head.heads import shipped_sets
from omnivat.kit.errors import DataError, SettingsError, WriteError
from omnivat.kit.files import replacing_folder, require_writable, write_text
from omnivat.kit.progress import OnStep, Step, ignore

MARK = "omnivat-site.json"  # lists the files of an export, so that the next one replaces only these
OWN = "own"  # the set of a head or embeddings that are not the project's
ALONE = "This needs Python: run `python -m pip install -r requirements.txt`, then `python app.py`."
UNSTARTED = (
    "This page needs a browser with JavaScript modules, and a file server: run "
    "<code>python -m http.server</code> in its folder and open <code>http://localhost:8000</code>."
)
SCRIPTED = tuple(name for name in VIEWS if (WEB / name).is_dir())  # Gradio lays out the other tabs
UNSCRIPTED = f'<p class="ov wait problem">{escape(ALONE)}</p>'
POLICY = "; ".join(
    (
        "default-src 'none'",
        "script-src 'self' 'wasm-unsafe-eval'",
        "style-src 'self' 'unsafe-inline'",
        "img-src 'self' data: blob:",
        "media-src 'self' blob:",
        "connect-src 'self' data: blob:",
        "worker-src 'self' blob:",
        "base-uri 'none'",
        "form-action 'none'",
    )
)


@dataclass(slots=True)
class Files:
    """The files of a site as they are written, and what its scripts look up."""

    folder: Path
    names: dict[str, str] = field(default_factory=dict)  # request -> file
    refused: dict[str, str] = field(default_factory=dict)  # request -> sentence

    def add(self, request: str, content: bytes, suffix: str) -> None:
        """Write the reply to a request under a name of its content."""
        stem = "".join(c if c.isascii() and c.isalnum() else "-" for c in request.split("?")[0])
        file = f"data/{stem[:60].strip('-')}-{content_name(content)[:8]}{suffix}"
        put(self.folder / file, content)
        self.names[request] = file


def export_site(
    where: Places,
    out: Path,
    sets: Sequence[str] | None = None,
    *,
    models: bool = True,
    runtime: Path | None = None,
    on_step: OnStep = ignore,
) -> dict[str, int]:
    """Write the page with its sets as a folder; it appears completely or not at all.

    where    head and set with which the page opens
    sets     names of the project's sets beside it; None: all
    models   whether the browser computes predictions and trees
    runtime  a folder with the npm package onnxruntime-web for that; None: it is fetched
    return   file -> bytes

    A folder that an earlier export wrote is replaced; what was added to it stays. Raises WriteError
    for any other folder that is not empty, SettingsError for an unknown set, DataError if head and
    set do not fit.
    """
    there = earlier_files(out)
    desks = visitor_sets(where, sets)
    with replacing_folder(out) as made:
        name = write_models(desks, made, runtime, on_step) if models else ""
        fill(made, desks, name, on_step)
        sizes = {p.relative_to(made).as_posix(): p.stat().st_size for p in files_in(made)}
        write_text(made / MARK, json.dumps({"files": sorted(sizes)}, indent=0))
        for file in files_in(out) if out.is_dir() else ():
            name = file.relative_to(out).as_posix()
            if name not in there and not (made / name).exists():
                put(made / name, file.read_bytes())
    return sizes


def earlier_files(out: Path) -> set[str]:
    """Return the files of an earlier export in `out`; raise WriteError if it is something else."""
    if not out.exists():
        require_writable(out)
        return set()
    if not out.is_dir():
        raise WriteError(f"'{out}' is a file; name a folder for the site.")
    if out.is_symlink() or out.resolve() == Path.cwd():
        raise WriteError(f"'{out}' is a link or the folder in use; name another one for the site.")
    if not any(out.iterdir()):
        return set()
    try:
        return {MARK, *json.loads((out / MARK).read_text(encoding="utf-8"))["files"]}
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise WriteError(
            f"'{out}' holds files that no export wrote; name an empty or a new folder."
        ) from error


def visitor_sets(where: Places, sets: Sequence[str] | None) -> dict[str, Resources]:
    """Return the sets of a site by name, the one it opens with first."""
    known = shipped_sets()
    if unknown := set(sets or ()) - set(known):
        raise SettingsError(f"No set is called '{min(unknown):.40}'; there are {', '.join(known)}.")
    desks = VisitorSets(Resources(where))
    home = next((name for name in known if desks.named(name) is desks.first), OWN)
    return {home: desks.first} | {
        n: desks.named(n) for n in (known if sets is None else sets) if n != home
    }


def fill(folder: Path, desks: Mapping[str, Resources], models: str, on_step: OnStep) -> None:
    """Write the files of the site beside its `models`."""
    files = Files(folder)
    for done, (name, resources) in enumerate(desks.items()):
        for request, reply in replies(resources, desks):
            on_step(Step(done=done, total=len(desks), text=f"{name}: {request}"))
            try:
                text = json.dumps(reply(), allow_nan=False, separators=(",", ":"))
            except DataError as error:
                files.refused[f"{name}/{request}"] = without_places(str(error))
            else:
                files.add(f"{name}/{request}", text.encode(), ".json")
        for request, file in whole_files(resources, on_step).items():
            if not request.startswith("/frames"):
                files.add(f"{name}{request}", file.read_bytes(), file.suffix)
                continue
            mode = urlsplit(request).query
            for part, content in parts_of(file):  # each map is fetched when it is shown
                query = f"{mode}{'&' * bool(mode)}{urlencode({'part': part})}"
                files.add(f"{name}/frames?{query}", content, ".json" if part == HEAD else ".bin")
    web = write_scripts(folder)
    held = {
        "files": files.names,
        "refused": files.refused,
        "home": next(iter(desks)),
        "sets": list(desks),
        "alone": ALONE,
        "local": "../site/local.js" if models else "",
        "models": models,
    }
    write_text(folder / "index.html", page(web, held))
    write_text(folder / "sw.js", worker(folder))


def replies(
    resources: Resources, desks: Container[str]
) -> Iterator[tuple[str, Callable[[], dict[str, Any]]]]:
    """Yield the requests about a set whose replies are always the same, each with its function."""
    for name, found in FACTS.items():
        yield (
            name,
            partial(modes, resources, desks) if name == "modes" else partial(found, resources),
        )
    for path, question in (
        ("votes", {"head": ""}),
        *(("predictions", {"method": method}) for method in METHODS),
        *(
            ("journey", {"vis": ref, "tac": ref, "head": ""})
            for ref in (f"example:{name}" for name in resources.example_rows())
        ),
    ):
        body = json.dumps(question, ensure_ascii=False, separators=(",", ":"))
        yield f"{path} {body}", partial(QUESTIONS[path], resources, question)


def whole_files(resources: Resources, on_step: OnStep) -> dict[str, Path]:
    """Return the files of a set, by request: frames, thumbnails, pictures of the examples."""
    found = set_files(resources, frames_file(resources.where, on_step))
    found |= {f"/{name}": file for name, file in PROJECT_FILES.items() if file.is_file()}
    for name, images in resources.examples().items():
        found |= {f"/example/{name}/{modality}": file for modality, file in images.items()}
    return found


def write_scripts(folder: Path) -> str:
    """Copy the page's scripts and styles; return their folder, named by their content."""
    web = {name: file.read_bytes() for name, file in sorted(web_files().items())}
    web["shared/icon.svg"] = (WEB / "shared" / "icon.svg").read_bytes()
    place = f"web-{content_name(repr(web).encode())[:8]}"
    for name, content in web.items():
        put(folder / place / name, content)
    return place


def page(web: str, held: Mapping[str, Any]) -> str:
    """Return the page: all tabs, of which the script opens one."""
    buttons, panels = "", []
    for name in VIEWS:
        title, tab = escape(import_module(f"app.{name}.tab").TITLE), f'id="view-{name}'
        buttons += (
            f'<button type="button" role="tab" {tab}-button"'
            f' aria-controls="view-{name}">{title}</button>'
        )
        panels.append(
            f'<div {tab}" role="tabpanel" aria-labelledby="view-{name}-button"'
            f" hidden>{html_of(name) if name in SCRIPTED else UNSCRIPTED}</div>"
        )
    early = "".join(f'<link rel="modulepreload" href="{web}/{name}">' for name in needed())
    return document(
        head=f"""<meta http-equiv="Content-Security-Policy" content="{POLICY}">
<title>OmniVaT</title>
<link rel="icon" href="{web}/shared/icon.svg">
{head(VIEWS, web)}
{early}
<link rel="stylesheet" href="{web}/site/site.css">""",
        kind=' class="site"',
        body=f"""<p class="ov wait problem unstarted">{UNSTARTED}</p>
<p class="ov on-its-way" role="status" hidden></p>
<div class="tab-wrapper"><div class="tab-container" role="tablist">{buttons}</div></div>
{chr(10).join(panels)}""",
        held=held,
        scripts=f'<script type="module" src="{web}/site/start.js"></script>\n',
    )


def worker(folder: Path) -> str:
    """Return the service worker with the names of its files: first, of any visit; rest, fetched
    once that has begun.
    """
    names = sorted(p.relative_to(folder).as_posix() for p in files_in(folder) if p.parent != folder)
    first = [name for name in names if name.startswith("web-")]
    rest = sorted(
        (name for name in names if not name.startswith("web-")),
        key=lambda name: "-example-" in name,
    )
    kept = {"first": first, "rest": rest}
    script = (WEB / "site" / "sw.js").read_text(encoding="utf-8")
    return f"globalThis.omnivatSite = {json.dumps(kept)};\n{script}"


def put(file: Path, content: bytes) -> None:
    """Write a file and its folders."""
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_bytes(content)
