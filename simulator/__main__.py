"""Draw simulated pairs: `python -m simulator set`, `twins` or `chirps`; `--help` explains each."""

import argparse
import sys
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

from omnivat.cli import main
from omnivat.cli.arguments import count, declare, flag, listed, passed, path, progress_bar
from omnivat.kit.files import require_writable

if TYPE_CHECKING:
    from omnivat.data.pairs import PairSet
    from omnivat.kit.progress import OnStep

WORKERS = count("processes; default: all cores")
CHIRPS = {
    "order": {"type": float, "help": "p*, the order of the signal; 0.35"},
    "strength": {"type": float, "help": "interference over signal; 2"},
    "shift": {"type": float, "help": "difference between domains, 0 to 1; 1"},
}


def draw_domains(options: argparse.Namespace, **how: Any) -> "PairSet":
    """Draw the simulated domains."""
    from simulator.build import simulate

    return simulate(options.out, **how)


def draw_twins(options: argparse.Namespace, **how: Any) -> "PairSet":
    """Draw twins."""
    from simulator.twins import simulate_twins

    return simulate_twins(options.out, each=how.pop("pairs_per_class"), **how)


def draw_chirps(options: argparse.Namespace, *, on_step: "OnStep", **given: Any) -> "PairSet":
    """Draw chirps."""
    from simulator.chirps import ChirpSettings, write_chirps

    return write_chirps(options.out, ChirpSettings(**given), on_step=on_step)


def command(summary: str, draw: Any, each: int, **own: Any) -> SimpleNamespace:
    """Return a command for `omnivat.cli.main` that writes a set of pairs; files that are there
    are kept.

    draw  function of the options and of their values, by name
    each  pairs of a class, the default
    own   options of this command alone; those left out by the user are not passed on
    """

    def add(parser: argparse.ArgumentParser) -> None:
        declare(
            parser,
            "seed",
            out=path("folder for the pairs", required=True),
            pairs_per_class={"type": int, "default": each, "help": f"default: {each}"},
            examples=path("copy a few test pairs here, as JPEG"),
            examples_per_class=count(
                "pairs of each class and domain to copy to --examples", default=2, metavar="N"
            ),
            **own,
        )

    def run(options: argparse.Namespace) -> None:
        from omnivat.data.pairs import summary_table
        from simulator.build import write_examples

        require_writable(options.out / "pairs.csv")
        if options.examples:
            require_writable(options.examples / "pairs")
        values = passed(options, "seed", "pairs_per_class", *own)
        given = {name: value for name, value in values.items() if value is not None}
        with progress_bar("draw") as show:
            made = draw(options, **given, on_step=show)
        print(summary_table(made))
        if options.examples:
            files = write_examples(made, options.examples, each=options.examples_per_class)
            size = sum(file.stat().st_size for file in files) / 1e6
            print(f"{len(files) // 2} example pairs in '{options.examples}', {size:.1f} MB")

    return SimpleNamespace(__doc__=summary, add=add, run=run)


DOMAINS = {"type": listed, "help": "only these, separated by commas"}
COMMANDS = {
    "set": command(
        "Draw pairs of the simulated domains (docs/simulated.md).",
        draw_domains, 60, domains=DOMAINS, workers=WORKERS,
        touches=flag("touches alone, which need no Mitsuba and a fifth of the time"),
    ),
    "twins": command(
        "Draw one press of each object as every sensor sees it (docs/twins.md).",
        draw_twins, 60, workers=WORKERS,
        gels=flag("touches of five gels alone, which needs neither Taxim nor Mitsuba"),
    ),
    "chirps": command(
        "Draw signals whose class shows at one fractional order only (docs/order.md).",
        draw_chirps, 40, **CHIRPS,
    ),
}  # fmt: skip

if __name__ == "__main__":
    sys.exit(main(commands=COMMANDS, program="simulator", purpose="Draw simulated pairs."))
