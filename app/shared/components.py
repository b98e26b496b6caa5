"""The page's components, plain HTML and an ES module each, and its look: system fonts and our
style sheets.
"""

import re
from collections.abc import Sequence
from functools import cache
from html import escape
from pathlib import Path
from posixpath import dirname, normpath
from typing import Any

from app.shared.tables import tables_html

WEB = Path(__file__).parents[1] / "web"
VIEWS = ("explore", "pair", "train")  # the tabs, in their order on the page
FONTS = ("system-ui", "-apple-system", "Segoe UI", "Roboto", "DejaVu Sans", "sans-serif")
MONO = ("ui-monospace", "Menlo", "Consolas", "DejaVu Sans Mono", "monospace")
STYLES = (
    "shared/page",
    "explore/explore",
    "explore/analyse",
    "explore/chapters",
    "explore/gaps",
    "pair/pair",
    "shared/native",
    "shared/narrow",
)  # in this order: later ones override
EXPLORE, FIRST = "explore/explore.js", "explore/first.js"
# Gradio's sign of loading counts its seconds in every frame for ever, also when it is not shown,
# and takes the browser's function when it is loaded: it gets no frames.
STILL = """<script>{
  const frame = window.requestAnimationFrame;
  window.requestAnimationFrame = (draw) =>
    new Error().stack?.includes("/statustracker-") ? 0 : frame(draw);
}</script>"""
IMPORTED = re.compile(r'(?:from|import) "(\.[^"]+)"')


@cache
def needed(script: str = EXPLORE) -> tuple[str, ...]:
    """Return the names of a script and of all scripts that it imports, relative to `web/`.

    A browser that knows them from the start fetches them at once, in place of finding one in
    another.
    """
    found = [script]
    for name in found:  # grows
        text = (WEB / name).read_text(encoding="utf-8")
        names = [normpath(f"{dirname(name)}/{other}") for other in IMPORTED.findall(text)]
        found += dict.fromkeys(other for other in names if other not in found)
    return tuple(found)


def component(name: str) -> None:
    """Add the component `web/<name>/<name>.html`; the script next to it starts it. Header and
    Explore are in the page already (`first`), and only move.
    """
    import gradio as gr

    early = name in ("header", "explore")
    script = FIRST if early else f"{name}/{name}.js"
    call = f"adopt('{name}', element)" if early else "start(element)"
    gr.HTML(
        html_template="<div></div>" if early else html_of(name),
        js_on_load=(
            f"import(new URL('omnivat/web/{script}', document.baseURI))"
            f".then(module => module.{call})"
            f".catch(error => console.error('{name}', error));"
        ),
        apply_default_css=False,
        elem_id=f"omnivat-{name}",
    )


def html_of(name: str) -> str:
    """Return the markup of a component."""
    return (WEB / name / f"{name}.html").read_text(encoding="utf-8")


def first(titles: Sequence[str]) -> str:
    """Return what is in the page before Gradio starts: the header, the titles of the tabs, Explore,
    and the script that starts them. Over a slow line, the first figure so is there in half the
    time.
    """
    tabs = "".join(f"<span>{escape(title)}</span>" for title in titles)
    parts = f'{html_of("header")}<div class="early" aria-hidden="true">{tabs}</div>'
    script = f'{STILL}<script type="module" async src="omnivat/web/{FIRST}"></script>'
    return f'<div id="omnivat-first">{parts}{html_of("explore")}</div>{script}'


def styles(web: str = "omnivat/web") -> str:
    """Return the links to the style sheets."""
    return "\n".join(f'<link rel="stylesheet" href="{web}/{name}.css">' for name in STYLES)


def head(views: Sequence[str], web: str = "omnivat/web") -> str:
    """Return the HTML head: styles, the names of the tabs, and the rows of `app/shared/tables.py`.

    web  where the scripts and styles are, relative to the page
    """
    return "\n".join(
        [styles(web), f'<meta name="omnivat-views" content="{" ".join(views)}">', tables_html()]
    )


def theme() -> Any:
    """Return the theme. It uses system fonts only."""
    import gradio as gr

    return gr.themes.Base(
        primary_hue=gr.themes.colors.blue,
        neutral_hue=gr.themes.colors.slate,
        font=list(FONTS),
        font_mono=list(MONO),
    )
