"""The arguments of `python app.py`, and their check before the server starts: one sentence for a
wrong one.

A hosting service sets address, host names and framing by the environment.
"""

import argparse
import errno
import os
import socket
from collections.abc import Mapping
from pathlib import Path

from app.shared.limits import DRAWN_PAIRS
from app.shared.places import head_in
from omnivat.head.heads import SET
from omnivat.kit.config import whole
from omnivat.kit.errors import DataError, SettingsError

PORTS = range(7860, 7960)  # tried in turn by default
MOST_PAIRS = 50_000  # 100,000 points: what the map draws smoothly
NAME, PORT = "GRADIO_SERVER_NAME", "GRADIO_SERVER_PORT"  # variables of the environment
CALLED = ("SPACE_HOST", "OMNIVAT_ALLOW_HOST")  # allowed host names, comma-separated
FRAMED = "SPACE_ID"  # set by a service that frames the page


def parser(environ: Mapping[str, str] = os.environ) -> argparse.ArgumentParser:
    """Return the command line of `python app.py`; a hosting service sets defaults by `environ`."""
    parser = argparse.ArgumentParser(prog="app.py", description="Open the OmniVaT page.")
    add, hosted = parser.add_argument, bool(environ.get(NAME) or environ.get(FRAMED))
    text = "folder of a trained head, or one that `omnivat try` wrote, which is shown with its set"
    add("--head", type=Path, metavar="DIR", help=text)
    add("--embeddings", type=Path, help="embeddings file to show")
    add("--profile", type=Path, metavar="FILE", help="profile of your sensor (`omnivat profile`)")
    text = f"draw N pairs of a set that has more; {DRAWN_PAIRS:,} if left out"
    add("--sample", type=whole(1, MOST_PAIRS), default=DRAWN_PAIRS, metavar="N", help=text)
    text = (
        "a head to compare with the first, or a folder that `omnivat try` wrote of the same pairs, "
        "with another encoder, too; can be given several times"
    )
    add("--compare", type=Path, action="append", default=[], metavar="DIR", help=text)
    text = f"address to listen on; ${NAME}, or this machine alone"
    add("--host", default=environ.get(NAME) or "127.0.0.1", help=text)
    text = f"port; ${PORT}, or the first free one from {PORTS[0]}"
    add("--port", type=whole(1, 65535), default=environ.get(PORT) or None, help=text)
    listed = ",".join(environ.get(key, "") for key in CALLED)
    names = [name.strip() for name in listed.split(",") if name.strip()]
    text = "an additional allowed host name, or '*.example.net' for all below it; can be repeated"
    add("--allow-host", action="append", default=names, metavar="NAME", help=text)
    text = "let other pages show this one in a frame, for notebooks and hosted demos"
    add("--allow-framing", action="store_true", default=FRAMED in environ, help=text)
    add(
        "--api",
        action="store_true",
        help="open the API for programs, over HTTP and MCP (docs/api.md)",
    )
    add("--no-browser", action="store_true", default=hosted, help="do not open a browser")
    add("--desktop", action="store_true", help="open a separate window (needs pywebview)")
    return parser


def keeps_nothing(environ: Mapping[str, str]) -> bool:
    """True if maps go to the temporary folder: a service's disk may be read-only."""
    return bool(environ.get(NAME) or environ.get(FRAMED)) and not environ.get("OMNIVAT_CACHE")


def find_files(chosen: argparse.Namespace) -> None:
    """Put heads and a set in the place of folders that `omnivat try` wrote.

    Raises DataError for a head or set that does not exist, or a profile that does not load.
    """
    if chosen.head and (inside := head_in(chosen.head)) != chosen.head:
        beside = chosen.head / SET
        chosen.head = inside
        if chosen.embeddings is None and beside.is_file():
            chosen.embeddings = beside
    chosen.compare = [head_in(folder) for folder in chosen.compare]
    if chosen.profile is not None:
        from omnivat.data.profile_file import load_profile

        load_profile(chosen.profile)
    for folder in filter(None, (chosen.head, *chosen.compare)):
        if not (folder / "settings.json").is_file():
            raise DataError(
                f"No head at '{folder}'. Train one with `python -m omnivat train --out {folder}`,"
                " or name the folder of another."
            )
    if chosen.embeddings is not None and not chosen.embeddings.is_file():
        raise DataError(
            f"No embeddings file at '{chosen.embeddings}'. Make one with `python -m omnivat embed`,"
            " or name another."
        )


def free_port(host: str, port: int | None) -> int:
    """Return the port to listen on: `port`, or the first free one.

    Raises SettingsError if the address is not of this machine, or the port is in use.
    """
    try:
        family, _, _, _, place = socket.getaddrinfo(host, 0, type=socket.SOCK_STREAM)[0]
    except (OSError, UnicodeError) as error:
        raise SettingsError(
            f"--host is '{host:.80}', which names no machine; leave it out, or give 0.0.0.0 to be"
            " reached by others."
        ) from error
    why = ""
    for candidate in [port] if port else PORTS:
        with socket.socket(family, socket.SOCK_STREAM) as probe:
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            try:
                probe.bind((place[0], candidate, *place[2:]))
                return candidate
            except OSError as error:
                why = error.strerror or str(error)
                if error.errno != errno.EADDRINUSE:
                    break
    raise SettingsError(
        f"Nothing can listen on '{host:.80}', port {candidate} ({why}); choose another --host"
        " or --port."
    )
