"""How the page looks: a built-in theme with fonts of the system, and our one style sheet."""

from collections.abc import Sequence
from typing import Any

FONTS = ("system-ui", "-apple-system", "Segoe UI", "Roboto", "DejaVu Sans", "sans-serif")
MONO = ("ui-monospace", "Menlo", "Consolas", "DejaVu Sans Mono", "monospace")
WEB = "omnivat/web"  # where the page's own scripts and styles are served, relative to the page

STYLES = (
    "shared/page",
    "shared/tabs",
    "explore/explore",
    "pair/pair",
    "train/train",
    "tree/tree",
    "shared/narrow",
)  # in this order: later ones override

EARLY = ("cloud", "store", "frames", "measures", "api")  # scripts that the first tab waits for

HEAD = "\n".join(
    [
        *(f'<link rel="stylesheet" href="{WEB}/{name}.css">' for name in STYLES),
        *(
            f'<link rel="modulepreload" href="{WEB}/{name}">'
            for name in ("explore/explore.js", *(f"shared/{part}.js" for part in EARLY))
        ),
    ]
)


def head(views: Sequence[str]) -> str:
    """Return what goes into the page's head: styles, early scripts, and the names of the tabs."""
    return f'{HEAD}\n<meta name="omnivat-views" content="{" ".join(views)}">'


def theme() -> Any:
    """Return the theme. No font is fetched: every name is one that the system may have."""
    import gradio as gr

    return gr.themes.Base(
        primary_hue=gr.themes.colors.blue,
        neutral_hue=gr.themes.colors.slate,
        font=list(FONTS),
        font_mono=list(MONO),
    )
