"""`python -m omnivat export`: pictures, or Explore as one HTML file."""

import base64
import json
import re
from collections.abc import Mapping
from pathlib import Path
from posixpath import normpath
from typing import Any

from app.serving.routes import FACTS, PROJECT_FILES
from app.shared.components import EXPLORE, STYLES, WEB, html_of
from app.shared.fit import fit
from app.shared.modes import fitting_files, modes
from app.shared.places import Places
from app.shared.resources import Resources
from app.shared.saving import column_of
from app.shared.tables import tables_html
from omnivat.kit.errors import DataError
from omnivat.kit.files import write_text
from omnivat.kit.progress import OnStep, Step, ignore

IMPORT = re.compile(r'(\bfrom\s+|\bimport\s+|\bimport\()"(\.{1,2}/[\w./-]+\.js)"')
KINDS = {".js": "text/javascript", ".json": "application/json", ".webp": "image/webp"}
PREFIX = "omnivat-web/"  # a bare name, which an import map can resolve to a data: address
HEADER = "header/header.js"

PAGE = """<!doctype html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width">
{head}
</head>
<body{kind}><div class="gradio-container"><div class="main app"><main>
<div id="omnivat-header">{header}</div>
{body}
</main></div></div>
<script type="application/json" id="omnivat-held">{held}</script>
{scripts}</body></html>
"""
ALONE = "This page is a single file without a server, so this does not work here."
SCRIPTS = f"""<script type="importmap">{{modules}}</script>
<script type="module">
import {{{{ start }}}} from "{PREFIX}{EXPLORE}";
import {{{{ start as startHeader }}}} from "{PREFIX}{HEADER}";
document.body.classList.toggle("dark", matchMedia("(prefers-color-scheme: dark)").matches);
startHeader(document.querySelector("#omnivat-header"));
start(document.querySelector("#view-explore"));
</script>"""


def frames_file(where: Places, on_step: OnStep = ignore) -> Path:
    """Return the frames of a head and a set; compute them if there is no file, or raise
    DataError with the reason.
    """
    job = Resources(where).frames
    if where.frames is None:
        on_step(Step(done=0, total=1, text="frames, which may take minutes"))
    state = job.wait()
    if state.file is None:
        raise DataError(state.problem)
    return state.file


def export_picture(
    where: Places,
    frames: Path,
    out: Path,
    *,
    what: str,
    order: float | None,
    stage: str,
    kind: str,
    colour: str,
) -> None:
    """Write the map or the curves at an order (None: the learned one) as HTML, SVG, PNG or Plotly's
    JSON.

    Raises SettingsError for an unknown map, colouring or ending.
    """
    from omnivat.figures import frames_map, gap_curves, write
    from omnivat.maps.frames import read_frames

    found = read_frames(frames)
    at = float(found.head.get("learned_order") or 0.5) if order is None else order
    if what == "curves":
        figure = gap_curves(found, stage=stage, order=at)
    else:
        column = column_of(Resources(where), colour)
        figure = frames_map(found, order=at, stage=stage, kind=kind, colour=colour, column=column)
    write(out, figure)


def export_page(where: Places, frames: Path, out: Path) -> None:
    """Write Explore with all its frames and thumbnails as one HTML file, which needs no server.

    Features that need one show a note.
    """
    from omnivat.maps.frames import read_frames

    found = read_frames(frames)
    title = (
        f"{found.pairs} VIS-TAC pairs of {len(found.domains)} domains, {len(found.orders)} stops"
        " of p"
    )
    styles = "\n".join((WEB / f"{name}.css").read_text(encoding="utf-8") for name in STYLES)
    page = document(
        head=f"<title>OmniVaT: {title}</title>\n<style>{styles}</style>\n{tables_html()}",
        kind=' class="saved"',
        body=f'<div id="view-explore">{html_of("explore")}</div>',
        held={"files": held_files(where, frames), "home": "", "alone": ALONE},
        scripts=SCRIPTS.format(modules=json.dumps({"imports": scripts()})),
    )
    write_text(out, page)


def document(*, held: Mapping[str, Any], **parts: str) -> str:
    """Return a page of the parts head, kind (attributes of the body), body and scripts.

    held   what its scripts have instead of a server; see `app/web/shared/held.js`
    """
    index = json.dumps(held, ensure_ascii=False, separators=(",", ":")).replace("</", "<\\/")
    return PAGE.format(held=index, header=html_of("header"), **parts)


def held_files(where: Places, frames: Path) -> dict[str, str]:
    """Return all server data of a saved page, by request, as data: addresses."""
    resources = Resources(where)
    fits = not fit(resources)["problem"]
    named = ("pairs", "toy", "fit", *(["unseen"] if fits else []))
    facts = {f"/{name}": FACTS[name](resources) for name in named}
    facts["/modes"] = modes(resources, among=())
    files = set_files(resources, frames) | {"/glossary": PROJECT_FILES["glossary"]}
    return {
        **{name: data_address(file.read_bytes(), file.suffix) for name, file in files.items()},
        **{name: data_address(json.dumps(fact).encode(), ".json") for name, fact in facts.items()},
    }


def set_files(resources: Resources, frames: Path) -> dict[str, Path]:
    """Return the files of a set that the server serves unchanged, by request."""
    found = {"/frames": frames}
    found |= {f"/frames?mode={mode}": file for mode, file in fitting_files(resources).items()}
    if (drawn := resources.sheet) is not None:
        found |= {f"/thumbnails{kind}": drawn.with_suffix(kind) for kind in (".webp", ".json")}
    return found


def scripts() -> dict[str, str]:
    """Return every script that Explore and its tour need, by bare name, as a data: address."""
    found: dict[str, str] = {}
    waiting = [EXPLORE, HEADER]
    while waiting:
        name = waiting.pop()
        if PREFIX + name in found:
            continue
        source = (WEB / name).read_text(encoding="utf-8")
        folder = name.rpartition("/")[0]
        for line, start, wanted in dict.fromkeys(
            match.group(0, 1, 2) for match in IMPORT.finditer(source)
        ):
            beside = normpath(f"{folder}/{wanted}")  # below `web`
            waiting.append(beside)
            source = source.replace(line, f'{start}"{PREFIX}{beside}"')
        found[PREFIX + name] = data_address(source.encode(), ".js")
    return found


def data_address(content: bytes, suffix: str) -> str:
    """Return the content as a data: address."""
    kind = KINDS.get(suffix, "application/octet-stream")
    return f"data:{kind};base64," + base64.b64encode(content).decode()
