"""The command line: `python -m omnivat COMMAND`, each command in a file of this folder.

A command has `add`, which declares its arguments, and `run`, which takes them. It may import every
wing; of the library, nothing imports it. A new command is a module here and a line in `SUMMARIES`.
"""

import argparse
import logging
import signal
import sys
from collections.abc import Mapping, Sequence
from contextlib import nullcontext, redirect_stdout, suppress
from importlib import import_module
from io import TextIOWrapper
from threading import Timer
from typing import Any, TextIO, cast

from omnivat import __version__
from omnivat.kit.devices import computing_on, named
from omnivat.kit.errors import OmniVatError, WriteError, printable
from omnivat.kit.files import require_writable
from omnivat.kit.tables import suggestion

SUMMARIES = {  # in the order of the help; a command's file has its name, or that in FILES
    "try": "Embed your own pairs, train a small head, test it on left-out objects, open the page.",
    "fetch": "Bring a real data set of others as a folder of pairs; without a name, list the sets.",
    "predict": "Predict the material of pairs of a photo and a touch.",
    "embed": "Embed a set of pairs with a frozen encoder, once.",
    "dots": "Fill the dots printed on a gel, and show each picture before and after.",
    "sensor": "Show what a sensor is like from a folder of its touches, and what changed since.",
    "import": "Import vectors of another program, or pictures of recordings.",
    "train": "Train a head on one domain of an embeddings file, and evaluate it on all.",
    "evaluate": "Evaluate a head on every domain of an embeddings file.",
    "profile": "Profile a sensor from pictures without labels: the statistics of its embeddings.",
    "teach": "Teach a head from labelled pairs of a new sensor, and test it on left-out objects.",
    "protocol": "Run the paper's experiment: one source, unseen targets, some methods and seeds.",
    "ablate": "Run the paper's ablations, and write their tables and plots.",
    "report": "Report the domain shift of any features: gaps, retrieval, neighbours, probes, maps.",
    "compare": "Compare encoders: several embeddings of the same pairs in one table.",
    "reproduce": "Reproduce the paper's tables from its data sets, and print both figures.",
    "sweep": "Compute gaps, scores and maps of a head as functions of the order p.",
    "gaps": "Measure the gaps of a set at one stage: between modalities and between domains.",
    "project": "Draw a map of a set at one stage: a CSV of every point, or an interactive figure.",
    "thumbnails": "Make the page's sheet of thumbnails for a set of embeddings.",
    "export": "Write the page's pictures, Explore as one HTML file, or the page as a folder.",
    "prompts": "Make the LANG bank: text embeddings of the classes in eighty styles.",
}
EXAMPLES = {  # what a command takes, on the files that come with the program
    "try": "examples/pairs --out tried",
    "fetch": "",
    "predict": "--pairs examples/pairs/TQ-DIGIT-sim",
    "embed": "examples/pairs --encoder strip --out mine.safetensors",
    "dots": "examples/pairs/TQ-DIGIT-sim --out filled",
    "sensor": "examples/pairs/TQ-DIGIT-sim --against examples/pairs/TAG-sim",
    "import": "features.npz --out imported.safetensors",
    "train": "--source TAG-sim --out head --set epochs=20",
    "evaluate": "--unlabelled 20",
    "profile": "examples/pairs/TQ-DIGIT-sim --out digit.safetensors",
    "teach": "--embeddings examples/simulated.safetensors --domain TQ-DIGIT-sim --out taught",
    "protocol": "--sources TAG-sim --methods linear_maps,nearest_mean --out protocol",
    "ablate": "--only components --sources TAG-sim --out ablation",
    "report": "examples/simulated.safetensors --out report",
    "compare": "lite0=examples/simulated.safetensors mine=mine.safetensors",
    "reproduce": "--data DATA --out reproduced",
    "sweep": "--stops 5 --csv sweep.csv",
    "gaps": "--stage raw",
    "project": "--stage f_hat --out map.csv",
    "thumbnails": "examples/pairs --embeddings mine.safetensors --out sheet",
    "export": "--out map.png --order 0.5",
    "prompts": "--encoder minilm --out bank.safetensors",
}
FILES = {"try": "try_pairs", "import": "imports"}  # two keywords of Python
COMMANDS: dict[str, Any] = {
    name: import_module(f"omnivat.cli.{FILES.get(name, name)}") for name in SUMMARIES
}
ESCAPES = {k: f"\\x{k:02x}" for k in (*range(32), *range(127, 160)) if chr(k) not in "\n\t"}
STOPS = (signal.SIGINT, signal.SIGTERM)
PURPOSE = "See why a model trained on one tactile sensor fails on the next."


def parser(
    commands: Mapping[str, Any] = COMMANDS, program: str = "omnivat", purpose: str = PURPOSE
) -> argparse.ArgumentParser:
    """Return the parser of all commands."""
    top = argparse.ArgumentParser(prog=program, description=purpose)
    top.add_argument("--version", action="version", version=f"{program} {__version__}")
    added = top.add_subparsers(dest="command", metavar="COMMAND")
    for name, module in commands.items():
        summary = SUMMARIES.get(name) or module.__doc__  # Python may strip a module's
        line = (
            f"Example: python -m {program} {name} {EXAMPLES[name]}"
            if commands is COMMANDS
            else None
        )
        module.add(added.add_parser(name, help=summary, description=summary, epilog=line))
    return top


def main(
    arguments: Sequence[str] | None = None,
    *,
    commands: Mapping[str, Any] = COMMANDS,
    program: str = "omnivat",
    purpose: str = PURPOSE,
) -> int:
    """Run a command. Return 0 when done, 1 with one sentence on stderr, 2 for wrong usage, 128 and
    the number of a signal that stopped it.

    commands  name -> module of this folder, or another object with `__doc__`, `add` and `run`; the
              simulator passes its own

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
        if arguments is None:
            _stop_cleanly()
        if sys.stdout is None:
            raise WriteError("Standard output is closed; leave it open, or send it to a file.")
        if getattr(options, "figure", None):  # before long work
            from omnivat.figures.page import require_ending

            require_writable(require_ending(options.figure))
        device = getattr(options, "device", "cpu")
        on = nullcontext() if device == named() == "cpu" else computing_on(device)
        with on, redirect_stdout(cast(TextIO, _Escaped(sys.stdout))):
            commands[options.command].run(options)
        sys.stdout.flush()
    except OmniVatError as error:
        print(f"{program} {options.command}: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt as stop:
        print("Stopped. Nothing is half-written.", file=sys.stderr)
        return 128 + int(stop.args[0] if stop.args else signal.SIGINT)
    except BrokenPipeError:  # the reader of the pipe closed, as `head` does
        _drop_output()
        return 1
    except MemoryError:
        print(
            f"{program} {options.command}: The files that were named take more memory than there"
            " is; give smaller ones.",
            file=sys.stderr,
        )
        return 1
    except OSError as error:  # a full disk or a lost network folder: a traceback does not help
        where = f"'{error.filename}': " if error.filename else ""
        what = (
            f"{where}{error.strerror or error}. Check the path, its permissions and the free space."
        )
        print(f"{program} {options.command}: {what}", file=sys.stderr)
        _drop_output()
        return 1
    finally:
        if arguments is None:  # a signal while Python ends would change the status
            for number in STOPS:
                signal.signal(number, signal.SIG_IGN)
    return 0


class _Escaped:
    """A stream that writes control characters as escapes: in a name they would steer a terminal."""

    def __init__(self, stream: TextIO) -> None:
        self.stream = stream

    def __getattr__(self, name: str) -> Any:
        return getattr(self.stream, name)

    def write(self, text: str) -> int:
        """Write a text; its line ends and tabs stay."""
        return self.stream.write(text.translate(ESCAPES))


def _stop_cleanly() -> None:
    """Let SIGTERM end a command as Ctrl-C does, and let torch load before either does: an exception
    inside its start aborts the process.
    """

    def stop(number: int, _: Any) -> None:
        loading = getattr(getattr(sys.modules.get("torch"), "__spec__", None), "_initializing", 0)
        if not loading:
            raise KeyboardInterrupt(number)
        Timer(0.05, signal.raise_signal, (number,)).start()

    for number in STOPS:
        if signal.getsignal(number) is not signal.SIG_IGN:  # as under nohup
            signal.signal(number, stop)


def _drop_output() -> None:
    """Close standard output without another error: the interpreter would write the rest at its
    end.
    """
    with suppress(OSError, AttributeError):
        sys.stdout.flush()
        return
    with suppress(OSError):
        sys.stdout.close()
