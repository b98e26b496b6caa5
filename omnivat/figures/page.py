"""Figures as one HTML page that opens offline, as a notebook cell, or as a file of another kind."""

import base64
import gzip
import json
import re
from collections.abc import Sequence
from functools import cache
from html import escape
from pathlib import Path
from typing import Any

import plotly.graph_objects as go
import plotly.io
from plotly.offline import get_plotlyjs

from omnivat.figures.drawing import png
from omnivat.figures.specs import Spec, spec
from omnivat.figures.still import picture, svg_of
from omnivat.figures.theme import CONFIG, THEMES, template
from omnivat.kit.errors import SettingsError
from omnivat.kit.files import path_of, replacing, write_text

ENDINGS = (".html", ".svg", ".png", ".json")
# nothing of another host is loaded or sent; Plotly's WebGL traces compile functions
POLICY = (
    "default-src 'none'; script-src 'unsafe-inline' 'unsafe-eval'; style-src 'unsafe-inline'; "
    "img-src data: blob:; form-action 'none'; base-uri 'none'"
)
PAGE = Path(__file__).with_suffix(".html")
CELL = (
    '<iframe srcdoc="{page}" style="width:100%;height:{height}px;border:0" '
    'sandbox="allow-scripts allow-downloads" title="{title}"></iframe>'
)

TEMPLATES = {name: go.layout.Template(template(name)) for name in THEMES}
plotly.io.templates.update(TEMPLATES)


@cache
def _library() -> str:
    """Return plotly.js, compressed to two fifths, as base64."""
    return base64.b64encode(gzip.compress(get_plotlyjs().encode(), 9, mtime=0)).decode()


def html_page(title: str, parts: Sequence[Any]) -> str:
    """Return one HTML page of figures and texts; it needs no network and makes no request.

    parts  figures, with their captions below, and finished HTML

    >>> from omnivat.figures import lines
    >>> figure = lines({"loss": ([1, 2, 3], [1.6, 0.9, 0.7])}, title="Training")
    >>> page = html_page("Two parts", [figure, "<p>It learns.</p>"])
    >>> page.count("<figure>"), "<h1>Two parts</h1>" in page
    (1, True)
    """
    figures = [part for part in parts if isinstance(part, go.Figure)]
    body = "".join(_section(p) if isinstance(p, go.Figure) else p for p in parts)
    heading = "" if len(parts) == 1 else f"<h1>{escape(title)}</h1>"
    filled = {
        "policy": POLICY,
        "title": escape(title),
        "body": heading + body,
        "figures": _held("[" + ",".join(_json(drawn) for drawn in figures) + "]"),
        "templates": _held(json.dumps({n: TEMPLATES[n].to_plotly_json() for n in THEMES})),
        "config": json.dumps(CONFIG),
        "library": _library(),
    }
    return re.sub(
        f"%({'|'.join(filled)})%", lambda part: filled[part[1]], PAGE.read_text(encoding="utf-8")
    )


def _section(figure: Any) -> str:
    words = escape((figure.layout.meta or {}).get("caption", ""))
    height = figure.layout.height
    return (
        '<figure><div class="plot"'
        f' style="height:{height}px"></div><figcaption>{words}</figcaption></figure>'
    )


def _json(figure: Any) -> str:
    """Return a figure without its template, which the page holds once."""
    bare = go.Figure(figure)
    bare.layout.template = None
    return str(bare.to_json(validate=False))


def _held(text: str) -> str:
    """Return JSON that may stand in a script."""
    return text.replace("<", "\\u003c")


def cell(figure: Any) -> str:
    """Return a figure as the HTML of a notebook cell; the frame cannot reach the notebook."""
    title = str(figure.layout.title.text or "figure")
    whole = escape(html_page(title, [figure]))
    return CELL.format(page=whole, height=figure.layout.height + 90, title=escape(title))


def write(path: str | Path, figure: Any) -> Path:
    """Write a figure, completely or not at all; the ending of the name chooses the kind.

    Raises SettingsError for another ending, or for SVG and PNG of a figure in three dimensions.

    >>> from tempfile import TemporaryDirectory
    >>> from omnivat import figures
    >>> figure = figures.lines({"loss": ([1, 2, 3], [1.6, 0.9, 0.7])}, title="Training")
    >>> with TemporaryDirectory() as folder:
    ...     write(Path(folder) / "loss.svg", figure).read_text(encoding="utf-8")[:4]
    '<svg'
    """
    target = require_ending(path_of(path))
    ending = target.suffix.lower()
    if ending == ".html":
        write_text(target, html_page(str(figure.layout.title.text or "figure"), [figure]))
    elif ending == ".json":
        write_text(target, figure.to_json())
    elif ending == ".svg":
        write_text(target, svg_of(figure))
    else:
        with replacing(target) as temporary:
            png(picture(figure)).save(temporary, "PNG")
    return target


def require_ending(path: Path) -> Path:
    """Return a path that ends in one of ENDINGS; raises SettingsError for another."""
    if path.suffix.lower() not in ENDINGS:
        raise SettingsError(
            f"The figure '{path.name}' ends in '{path.suffix}'; choose {', '.join(ENDINGS)}."
        )
    return path


class Figure(go.Figure):  # type: ignore[misc]  # plotly has no types
    """A Plotly figure that shows itself in a notebook without another host, hover pictures
    included.

    `layout.meta` holds "caption" and, if there are pictures, "pictures".
    """

    _ipython_display_ = None

    def _repr_html_(self) -> str:
        return cell(self)

    def _repr_mimebundle_(self, *_: Any, **__: Any) -> dict[str, str]:
        return {"text/html": self._repr_html_()}


def figure(traces: Sequence[Any], **how: Any) -> Figure:
    """Return a figure of traces in the light template; `how` as in `omnivat.figures.specs.spec`."""
    return made(spec(traces, **how))


def made(content: Spec) -> Figure:
    """Return a figure of Plotly's JSON in the light template."""
    found = Figure(content)
    return found.update_layout(template="omnivat")  # type: ignore[no-any-return]
