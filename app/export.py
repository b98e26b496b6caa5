"""`python -m omnivat export`: pictures, or Explore as one HTML file."""

import base64
import json
import re
from functools import partial
from pathlib import Path
from posixpath import normpath

from app.components import WEB
from app.curve_pictures import curves_picture
from app.drawing import write_picture
from app.modes import fitting_files, modes
from app.pictures import map_picture
from app.places import Places, places
from app.resources import Resources
from app.theme import STYLES
from app.views import explore
from omnivat.errors import DataError
from omnivat.files import write_text
from omnivat.progress import OnStep, Step, ignore

IMPORT = re.compile(r'(\bfrom\s+|\bimport\s+|\bimport\()"(\.{1,2}/[\w./]+\.js)"')
PREFIX = "omnivat-web/"  # a bare name, which an import map can resolve to a data: address
FIRST, TOUR = "explore/explore.js", "header/tour.js"

PAGE = """<!doctype html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width">
<title>OmniVaT: {title}</title>
<style>
body {{ margin: 0; background: var(--ov-page); }}
.saved .tool.link, .saved .card .open, .saved .card .near {{ display: none; }}
{styles}
</style></head>
<body class="saved"><div class="gradio-container"><div class="main app"><main>
<header class="ov top"><div class="name"><h1>OmniVaT</h1><p>{title}</p></div><div class="marks">
<span class="badge" {badge}>simulated<span class="long"> data</span></span>
<button type="button" class="tour-start">Guided tour</button>
<button type="button" class="theme" aria-label="Switch between light and dark">&#9680;</button>
</div></header>
<div id="explore">{explore}</div></main></div></div>
<script>globalThis.omnivatHeld = {held};</script>
<script type="importmap">{modules}</script>
<script type="module">
import {{ start }} from "{first}";
import {{ startTour }} from "{tour}";
const dark = matchMedia("(prefers-color-scheme: dark)").matches;
document.body.classList.toggle("dark", dark);
document.querySelector(".theme").onclick = () => document.body.classList.toggle("dark");
document.querySelector(".tour-start").onclick = () => startTour();
start(document.querySelector("#explore"));
</script></body></html>
"""


def where_from(head: Path | None, embeddings: Path | None) -> Places:
    """Return the locations of head and set; None means the project's own."""
    return places(head, embeddings)


def frames_file(where: Places, on_step: OnStep = ignore) -> Path:
    """Return the frames of a head and a set; compute them if there is no file.

    Raises DataError with the reason if that fails.
    """
    job = Resources(where).frames
    if where.frames is None:
        on_step(Step(done=0, total=1, text="frames, which may take minutes"))
    state = job.wait()
    if state.file is None:
        raise DataError(state.problem or "The frames could not be computed.")
    return state.file


def export_picture(
    frames: Path, out: Path, *, what: str, order: float | None, stage: str, kind: str, colour: str
) -> None:
    """Write the map or the curves as SVG or PNG.

    order  None: the learned one

    Raises SettingsError for an unknown map, colouring or ending.
    """
    from omnivat.frames import read_frames

    found = read_frames(frames)
    at = float(found.head.get("learned_order") or 0.5) if order is None else order
    if what == "curves":
        picture = curves_picture(found, stage=stage, order=at)
    else:
        picture = map_picture(found, order=at, stage=stage, kind=kind, colour=colour)
    write_picture(out, picture)


def export_page(where: Places, frames: Path, out: Path) -> None:
    """Write Explore with all its frames and thumbnails as one HTML file.

    It opens from disk in a browser and needs no server. Features that need a server show a note.
    """
    from omnivat.frames import read_frames

    found = read_frames(frames)
    held = held_files(where, frames)
    simulated = bool(found.embeddings.get("simulated"))
    title = f"{found.pairs} VIS-TAC pairs of {len(found.domains)} domains, {len(found.orders)} stops of p"
    page = PAGE.format(
        title=title,
        badge="" if simulated else "hidden",
        styles="\n".join((WEB / f"{name}.css").read_text(encoding="utf-8") for name in STYLES),
        explore=(WEB / "explore" / "explore.html").read_text(encoding="utf-8"),
        held=json.dumps(held),
        modules=json.dumps({"imports": scripts()}),
        first=PREFIX + FIRST,
        tour=PREFIX + TOUR,
    )
    write_text(out, page)


def held_files(where: Places, frames: Path) -> dict[str, str]:
    """Return all server data of a saved page, by path, as data: addresses."""
    resources = Resources(where)
    binary = "application/octet-stream"
    held = {"frames": data_address(frames.read_bytes(), binary)}
    listed = {"sets": [], "modes": modes(resources)["modes"]}
    for mode, file in fitting_files(resources).items():
        held[f"frames?mode={mode}"] = data_address(file.read_bytes(), binary)
    facts = {
        "modes": listed,
        "pairs": explore.pairs(resources),
        "toy": explore.mechanism(resources),
        "unseen": explore.unseen(resources),
    }
    for name, fact in facts.items():
        held[name] = data_address(json.dumps(fact).encode(), "application/json")
    sheet = where.sprite.with_suffix(".json") if where.sprite else None
    if where.sprite is not None and sheet is not None and sheet.is_file():
        held["thumbnails.webp"] = data_address(where.sprite.read_bytes(), "image/webp")
        held["thumbnails.json"] = data_address(sheet.read_bytes(), "application/json")
    return held


def scripts() -> dict[str, str]:
    """Return every script that Explore and its tour need, by bare name, as a data: address."""
    found: dict[str, str] = {}
    waiting = [FIRST, TOUR]
    while waiting:
        name = waiting.pop()
        if PREFIX + name in found:
            continue
        source = (WEB / name).read_text(encoding="utf-8")
        folder = name.rpartition("/")[0]
        waiting += [_beside(folder, match[2]) for match in IMPORT.finditer(source)]
        bare = IMPORT.sub(partial(_bare, folder), source)
        found[PREFIX + name] = data_address(bare.encode(), "text/javascript")
    return found


def _beside(folder: str, wanted: str) -> str:
    """Return the path below `web` of the script imported as `wanted` from `folder`."""
    return normpath(f"{folder}/{wanted}")


def _bare(folder: str, match: re.Match[str]) -> str:
    """Return an import with its relative path replaced by a bare name."""
    return f'{match[1]}"{PREFIX}{_beside(folder, match[2])}"'


def data_address(content: bytes, kind: str) -> str:
    """Return the content as a data: address."""
    return f"data:{kind};base64," + base64.b64encode(content).decode()
