"""The command line: `python -m omnivat COMMAND`, each command in a file of this folder.

A command has `add`, which declares its arguments, and `run`, which takes them. It may import every
wing; of the library, nothing imports it. A new command is a module here and its name in `NAMES`.
"""

import argparse
import logging
import sys
from collections.abc import Mapping, Sequence
from contextlib import nullcontext, suppress
from importlib import import_module
from io import TextIOWrapper
from typing import Any

from omnivat import __version__
from omnivat.kit.devices import computing_on, named
from omnivat.kit.errors import OmniVatError, WriteError, printable
from omnivat.kit.files import require_writable
from omnivat.kit.tables import suggestion

NAMES = (  # in the order of the help; a command's file has its name, or that in FILES
    *(
        "try",
        "fetch",
        "predict",
        "embed",
        "dots",
        "sensor",
        "import",
        "train",
        "evaluate",
        "profile",
    ),
    *("teach", "protocol", "ablate", "report", "reproduce", "sweep", "gaps", "project"),
    *("thumbnails", "export", "prompts"),
)
FILES = {"try": "try_pairs", "import": "imports"}  # two keywords of Python
COMMANDS: dict[str, Any] = {
    name: import_module(f"omnivat.cli.{FILES.get(name, name)}") for name in NAMES
}
PURPOSE = "See why a model trained on one tactile sensor fails on the next."


def parser(
    commands: Mapping[str, Any] = COMMANDS, program: str = "omnivat", purpose: str = PURPOSE
) -> argparse.ArgumentParser:
    """Return the parser of all commands."""
    top = argparse.ArgumentParser(prog=program, description=purpose)
    top.add_argument("--version", action="version", version=f"{program} {__version__}")
    added = top.add_subparsers(dest="command", metavar="COMMAND")
    for name, module in commands.items():
        summary = (module.__doc__ or "").splitlines()[0]
        module.add(added.add_parser(name, help=summary, description=summary))
    return top


def main(
    arguments: Sequence[str] | None = None,
    *,
    commands: Mapping[str, Any] = COMMANDS,
    program: str = "omnivat",
    purpose: str = PURPOSE,
) -> int:
    """Run a command. Return 0 when done, 1 with one sentence on stderr, 2 for wrong usage.

    commands  name -> module or other object with a docstring, `add` and `run`; the simulator
              passes its own

    Without a command, print the help.
    """
    logging.basicConfig(level=logging.WARNING, format="%(levelname)s %(name)s: %(message)s")
    given = sys.argv[1:] if arguments is None else list(arguments)
    if given and not given[0].startswith("-") and given[0] not in commands:
        known = f"There is no command '{printable(given[0])}'.{suggestion(given[0], commands)}"
        print(f"{program}: {known} `python -m {program} --help` lists them.", file=sys.stderr)
        return 2
    for stream in (sys.stdout, sys.stderr):  # a name that cannot be encoded is escaped
        if isinstance(stream, TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")
    whole = parser(commands, program, purpose)
    options = whole.parse_args(given)
    if options.command is None:
        whole.print_help()
        return 0
    try:
        if sys.stdout is None:
            raise WriteError("Standard output is closed; leave it open, or send it to a file.")
        if getattr(options, "figure", None):  # before long work
            from omnivat.figures.page import require_ending

            require_writable(require_ending(options.figure))
        device = getattr(options, "device", "cpu")
        with nullcontext() if device == named() == "cpu" else computing_on(device):
            commands[options.command].run(options)
        sys.stdout.flush()
    except OmniVatError as error:
        print(f"{program} {options.command}: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("Stopped. Nothing is half-written.", file=sys.stderr)
        return 130
    except BrokenPipeError:  # the reader of the pipe closed, as `head` does
        _drop_output()
        return 1
    except OSError as error:  # a full disk or a lost network folder: a traceback does not help
        where = f"'{error.filename}': " if error.filename else ""
        what = (
            f"{where}{error.strerror or error}. Check the path, its permissions and the free space."
        )
        print(f"{program} {options.command}: {what}", file=sys.stderr)
        _drop_output()
        return 1
    return 0


def _drop_output() -> None:
    """Close standard output without another error: the interpreter would write the rest at its
    end.
    """
    with suppress(OSError, AttributeError):
        sys.stdout.flush()
        return
    with suppress(OSError):
        sys.stdout.close()
