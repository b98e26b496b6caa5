"""Simulate the eight visual-tactile domains, twins, or a set of chirps.

python -m omnivat simulate --out DIR [--pairs-per-class 60] [--seed 0] [--examples DIR]
python -m omnivat simulate --set twins --out DIR    one press, imaged by every sensor
(docs/twins.md) python -m omnivat simulate --set chirps --out DIR [--order 0.35] [--strength 2]
[--shift 1]

Chirps are synthetic signals whose class shows at one fractional order only (docs/order.md).
"""

import argparse

from omnivat.cli.arguments import count, declare, listed, one_of, passed, path, progress_bar
from omnivat.kit.errors import SettingsError
from omnivat.kit.files import require_writable

CHIRP_OPTIONS = ("order", "strength", "shift")
SETS = {  # name -> options of other sets
    "sensors": CHIRP_OPTIONS,
    "twins": ("domains", *CHIRP_OPTIONS),
    "chirps": ("domains", "workers"),
}


def add(parser: argparse.ArgumentParser) -> None:
    declare(
        parser,
        "seed",
        set=one_of(tuple(SETS), "the set to make"),
        domains={"type": listed, "help": "only these, separated by commas"},
        pairs_per_class={"type": int, "help": "60 for sensors and twins, 40 for chirps"},
        examples=path("copy a few test pairs here, as JPEG"),
        examples_per_class=count(
            "pairs of each class and domain to copy to --examples", default=2, metavar="N"
        ),
        out="folder for the pairs",
        workers="processes; default: all cores",
        order={"type": float, "help": "chirps: p*, the order of the signal; 0.35"},
        strength={"type": float, "help": "chirps: interference over signal; 2"},
        shift={"type": float, "help": "chirps: difference between domains, 0 to 1"},
    )


def run(options: argparse.Namespace) -> None:
    """Write a set of pairs; existing rendered files are kept."""
    from omnivat.data.pairs import summary_table
    from omnivat.simulate.build import simulate, write_examples
    from omnivat.simulate.chirps import ChirpSettings, write_chirps
    from omnivat.simulate.twins import simulate_twins

    for name in SETS[options.set]:
        if getattr(options, name) is not None:
            raise SettingsError(f"--{name} does not apply to --set {options.set}; leave it out.")
    require_writable(options.out / "pairs.csv")
    if options.examples:
        require_writable(options.examples / "pairs")
    names = (*CHIRP_OPTIONS, "pairs_per_class")
    given = {name: value for name in names if (value := getattr(options, name)) is not None}
    how = passed(options, "seed", "workers")
    with progress_bar(f"simulate {options.set}") as show:
        if options.set == "chirps":
            made = write_chirps(
                options.out, ChirpSettings(seed=options.seed, **given), on_step=show
            )
        elif options.set == "twins":
            each = given.get("pairs_per_class", 60)
            made = simulate_twins(options.out, each=each, **how, on_step=show)
        else:
            made = simulate(options.out, domains=options.domains, **given, **how, on_step=show)
    print(summary_table(made))
    if options.examples:
        files = write_examples(made, options.examples, each=options.examples_per_class)
        size = sum(file.stat().st_size for file in files) / 1e6
        print(f"{len(files) // 2} example pairs in '{options.examples}', {size:.1f} MB")
