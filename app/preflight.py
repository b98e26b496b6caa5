"""Checks before the server starts, so that a wrong argument gives one sentence."""

import argparse
import errno
import socket
from collections.abc import Sequence
from pathlib import Path

from omnivat.errors import DataError, SettingsError

PORTS = range(7860, 7960)  # tried in turn by default
MOST_PAIRS = 50_000  # 100,000 points: what the map draws smoothly


def port_number(text: str) -> int:
    """Return a port from the command line; raises ArgumentTypeError for anything else."""
    if not text.isascii() or not text.isdigit() or not 1 <= int(text[:6]) <= 65535:
        raise argparse.ArgumentTypeError(f"'{text:.20}' is not a port; give a number from 1 to 65535")
    return int(text)


def pair_count(text: str) -> int:
    """Return a number of pairs from the command line; raises ArgumentTypeError for anything else."""
    if not text.isascii() or not text.isdigit() or not 1 <= int(text[:9]) <= MOST_PAIRS:
        raise argparse.ArgumentTypeError(f"'{text:.20}' is not a number of pairs; give one from 1 to {MOST_PAIRS:,}")
    return int(text)


def require_files(
    head: Path | None, embeddings: Path | None, compare: Sequence[Path], profile: Path | None = None
) -> None:
    """Raise DataError for a named head or set that does not exist, or a profile that does not load."""
    if profile is not None:
        from omnivat.data.profile_file import load_profile

        load_profile(profile)
    for folder in filter(None, (head, *compare)):
        if not (folder / "settings.json").is_file():
            raise DataError(
                f"No head at '{folder}'. Train one with `python -m omnivat train --out {folder}`, or "
                "name the folder of another."
            )
    if embeddings is not None and not embeddings.is_file():
        raise DataError(
            f"No embeddings file at '{embeddings}'. Make one with `python -m omnivat embed`, or name another."
        )


def free_port(host: str, port: int | None) -> int:
    """Return the port to listen on: `port`, or the first free one.

    Raises SettingsError if the address is not of this machine, or the port is in use.
    """
    try:
        family, _, _, _, place = socket.getaddrinfo(host, 0, type=socket.SOCK_STREAM)[0]
    except (OSError, UnicodeError) as error:
        raise SettingsError(
            f"--host is '{host:.80}', which names no machine; leave it out, or give 0.0.0.0 to be reached by others."
        ) from error
    for one in [port] if port else PORTS:
        with socket.socket(family, socket.SOCK_STREAM) as probe:
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            try:
                probe.bind((place[0], one, *place[2:]))
                return one
            except OSError as error:
                if error.errno != errno.EADDRINUSE:
                    why = error.strerror or str(error)
                    raise SettingsError(
                        f"Nothing can listen on '{host:.80}', port {one} ({why}); choose another --host or --port."
                    ) from error
    if port:
        raise SettingsError(f"Port {port} is in use; choose another --port, or leave it out.")
    raise SettingsError(f"No port from {PORTS[0]} to {PORTS[-1]} is free; name one with --port.")
