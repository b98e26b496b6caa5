"""Arguments that several commands share, and progress on stderr."""

import argparse
import json
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING, Any

from omnivat.encoders.base import DEFAULT_ENCODER, JOINED
from omnivat.head.heads import default_embeddings, default_head, head_named
from omnivat.kit.config import field_names, parse_assignments, whole
from omnivat.kit.devices import named
from omnivat.kit.errors import SettingsError, printable
from omnivat.kit.progress import OnStep, Pace, Step
from omnivat.kit.stages import IMAGES, checked_order
from omnivat.kit.tables import suggestion

if TYPE_CHECKING:
    from omnivat.data.store import Embeddings
    from omnivat.head.checkpoint import Head


DEVICE = (
    "cpu (default), cuda, cuda:1, or auto: a GPU if there is one; $OMNIVAT_DEVICE changes the"
    " default"
)
EMBEDDINGS = "embeddings file; default: the project's simulated domains"
HEAD = (
    "folder of a trained head, or a head of the project: 'own' was trained on all simulated"
    " domains, 'head' on one; default: own for `predict` and `teach`, else head"
)
ORDER = "fractional order p, -4 to 4 quarter turns; default: the order that the head learned"
PROFILE = "profile of a sensor (`omnivat profile`); once or for several domains"
REST = (
    "picture of the untouched sensor, subtracted from each tactile image; auto: the nearest"
    " rest.png above each image, but not for gels with markers; all: for those, too"
)
LAYER = (
    "read a layer of the encoder (of --tac-encoder, if there is one) in place of its output: its"
    " number, from 1, or the name of a part"
)
FLIP = (
    "turn or mirror the touches of every domain, or of one, as those of the sensor that a head"
    " learned (`omnivat sensor` names the way): left-right, top-bottom, half-turn, clockwise,"
    " anticlockwise"
)
CHANNELS = "bgr: swap red and blue of the touches of every domain, or of one"
TARGET = (
    "a column of numbers of the table or file, such as force, to predict by ridge regression: R²"
    " and mean absolute error"
)
DOTS = ("fill", "keep")  # of gels, in tactile images
EVERY_S = 2.0  # seconds between two lines of a log, at least: short work writes none
AT_MOST_S = 60.0  # seconds after which a line comes before the next tenth


@contextmanager
def progress_bar(title: str) -> Iterator[OnStep]:
    """Yield a function that draws progress reports: a bar, or lines if stderr is a file or a
    pipe.
    """
    if not sys.stderr.isatty():
        yield _Lines(title).show
        return
    from tqdm import tqdm

    with tqdm(desc=title, leave=False, dynamic_ncols=True) as bar:

        def show(step: Step) -> None:
            if step.total:
                bar.total = step.total
            bar.set_postfix_str(printable(step.text), refresh=False)
            bar.update(step.done - bar.n)

        yield show


class _Lines:
    """Writes a line for every tenth of the work, with the time left at the mean rate so far."""

    def __init__(self, title: str) -> None:
        self.title, self.tenth, self.pace = title, 10, Pace()
        self.written = time.monotonic()

    def show(self, step: Step) -> None:
        """Print the progress of a step, if a tenth is done or the last line is old."""
        now, left = time.monotonic(), self.pace.left(step)
        tenth = 10 * step.done // step.total if step.total else 0
        self.tenth = min(self.tenth, tenth)  # another stage of the same work begins again
        due = tenth > self.tenth or now - self.written > AT_MOST_S
        if not due or now - self.written < EVERY_S:
            return
        self.tenth, self.written = tenth, now
        share = (
            f"{100 * step.done // step.total} %, {step.done:,} of {step.total:,}"
            if step.total
            else ""
        )
        text = ", ".join(filter(None, [share or f"{step.done:,} done", left, printable(step.text)]))
        print(f"{self.title}: {text}", file=sys.stderr, flush=True)


Option = dict[str, Any]  # arguments of `add_argument`


def text(words: str, metavar: str | None = None) -> Option:
    """Return an option of text, "" if it is left out."""
    return {"default": "", "metavar": metavar, "help": words}


def path(words: str, metavar: str | None = None, **more: Any) -> Option:
    """Return an option that names a file or a folder."""
    return {"type": Path, "metavar": metavar, "help": words, **more}


def list_of(words: str, metavar: str | None = None) -> Option:
    """Return an option of names with commas between them, () if it is left out."""
    return {"type": listed, "default": (), "metavar": metavar, "help": words}


def flag(words: str, **more: Any) -> Option:
    """Return an option without a value."""
    return {"action": "store_true", "help": words, **more}


def several(words: str, metavar: str, **more: Any) -> Option:
    """Return an option that can be given several times."""
    return {"action": "append", "default": [], "metavar": metavar, "help": words, **more}


def count(words: str, least: int = 1, most: float = inf, **more: Any) -> Option:
    """Return an option that is a whole number from `least` to `most`."""
    return {"type": whole(least, most), "help": words, **more}


def one_of(choices: Sequence[Any], words: str = "", first: Any = None) -> Option:
    """Return an option that is one of `choices`; the default is `first`, or the first of them.

    Another text is refused with the nearest choice.
    """
    default = choices[0] if first is None else first
    text = f"{words}; default: {default}".removeprefix("; ")
    named = {str(choice): choice for choice in choices}

    def chosen(text: str) -> Any:
        if text not in named:
            known = f"give one of {', '.join(named)}.{suggestion(text, named)}"
            raise argparse.ArgumentTypeError(f"'{text}'; {known}")
        return named[text]

    return {"type": chosen, "metavar": f"{{{','.join(named)}}}", "default": default, "help": text}


def declare(parser: argparse._ActionsContainer, *names: str, **options: str | Option) -> None:
    """Declare options of a command.

    names    options that several commands share
    options  a shared option with another help text (str), or an option of this command alone
    """
    shared: dict[str, Option] = {
        "device": {"default": named(), "help": DEVICE},
        "layer": {"metavar": "LAYER", "default": "", "help": LAYER},
        "embeddings": path(EMBEDDINGS, default=default_embeddings()),
        "encoder": {"default": DEFAULT_ENCODER, "help": "named as for `embed`"},
        "head": {"type": head_named, "default": default_head(), "help": HEAD},
        "jobs": count("parallel processes", default=1),
        "json": flag("print JSON"),
        "look": path("also draw some pairs as a contact sheet, to check them", "FILE.png"),
        "lang": path("LANG bank; default: the project's own"),
        "only": list_of("some of the ablations", "a,b,c"),
        "order": {"type": order, "metavar": "P", "help": ORDER},
        "out": path("the .safetensors file to write", required=True),
        "profile": several(PROFILE, "FILE", type=Path),
        "seed": {"type": int, "default": 0, "help": "seed of all random choices; default: 0"},
        "seeds": {
            "type": numbers,
            "default": (0, 1, 2),
            "metavar": "0,1,2",
            "help": "seeds, one run for each",
        },
        "set": several("", "key=value", type=assigned),
        "target": text(TARGET, "COLUMN"),
        "tac_encoder": {
            "metavar": "NAME",
            "default": "",
            "help": "another encoder for tactile images; named as --encoder",
        },
        "tac_weights": path("checkpoint of --tac-encoder"),
        "tac_rest": {"metavar": "FILE|auto|all|none", "help": REST},
        "flip": several(FLIP, "[DOMAIN=]WAY"),
        "channels": several(CHANNELS, "[DOMAIN=]bgr"),
        "vis": text("photos: a folder, column or camera; default: recognised by name", "NAME"),
        "tac": text("touches: a folder, column or camera; default: recognised by name", "NAME"),
        "weights": path("checkpoint of the encoder"),
        "workers": count("threads; default: all cores"),
    }
    for name, own in {**{name: shared[name] for name in names}, **options}.items():
        option = shared[name] | {"help": own} if isinstance(own, str) else own
        parser.add_argument(f"--{name.replace('_', '-')}", **option)


ENCODING = ("encoder", "weights", "tac_encoder", "tac_weights", "layer")  # of `encoder_name`


def encoder_name(options: argparse.Namespace) -> str:
    """Return the name for `load_encoder` that the options ENCODING give.

    Raises SettingsError for weights of an encoder that is not named.
    """
    if options.tac_weights and not options.tac_encoder:
        raise SettingsError("--tac-weights needs --tac-encoder; without it both use --weights.")
    names = [*filter(None, (options.encoder, options.tac_encoder))]
    return JOINED.join(names) + (f"#{options.layer}" if options.layer else "")


def download(parser: argparse.ArgumentParser) -> None:
    """Declare --download and --offline, for weights that are not on this machine."""
    const = {"action": "store_const", "dest": "download", "default": "ask"}
    declare(
        parser.add_mutually_exclusive_group(),
        download={**const, "const": "yes", "help": "fetch missing weights without asking"},
        offline={**const, "const": "no", "help": "never fetch weights"},
    )


def figure(parser: argparse.ArgumentParser, of: str) -> None:
    """Declare --figure, the file of an interactive figure."""
    words = f"also draw {of}: .html (interactive, opens offline), .svg, .png or .json (Plotly)"
    declare(parser, figure=path(words, "FILE"))


def halves(options: argparse.Namespace) -> dict[str, str]:
    """Return which of --vis and --tac are given, for a reader of pairs."""
    return {half: name for half in IMAGES if (name := getattr(options, half))}


def head_and_set(
    options: argparse.Namespace, *, sample: int = 0, profiled: bool = True
) -> "tuple[Head, Embeddings]":
    """Return the head and the embeddings of the options; raises DataError if they do not fit.

    sample    number of random pairs; 0: all
    profiled  standardise each domain by the profiles of --profile
    """
    from omnivat.data.profile_file import load_profile
    from omnivat.data.store import load_embeddings
    from omnivat.head.checkpoint import load_head

    head, embeddings = load_head(options.head), load_embeddings(options.embeddings).sampled(sample)
    head.require_embeddings(embeddings)
    profiles = [load_profile(file) for file in options.profile] if profiled else []
    return head, head.profiled(embeddings, profiles) if profiles else embeddings


def as_json(value: Any) -> str:
    """Return a value as JSON for people."""
    return json.dumps(value, indent=2, ensure_ascii=False)


def passed(options: argparse.Namespace, *names: str) -> dict[str, Any]:
    """Return some of the options by name, to pass them on."""
    return {name: getattr(options, name) for name in names}


def order(text: str) -> float:
    """Return a fractional order from -4 to 4, for argparse."""
    try:
        return checked_order(float(text))
    except SettingsError as error:
        raise argparse.ArgumentTypeError(str(error)) from None


def listed(text: str) -> tuple[str, ...]:
    """Return the parts of "a,b,c", stripped."""
    return tuple(part.strip() for part in text.split(",") if part.strip())


def numbers(text: str) -> tuple[int, ...]:
    """Return the whole numbers of "0,1,2", one or more, for argparse."""
    wrong = argparse.ArgumentTypeError(f"'{text}'; give whole numbers such as 0,1,2")
    try:
        found = tuple(map(int, listed(text)))
    except ValueError:
        raise wrong from None
    if not found:
        raise wrong
    return found


def assigned(text: str) -> str:
    """Return a text of the form key=value, for argparse; the value may be empty."""
    if not all(text.partition("=")[:2]):
        raise argparse.ArgumentTypeError(f"'{text}'; write it as key=value")
    return text


def head_and_training(texts: list[str]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return the settings of a head, and those of its training, among `key=value` texts.

    Raises SettingsError for an unknown key.
    """
    from omnivat.head.settings import HeadSettings
    from omnivat.training import TrainSettings

    found: tuple[dict[str, Any], dict[str, Any]] = {}, {}
    owners = {
        name: (kind, into)
        for kind, into in zip((HeadSettings, TrainSettings), found, strict=True)
        for name in field_names(kind)
    }
    for text in texts:
        key = text.partition("=")[0]
        if key not in owners:
            hint = suggestion(key, owners) or f" There are {', '.join(owners)}."
            raise SettingsError(f"There is no setting '{key}'.{hint}")
        kind, into = owners[key]
        into |= parse_assignments(kind, [text])
    return found
