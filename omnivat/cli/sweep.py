"""Compute gaps, scores and maps of a head as functions of the order p.

    python -m omnivat sweep --head DIR --embeddings FILE --out FRAMES
    python -m omnivat sweep --csv CURVES --stages raw,f_hat --measures mmd_rbf,ece --orders 0,0.5,1
    python -m omnivat sweep --retrained 21 --out FRAMES [--source DOMAIN] [--seeds 0,1,2] [--jobs 2]

--out writes the frames file for the page; without it, no maps are computed. --retrained trains a
head at each order, with the settings of --head, instead of moving the p of one head. Finished heads
of an interrupted run are used again.
"""

import argparse
import shutil
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from os.path import realpath
from pathlib import Path
from typing import TYPE_CHECKING, Any

from omnivat.cli.arguments import (
    assigned,
    count,
    declare,
    figure,
    head_and_set,
    head_and_training,
    numbers,
    path,
    progress_bar,
    several,
    text,
)
from omnivat.kit.errors import SettingsError
from omnivat.kit.files import require_writable
from omnivat.kit.stages import checked_order

if TYPE_CHECKING:
    from omnivat.data.store import Embeddings
    from omnivat.head.checkpoint import Head

ALL = "all"
MOST_STOPS = 1001
Stops = Sequence[float]
Values = Mapping[str, Sequence[float | None]]
Wanted = Mapping[str, Any]  # "stages" and "measures"


def add(parser: argparse.ArgumentParser) -> None:
    stages = "of raw, frft, relu, f_bar, f_hat, separated by commas; default: all, for the page"
    measures = "of docs/gaps.md, separated by commas, or 'all'; default: the fast ones"
    declare(
        parser,
        "head",
        "embeddings",
        "profile",
        "device",
        out=path("the frames file for the page, with maps"),
        json=path("the curves over p as JSON"),
        csv=path("the curves over p as a table, one column each"),
        stages=text(stages) | {"default": ALL},
        measures=text(measures),
    )
    which = parser.add_mutually_exclusive_group()
    declare(
        which,
        stops=count("number of orders from 0 to 1; default: 101", 2, MOST_STOPS),
        orders={"help": "these orders instead, such as 0,0.25,1.5"},
        retrained=count("train a head at each of N orders", 2, MOST_STOPS, metavar="N"),
    )
    setting = "a setting of the head or of training that differs from --head's, such as epochs=30"
    declare(
        parser.add_argument_group("a head at each order, for --retrained"),
        "lang",
        source={"help": "domain to train on; default: that of --head"},
        seeds={"type": numbers, "help": "default: 0,1,2; maps show the first one's heads"},
        jobs=count("processes; default: all cores", 1, 256),
        keep=path("folder of the heads; keeps them"),
        set=several(setting, "key=value", type=assigned),
    )
    figure(parser, "the curves against p")


def run(options: argparse.Namespace) -> None:
    """Measure, write the outputs, print the ends of the curves."""
    outputs = [p for p in (options.out, options.json, options.csv, options.figure) if p]
    if not outputs:
        raise SettingsError("There is no output; give --out, --json, --csv or --figure.")
    if len({realpath(file) for file in outputs}) < len(outputs):
        raise SettingsError(
            "Two of --out, --json, --csv and --figure name the same file; give each its own file."
        )
    for file in outputs:
        require_writable(file)
    _check_retrained(options)
    orders = orders_of(options.orders, options.retrained or options.stops or 101)
    from omnivat.head.checkpoint import head_hash
    from omnivat.maps.frames import write_frames
    from omnivat.maps.frames.builder import DEFAULT_MAPS, build_frames
    from omnivat.maps.frames.records import kind_of, with_learned
    from omnivat.maps.sweep import MEASURES, STAGES
    from omnivat.maps.sweep.curves import write_curves_csv, write_curves_json
    from omnivat.measure.gaps.measures import PREDICTION_MEASURES, STAGE_MEASURES

    every = (*STAGE_MEASURES, *PREDICTION_MEASURES)
    wanted: Wanted = {
        "stages": names_of(options.stages, STAGES, "stage"),
        "measures": names_of(options.measures, every, "measure") if options.measures else MEASURES,
    }
    head, embeddings = head_and_set(options)
    provenance = {
        "hash": head_hash(options.head),
        "source": head.source,
        "order": head.model.order,
        "simulated": head.provenance.get("simulated", False),
        "kind": kind_of(head),
    }
    frames: Any = None
    if options.retrained:
        frames = _retrained(options, head, embeddings, orders, wanted)
    elif options.out:
        if options.orders is None and options.stops is None:
            orders = list(with_learned(orders, head.model.order))
        with progress_bar("sweep") as show:
            frames = build_frames(
                head.model,
                embeddings,
                orders=orders,
                maps=_of(DEFAULT_MAPS, wanted),
                measures=wanted["measures"],
                provenance=provenance,
                on_step=show,
            )
    if frames is not None:
        write_frames(options.out, frames)
    curves: Values = frames.curves if frames else _curves(head, embeddings, orders, wanted)
    if options.json:
        write_curves_json(options.json, orders, curves, provenance)
    if options.csv:
        write_curves_csv(options.csv, orders, curves)
    print(table(orders, curves))
    if options.figure:
        _draw(options.figure, orders, curves, frames)
    written = ", ".join(map(str, outputs))
    print(f"{len(orders)} stops of {len(embeddings)} pairs written to {written}")


def _draw(file: Path, orders: Stops, curves: Values, frames: Any) -> None:
    """Draw the page's four charts, or without frames every curve of the whole set."""
    from omnivat.figures import gap_curves, lines, write
    from omnivat.kit.stages import STAGES

    whole = (*STAGES, "all", "unseen")
    series = {n: (orders, v) for n, v in curves.items() if n.partition("/")[2] in whole}
    titles = {"title": "Measures against p", "across": "order p", "up": "gap, margin or share"}
    write(file, gap_curves(frames) if frames is not None else lines(series, **titles))


def _check_retrained(options: argparse.Namespace) -> None:
    """Raise SettingsError for contradictory arguments."""
    if options.retrained:
        if options.out is None:
            raise SettingsError("--retrained needs --out, the frames file to write.")
        if options.profile:
            raise SettingsError("--profile goes with one head; leave out --retrained.")
        return
    for name in ("source", "seeds", "jobs", "keep", "lang", "set"):
        if getattr(options, name):
            raise SettingsError(f"--{name} applies to --retrained N only; leave it out.")


def _retrained(
    options: argparse.Namespace,
    head: "Head",
    embeddings: "Embeddings",
    orders: Stops,
    wanted: Wanted,
) -> Any:
    """Train the missing heads, and return the frames of all."""
    from omnivat.encoders.embed.pairs import usable_cores
    from omnivat.study.retrained import MAPS, heads_at_stops, retrained_frames
    from omnivat.training import plan_like

    plan = plan_like(head, embeddings, source=options.source or "", bank=options.lang)
    of_head, of_training = head_and_training(options.set)
    plan = replace(
        plan,
        settings=replace(plan.settings, **of_head),
        training=replace(plan.training, **of_training),
    )
    folder = options.keep or options.out.with_name(options.out.name + ".heads")
    runs = {"seeds": options.seeds or (0, 1, 2)}
    with progress_bar("train a head at each order") as show:
        jobs = options.jobs or usable_cores()
        heads_at_stops(plan, orders, folder, **runs, jobs=jobs, on_step=show)
    with progress_bar("map each head") as show:
        frames = retrained_frames(
            plan,
            orders,
            folder,
            **runs,
            maps=_of(MAPS, wanted),
            measures=wanted["measures"],
            on_step=show,
        )
    if options.keep is None:
        shutil.rmtree(folder, ignore_errors=True)
    return frames


def _of(maps: Mapping[str, int], wanted: Wanted) -> dict[str, int]:
    return {name: stops for name, stops in maps.items() if name.split("/")[1] in wanted["stages"]}


def _curves(
    head: "Head", embeddings: "Embeddings", orders: Stops, wanted: Wanted
) -> dict[str, list[float | None]]:
    from omnivat.maps.sweep import sweep

    with progress_bar("sweep") as show:
        found = sweep(head.model, embeddings, orders, on_step=show, **wanted).curves
    return {name: values.tolist() for name, values in found.items()}


def orders_of(listed: str | None, stops: int) -> list[float]:
    """Return the orders that `--orders` lists, or `stops` of them from 0 to 1.

    Raises SettingsError for numbers that are not finite, and for a list that is not ascending.
    """
    if listed is None:
        return [step / (stops - 1) for step in range(stops)]
    try:
        orders = [float(part) for part in listed.split(",")]
    except ValueError:
        raise SettingsError(f"--orders is '{listed}'; write numbers such as 0,0.25,1.5.") from None
    rising = all(before < after for before, after in pairwise(orders))
    if not rising or len(orders) > MOST_STOPS:
        raise SettingsError(
            f"--orders is '{listed}'; write 1 to {MOST_STOPS} numbers, each above the last."
        )
    return [checked_order(order, name="An order of --orders") for order in orders]


def names_of(listed: str, known: Sequence[str], kind: str) -> tuple[str, ...]:
    """Return the names that are listed, once each and in the order of `known`; `all` means all.

    Raises SettingsError for an unknown name.
    """
    if listed == ALL:
        return tuple(known)
    from omnivat.maps.sweep.walk import require_known

    names = [name.strip() for name in listed.split(",")]
    require_known(names, known, kind)
    return tuple(name for name in known if name in names)


def table(orders: Stops, curves: Values) -> str:
    """Return each curve's first, middle and last value as aligned text."""
    places = sorted({0, len(orders) // 2, len(orders) - 1})
    width = max((len(name) for name in curves), default=5)
    heads = " ".join(f"{f'p = {orders[place]:g}':>10}" for place in places)
    lines = [f"{'curve':<{width}} {heads}"]
    for name, values in curves.items():
        shown = (values[place] for place in places)
        cells = (
            f"{'-':>10}" if value is None or value != value else f"{value:>10.4f}"
            for value in shown
        )
        lines.append(f"{name:<{width}} " + " ".join(cells))
    return "\n".join(lines)
