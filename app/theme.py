"""The page's look: a built-in theme with system fonts, and our style sheets."""

from collections.abc import Sequence
from typing import Any

FONTS = ("system-ui", "-apple-system", "Segoe UI", "Roboto", "DejaVu Sans", "sans-serif")
MONO = ("ui-monospace", "Menlo", "Consolas", "DejaVu Sans Mono", "monospace")
WEB = "omnivat/web"  # path of the page's scripts and styles, relative to the page

STYLES = (
    "shared/page",
    "shared/tabs",
    "explore/explore",
    "pair/pair",
    "train/train",
    "tree/tree",
    "shared/narrow",
)  # in this order: later ones override

EARLY = ("cloud", "store", "frames", "measures", "api")  # scripts that the first tab needs


def head(views: Sequence[str], web: str = WEB) -> str:
    """Return the HTML head: styles, early scripts, and the names of the tabs.

    web  where the scripts and styles are, relative to the page
    """
    early = ("explore/explore.js", *(f"shared/{part}.js" for part in EARLY))
    return "\n".join(
        [
            *(f'<link rel="stylesheet" href="{web}/{name}.css">' for name in STYLES),
            *(f'<link rel="modulepreload" href="{web}/{name}">' for name in early),
            f'<meta name="omnivat-views" content="{" ".join(views)}">',
        ]
    )


def theme() -> Any:
    """Return the theme. It uses system fonts only."""
    import gradio as gr

    return gr.themes.Base(
        primary_hue=gr.themes.colors.blue, neutral_hue=gr.themes.colors.slate, font=list(FONTS), font_mono=list(MONO)
    )
