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
    figure,
    head_and_set,
    numbers,
    progress_bar,
    shared,
    split_settings,
    whole,
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
    shared(parser, "head", "embeddings", "profile", "device")
    parser.add_argument("--out", type=Path, help="the frames file for the page, with maps")
    parser.add_argument("--json", type=Path, help="the curves over p as JSON")
    parser.add_argument("--csv", type=Path, help="the curves over p as a table, one column each")
    parser.add_argument("--stops", type=int, help="number of orders from 0 to 1; default: 101")
    parser.add_argument("--orders", help="these orders instead, such as 0,0.25,1.5")
    text = "of raw, frft, relu, f_bar, f_hat, separated by commas; default: all, for the page"
    parser.add_argument("--stages", default=ALL, help=text)
    parser.add_argument(
        "--measures", help="of docs/gaps.md, separated by commas, or 'all'; default: the fast ones"
    )
    group = parser.add_argument_group("a head at each order")
    group.add_argument(
        "--retrained", type=whole(2, 1001), metavar="N", help="train a head at each of N orders"
    )
    group.add_argument("--source", help="domain to train on; default: that of --head")
    group.add_argument("--seeds", help="such as 0,1,2 (default); maps show the first one's heads")
    group.add_argument("--jobs", type=whole(1, 256), help="processes; default: all cores")
    group.add_argument("--keep", type=Path, help="folder of the heads; keeps them")
    group.add_argument("--lang", type=Path, help="LANG bank; default: the project's own")
    text = "a setting of the head or of training that differs from --head's, such as epochs=30"
    group.add_argument("--set", action="append", metavar="key=value", help=text)
    figure(parser, "the curves against p")


def run(options: argparse.Namespace) -> None:
    """Measure, write the outputs, print the ends of the curves."""
    outputs = [p for p in (options.out, options.json, options.csv, options.figure) if p]
    if not outputs:
        raise SettingsError("There is no output; give --out, --json, --csv or --figure.")
    if len({realpath(path) for path in outputs}) < len(outputs):
        raise SettingsError(
            "Two of --out, --json, --csv and --figure name the same file; give each its own file."
        )
    for path in outputs:
        require_writable(path)
    _check_retrained(options)
    if options.profile and options.retrained is not None:
        raise SettingsError("--profile goes with one head; leave out --retrained.")
    stops = options.retrained if options.retrained is not None else options.stops
    orders = orders_of(options.orders, stops)
    from omnivat.head.checkpoint import head_hash
    from omnivat.maps.frames import write_frames
    from omnivat.maps.frames.builder import DEFAULT_MAPS, build_frames
    from omnivat.maps.frames.records import kind_of, with_learned
    from omnivat.maps.sweep import MEASURES, STAGES
    from omnivat.maps.sweep.curves import write_curves_csv, write_curves_json
    from omnivat.measure.gaps.measures import PREDICTION_MEASURES, STAGE_MEASURES

    wanted: Wanted = {"stages": names_of(options.stages, STAGES, "stage"), "measures": MEASURES}
    if options.measures:
        wanted = {
            **wanted,
            "measures": names_of(
                options.measures, (*STAGE_MEASURES, *PREDICTION_MEASURES), "measure"
            ),
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
    if options.retrained is not None:
        frames = _retrained(options, head, embeddings, orders, wanted)
    elif options.out:
        if options.orders is None and options.stops is None:
            orders = list(with_learned(orders, head.model.order))
        more: dict[str, Any] = {"measures": wanted["measures"], "provenance": provenance}
        with progress_bar("sweep") as show:
            frames = build_frames(
                head.model,
                embeddings,
                orders=orders,
                maps=_of(DEFAULT_MAPS, wanted),
                on_step=show,
                **more,
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
    if options.retrained is None:
        for name in ("source", "seeds", "jobs", "keep", "lang", "set"):
            if getattr(options, name) is not None:
                raise SettingsError(f"--{name} applies to --retrained N only; leave it out.")
        return
    if options.out is None:
        raise SettingsError("--retrained needs --out, the frames file to write.")
    if options.stops is not None or options.orders is not None:
        raise SettingsError("--retrained N sets the orders; leave out --stops and --orders.")


def _retrained(
    options: argparse.Namespace,
    head: "Head",
    embeddings: "Embeddings",
    orders: Stops,
    wanted: Wanted,
) -> Any:
    """Train the missing heads, and return the frames of all."""
    from omnivat.encoders.embed.pairs import usable_cores
    from omnivat.head.settings import HeadSettings
    from omnivat.training import TrainSettings
    from omnivat.training.from_pairs import plan_like
    from omnivat.training.from_pairs.at_stops import heads_at_stops
    from omnivat.training.retrained import MAPS, retrained_frames

    seeds = numbers(options.seeds or "0,1,2")
    plan = plan_like(head, embeddings, source=options.source or "", bank=options.lang)
    changes = split_settings(options.set or [], HeadSettings, TrainSettings)
    plan = replace(
        plan,
        settings=replace(plan.settings, **changes[0]),
        training=replace(plan.training, **changes[1]),
    )
    folder = options.keep or options.out.with_name(options.out.name + ".heads")
    with progress_bar("train a head at each order") as show:
        heads_at_stops(
            plan, orders, folder, seeds=seeds, jobs=options.jobs or usable_cores(), on_step=show
        )
    with progress_bar("map each head") as show:
        frames = retrained_frames(
            plan,
            orders,
            folder,
            seeds=seeds,
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


def orders_of(text: str | None, stops: int | None) -> list[float]:
    """Return the orders that `--orders` lists, or `--stops` of them from 0 to 1.

    Raises SettingsError for both options together, for numbers that are not finite, and for a list
    that is not ascending.
    """
    if text is None:
        count = 101 if stops is None else stops
        if not 2 <= count <= MOST_STOPS:
            raise SettingsError(f"--stops is {count}; choose 2 to {MOST_STOPS}.")
        return [step / (count - 1) for step in range(count)]
    if stops is not None:
        raise SettingsError("Give --orders or --stops, not both.")
    try:
        orders = [float(part) for part in text.split(",")]
    except ValueError:
        raise SettingsError(f"--orders is '{text}'; write numbers such as 0,0.25,1.5.") from None
    rising = all(before < after for before, after in pairwise(orders))
    if not rising or len(orders) > MOST_STOPS:
        raise SettingsError(
            f"--orders is '{text}'; write 1 to {MOST_STOPS} numbers, each above the last."
        )
    return [checked_order(order, name="An order of --orders") for order in orders]


def names_of(text: str, known: Sequence[str], kind: str) -> tuple[str, ...]:
    """Return the names in `text`, once each and in the order of `known`; `all` means all.

    Raises SettingsError for an unknown name.
    """
    if text == ALL:
        return tuple(known)
    from omnivat.maps.sweep.walk import require_known

    names = [name.strip() for name in text.split(",")]
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
