"""Start the page: lay out the tabs, serve, with a log that visitors cannot fill."""

import argparse
import logging
import os
import signal
import sys
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from importlib import import_module
from threading import Lock
from time import monotonic
from types import SimpleNamespace
from typing import Any

from app.serving.guard import Guard, alone, rules, warning
from app.serving.light import light_imports
from app.serving.preflight import find_files, free_port, keeps_nothing, parser
from app.shared.components import FIRST, VIEWS, WEB, component, first, head, needed, styles, theme
from app.shared.memory import share_arenas
from app.shared.scratch import sweep
from app.shared.visitor_sets import VisitorSets
from omnivat.kit.errors import MissingPackageError, OmniVatError, printable
from omnivat.kit.tables import need

QUEUE_S = 0.05  # between two looks of Gradio for an event; its millisecond is 7 % of a processor
log = logging.getLogger(__name__)
LINES, LONGEST = 60, 300  # a minute; characters of a line


class Bounded(logging.Filter):
    """Lets LINES lines a minute through, each short and with its traceback."""

    def __init__(self) -> None:
        super().__init__()
        self._lock = Lock()
        self._minute, self._lines = -1, 0

    def filter(self, record: logging.LogRecord) -> bool:
        """Shorten a record; False if the minute has had its lines."""
        minute = int(monotonic() // 60)
        with self._lock:
            self._lines = self._lines + 1 if minute == self._minute else 1
            self._minute = minute
            lines = self._lines
        last = "the log leaves out the rest of this minute"
        record.msg = last if lines == LINES else printable(record.getMessage())[:LONGEST]
        record.args = ()
        return lines <= LINES


def start_log() -> None:
    """Write the log of this process to standard error, bounded: its own lines and the server's."""
    bounded, handler = Bounded(), logging.StreamHandler()
    handler.addFilter(bounded)
    form = "%(levelname)s %(name)s: %(message)s"
    logging.basicConfig(level=logging.INFO, format=form, handlers=[handler])
    logging.getLogger("httpx").setLevel(logging.WARNING)
    logging.getLogger("uvicorn.error").addFilter(bounded)  # it has another handler


def build(sets: VisitorSets) -> Any:
    """Return the Gradio page with all tabs, without loading anything heavy."""
    with light_imports():
        import gradio as gr

    with gr.Blocks(title="OmniVaT", fill_width=True, delete_cache=(3600, 3600)) as page:
        component("header")
        with gr.Tabs(elem_id="views"):
            for name in VIEWS:
                # a tab with `build` lays out more than its component
                view = import_module(f"app.{name}.tab")
                build_tab = getattr(view, "build", lambda *_, name=name: component(name))
                with gr.Tab(view.TITLE, id=name, elem_id=f"view-{name}") as tab:
                    build_tab(sets, tab)
    page._queue.sleep_when_free = QUEUE_S
    return page


def launch(page: Any, sets: VisitorSets, arguments: argparse.Namespace, **more: Any) -> Any:
    """Serve the page until it is stopped; with `prevent_thread_lock`, return at once."""
    from gradio import routes as gradio_routes
    from starlette.middleware import Middleware
    from uvicorn import config

    from app.serving.routes import Packed, routes
    from app.shared.connections import Turns

    # Gradio starts uvicorn with the protocols of these tables
    config.HTTP_PROTOCOLS["auto"] = "app.shared.connections:Connection"
    config.WS_PROTOCOLS["auto"] = None
    # it would print every event that it cannot read, and a visitor would fill the disk
    vars(gradio_routes)["traceback"] = SimpleNamespace(
        print_exc=partial(log.exception, "an event failed")
    )
    guarded = rules(arguments.host, arguments.allow_host, framed=arguments.allow_framing)
    early = ", ".join(
        [
            "<omnivat/modes>; rel=preload; as=fetch; crossorigin",
            *(f"<omnivat/web/{name}>; rel=modulepreload" for name in needed(FIRST)),
        ]
    )
    titles = [import_module(f"app.{name}.tab").TITLE for name in VIEWS]
    # what the first figure needs comes before Gradio's own scripts
    added = {
        b"</head>": head(VIEWS),
        b"<gradio-app": first(titles),
        b' crossorigin src="./assets/': ' fetchpriority="low"',
    }
    return page.launch(
        server_name=arguments.host,
        server_port=arguments.port,
        inbrowser=not arguments.no_browser,
        app_kwargs={
            "routes": routes(sets, api=arguments.api),
            "middleware": [
                Middleware(Turns),
                Middleware(Packed, compresslevel=6),
                Middleware(Guard, rules=guarded, links=early, added=added),
            ],
            "lifespan": alone,
            "docs_url": None,
            "redoc_url": None,
        },
        theme=theme(),
        head=styles(),  # once more, behind Gradio's own
        favicon_path=WEB / "shared" / "icon.svg",
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
    # torch's idle threads sleep: visitors share the processors
    os.environ.setdefault("OMP_WAIT_POLICY", "passive")
    share_arenas()
    start_log()
    from app.shared.places import places
    from app.shared.resources import Resources, Shared

    try:
        find_files(chosen)
        chosen.port = free_port(chosen.host, chosen.port)
    except OmniVatError as error:
        print(f"app.py: {error}", file=sys.stderr)
        return 1
    if text := warning(chosen.host, chosen.port):
        print(text, file=sys.stderr, flush=True)
    for number in (signal.SIGINT, signal.SIGTERM, getattr(signal, "SIGHUP", signal.SIGTERM)):
        signal.signal(number, signal.default_int_handler)  # ends like Ctrl+C, with all clean-up
    sweep()
    shared, where = Shared(), places(chosen.head, chosen.embeddings, chosen.compare)
    where = replace(where, drawn=chosen.sample, profile=chosen.profile)
    if keeps_nothing(os.environ):
        where = replace(where, computed=shared.scratch.folder("maps"))
    sets = VisitorSets(Resources(where, shared))
    try:
        if chosen.desktop:
            return in_window(sets, chosen)
        launch(build(sets), sets, chosen)
    except KeyboardInterrupt:  # before the server took over
        log.info("stopped")
    finally:
        shared.close()
    return 0


def in_window(sets: VisitorSets, chosen: argparse.Namespace) -> int:
    """Show the page in a separate window until it is closed; report a missing package."""
    try:
        webview = need("webview", purpose="--desktop", install="pywebview")
    except MissingPackageError as error:
        print(f"app.py: {error}", file=sys.stderr)
        return 1
    chosen.no_browser = True
    page = build(sets)
    _, address, _ = launch(page, sets, chosen, prevent_thread_lock=True, quiet=True)
    webview.create_window("OmniVaT", address, width=1440, height=940)
    webview.start()
    page.close()
    return 0
