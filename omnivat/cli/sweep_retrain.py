"""`omnivat sweep --retrain`: train a head at each order."""

import argparse
import shutil
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from omnivat.cli.arguments import numbers, progress_bar, split_settings, whole
from omnivat.errors import SettingsError

if TYPE_CHECKING:
    from omnivat.checkpoint import Head
    from omnivat.data.store import Embeddings
    from omnivat.from_pairs import TrainingPlan

ONLY_RETRAIN = ("source", "seeds", "jobs", "keep", "lang", "set")


def add_retrain(parser: argparse.ArgumentParser) -> None:
    """Declare --retrain and its own arguments."""
    group = parser.add_argument_group("a head at each order")
    group.add_argument("--retrain", type=whole(2, 1001), metavar="N", help="train a head at each of N orders")
    group.add_argument("--source", help="domain to train on; default: that of --head")
    group.add_argument("--seeds", help="such as 0,1,2 (default); maps show the first one's heads")
    group.add_argument("--jobs", type=whole(1, 256), help="processes; default: all cores")
    group.add_argument("--keep", type=Path, help="folder of the heads; keeps them")
    group.add_argument("--lang", type=Path, help="LANG bank; default: the project's own")
    group.add_argument(
        "--set",
        action="append",
        metavar="key=value",
        help="a setting of the head or of training that differs from --head's, such as epochs=30",
    )


def check_retrain(options: argparse.Namespace) -> None:
    """Raise SettingsError for contradictory arguments."""
    if options.retrain is None:
        for name in ONLY_RETRAIN:
            if getattr(options, name) is not None:
                raise SettingsError(f"--{name} applies to --retrain N only; leave it out.")
        return
    if options.out is None:
        raise SettingsError("--retrain needs --out, the frames file to write.")
    if options.stops is not None or options.orders is not None:
        raise SettingsError("--retrain N sets the orders; leave out --stops and --orders.")


def retrained(
    options: argparse.Namespace,
    head: "Head",
    embeddings: "Embeddings",
    orders: Sequence[float],
    stages: Sequence[str],
    measures: Sequence[str],
) -> Any:
    """Train the missing heads, and return the frames of all."""
    from omnivat.embed.pairs import usable_cores
    from omnivat.frames.retrained import MAPS, retrained_frames
    from omnivat.from_pairs.at_stops import heads_at_stops

    seeds = tuple(numbers(options.seeds or "0,1,2", name="--seeds"))
    plan = _plan(options, head, embeddings)
    folder = options.keep or options.out.with_name(options.out.name + ".heads")
    jobs = options.jobs or usable_cores()
    with progress_bar("train a head at each order") as show:
        heads_at_stops(plan, orders, folder, seeds=seeds, jobs=jobs, on_step=show)
    maps = {name: stops for name, stops in MAPS.items() if name.split("/")[1] in stages}
    with progress_bar("map each head") as show:
        frames = retrained_frames(plan, orders, folder, seeds=seeds, maps=maps, measures=measures, on_step=show)
    if options.keep is None:
        shutil.rmtree(folder, ignore_errors=True)
    return frames


def _plan(options: argparse.Namespace, head: "Head", embeddings: "Embeddings") -> "TrainingPlan":
    """Return the plan of `head`, changed by --source, --lang and --set."""
    from dataclasses import replace

    from omnivat.from_pairs import plan_like
    from omnivat.model.settings import HeadSettings
    from omnivat.train import TrainSettings

    plan = plan_like(head, embeddings, source=options.source or "", bank=options.lang)
    head_values, train_values = split_settings(options.set or [], HeadSettings, TrainSettings)
    return replace(
        plan, settings=replace(plan.settings, **head_values), training=replace(plan.training, **train_values)
    )
