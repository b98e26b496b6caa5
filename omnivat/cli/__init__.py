"""The command line: `python -m omnivat COMMAND`, each command in a file of this folder."""

import argparse
import logging
import sys
from collections.abc import Sequence

from omnivat import __version__
from omnivat.cli import (
    ablate,
    embed,
    evaluate,
    export,
    gaps,
    predict,
    project,
    prompts,
    protocol,
    simulate,
    sweep,
    thumbnails,
    train,
)
from omnivat.errors import OmniVatError

COMMANDS = {
    "predict": predict,
    "embed": embed,
    "train": train,
    "evaluate": evaluate,
    "protocol": protocol,
    "ablate": ablate,
    "sweep": sweep,
    "gaps": gaps,
    "project": project,
    "thumbnails": thumbnails,
    "export": export,
    "simulate": simulate,
    "prompts": prompts,
}


def parser() -> argparse.ArgumentParser:
    """Return the parser of all commands."""
    top = argparse.ArgumentParser(
        prog="omnivat",
        description="See why a model trained on one tactile sensor fails on the next.",
    )
    top.add_argument("--version", action="version", version=f"omnivat {__version__}")
    commands = top.add_subparsers(dest="command", required=True, metavar="COMMAND")
    for name, module in COMMANDS.items():
        summary = (module.__doc__ or "").splitlines()[0]
        module.add(commands.add_parser(name, help=summary, description=summary))
    return top


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command. Return 0 when done, 1 with one sentence on stderr, 2 for wrong usage."""
    logging.basicConfig(level=logging.WARNING, format="%(levelname)s %(name)s: %(message)s")
    options = parser().parse_args(arguments)
    try:
        COMMANDS[options.command].run(options)
    except OmniVatError as error:
        print(f"omnivat {options.command}: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("Stopped. Nothing is half-written.", file=sys.stderr)
        return 130
    except BrokenPipeError:  # the reader of our output went away, as `head` does
        sys.stderr.close()
        return 1
    except OSError as error:  # a full disk, a lost network folder: nothing a traceback explains
        print(f"omnivat {options.command}: {_what_failed(error)}", file=sys.stderr)
        return 1
    return 0


def _what_failed(error: OSError) -> str:
    where = f"'{error.filename}': " if error.filename else ""
    return f"{where}{error.strerror or error}. Check the path, its rights and the free space."
