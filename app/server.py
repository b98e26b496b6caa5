"""Start the page: read the arguments, lay out the tabs, serve."""

import argparse
import logging
import os
import signal
import sys
from collections.abc import Mapping, Sequence
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from typing import Any

from app import hosted, logs
from app.guard import Guard, alone, rules, warning
from app.light import light_imports
from app.limits import DRAWN_PAIRS
from app.preflight import free_port, pair_count, port_number, require_files
from app.scratch import sweep
from app.views import VIEWS
from omnivat.errors import MissingPackageError, OmniVatError
from omnivat.tables import need

log = logging.getLogger(__name__)
ICON = Path(__file__).parent / "web" / "shared" / "icon.svg"


def parser(environ: Mapping[str, str] = os.environ) -> argparse.ArgumentParser:
    """Return the command line of `python app.py`; a hosting service sets defaults by `environ`."""
    parser = argparse.ArgumentParser(prog="app.py", description="Open the OmniVaT page.")
    parser.add_argument("--head", type=Path, help="folder of a trained head")
    parser.add_argument("--embeddings", type=Path, help="embeddings file to show")
    parser.add_argument("--profile", type=Path, metavar="FILE", help="profile of your sensor (`omnivat profile`)")
    parser.add_argument(
        "--sample",
        type=pair_count,
        default=DRAWN_PAIRS,
        metavar="N",
        help=f"draw N pairs of a set that has more; {DRAWN_PAIRS:,} if left out",
    )
    parser.add_argument(
        "--compare",
        type=Path,
        action="append",
        default=[],
        metavar="DIR",
        help="a head to compare with the first; can be given several times",
    )
    parser.add_argument(
        "--host",
        default=environ.get(hosted.NAME) or "127.0.0.1",
        help=f"address to listen on; ${hosted.NAME}, or this machine alone",
    )
    parser.add_argument(
        "--port",
        type=port_number,
        default=environ.get(hosted.PORT) or None,
        help=f"port; ${hosted.PORT}, or the first free one from 7860",
    )
    parser.add_argument(
        "--allow-host",
        action="append",
        default=hosted.names(environ),
        metavar="NAME",
        help="an additional allowed host name; can be given several times",
    )
    parser.add_argument(
        "--allow-framing",
        action="store_true",
        default=hosted.FRAMED in environ,
        help="let other pages show this one in a frame, for notebooks and hosted demos",
    )
    parser.add_argument("--api", action="store_true", help="open the API for programs, over HTTP and MCP (docs/api.md)")
    parser.add_argument(
        "--no-browser", action="store_true", default=hosted.is_hosted(environ), help="do not open a browser"
    )
    parser.add_argument("--desktop", action="store_true", help="open a separate window (needs pywebview)")
    return parser


def build() -> Any:
    """Return the Gradio page with all tabs, without loading anything heavy."""
    with light_imports():
        import gradio as gr

    with gr.Blocks(title="OmniVaT", fill_width=True, delete_cache=(3600, 3600)) as page:
        from app.components import component

        component("header")
        with gr.Tabs(elem_id="views"):
            for name in VIEWS:
                view = import_module(f"app.views.{name}")
                with gr.Tab(view.TITLE, id=name, elem_id=f"view-{name}"):
                    view.build()
    return page


def launch(page: Any, resources: Any, arguments: argparse.Namespace, **more: Any) -> Any:
    """Serve the page until it is stopped; with `prevent_thread_lock`, return at once."""
    from starlette.middleware import Middleware

    from app.connections import install
    from app.routes import routes
    from app.theme import head, theme

    install()

    names, framed = arguments.allow_host, arguments.allow_framing
    guarded = rules(arguments.host, names, framed=framed)
    return page.launch(
        server_name=arguments.host,
        server_port=arguments.port,
        inbrowser=not arguments.no_browser,
        app_kwargs={
            "routes": routes(resources, api=arguments.api),
            "middleware": [Middleware(Guard, rules=guarded)],
            "lifespan": alone,
            "docs_url": None,
            "redoc_url": None,
        },
        theme=theme(),
        head=head(VIEWS),
        favicon_path=ICON,
        footer_links=[],
        run_history=False,
        max_file_size="1mb",  # Gradio's uploads are not used; images use our route
        state_session_capacity=200,
        **more,
    )


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the page until it is stopped."""
    chosen = parser().parse_args(arguments)
    os.environ["GRADIO_ANALYTICS_ENABLED"] = "False"
    logs.start()
    from app.places import places
    from app.resources import Resources
    from app.shared import Shared

    try:
        require_files(chosen.head, chosen.embeddings, chosen.compare, chosen.profile)
        chosen.port = free_port(chosen.host, chosen.port)
    except OmniVatError as error:
        print(f"app.py: {error}", file=sys.stderr)
        return 1
    if text := warning(chosen.host, chosen.port):
        print(text, file=sys.stderr, flush=True)
    for one in (signal.SIGINT, signal.SIGTERM, getattr(signal, "SIGHUP", signal.SIGTERM)):
        signal.signal(one, signal.default_int_handler)  # ends like Ctrl+C, with all clean-up
    sweep()
    shared, where = Shared(), places(chosen.head, chosen.embeddings, chosen.compare)
    where = replace(where, drawn=chosen.sample, profile=chosen.profile)
    if hosted.keeps_nothing(os.environ):
        where = replace(where, computed=shared.scratch.folder("maps"))
    resources = Resources(where, shared)
    try:
        if chosen.desktop:
            return in_window(resources, chosen)
        launch(build(), resources, chosen)
    except KeyboardInterrupt:  # before the server took over
        log.info("stopped")
    finally:
        resources.shared.close()
    return 0


def in_window(resources: Any, chosen: argparse.Namespace) -> int:
    """Show the page in a separate window until it is closed; report a missing package."""
    try:
        webview = need("webview", purpose="--desktop", install="pywebview")
    except MissingPackageError as error:
        print(f"app.py: {error}", file=sys.stderr)
        return 1
    chosen.no_browser = True
    page = build()
    _, address, _ = launch(page, resources, chosen, prevent_thread_lock=True, quiet=True)
    webview.create_window("OmniVaT", address, width=1440, height=940)
    webview.start()
    page.close()
    return 0
