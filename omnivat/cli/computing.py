"""Shared by commands that compute: device, and permission to download weights."""

import argparse

from omnivat.devices import named


def add_device(parser: argparse.ArgumentParser) -> None:
    """Declare --device; see `omnivat.devices.device_from`."""
    parser.add_argument(
        "--device",
        default=named(),
        help="cpu (default), cuda, cuda:1, or auto: a GPU if there is one; $OMNIVAT_DEVICE holds "
        "where this is left out",
    )


def add_download(parser: argparse.ArgumentParser) -> None:
    """Declare --download and --offline, for weights that are not on this machine."""
    group = parser.add_mutually_exclusive_group()
    group.add_argument(
        "--download",
        action="store_const",
        const="yes",
        default="ask",
        help="fetch missing weights from the hub without asking",
    )
    group.add_argument(
        "--offline",
        action="store_const",
        const="no",
        dest="download",
        default="ask",
        help="never fetch weights",
    )
