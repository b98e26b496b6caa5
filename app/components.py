"""The page's components: plain HTML and an ES module each, no build step."""

from pathlib import Path

WEB = Path(__file__).parent / "web"


def component(name: str) -> None:
    """Add the component `web/<name>/<name>.html`; the script next to it starts it."""
    import gradio as gr

    gr.HTML(
        html_template=(WEB / name / f"{name}.html").read_text(encoding="utf-8"),
        js_on_load=(
            f"import(new URL('omnivat/web/{name}/{name}.js', document.baseURI))"
            ".then(module => module.start(element))"
            f".catch(error => console.error('{name}', error));"
        ),
        apply_default_css=False,
        elem_id=f"omnivat-{name}",
    )
