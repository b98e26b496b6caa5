"""Train a head on one domain of an embeddings file, and evaluate it on all.

python -m omnivat train --embeddings FILE --source DOMAIN --out DIR [--set key=value ...]

DIR holds the state after every epoch until the head is finished; --resume resumes a stopped
training, with identical final weights. A second training on three quarters of the objects then fits
the temperatures to the last quarter; --no-calibration skips it.
"""

import argparse
from dataclasses import replace

from omnivat.cli.arguments import (
    declare,
    flag,
    head_and_training,
    numbers,
    passed,
    progress_bar,
    text,
)
from omnivat.kit.errors import SettingsError


def add(parser: argparse.ArgumentParser) -> None:
    source = (
        "the source domain; all: every domain, each standardised by its own profile, for one's own"
        " pictures"
    )
    repeat = (
        "train again with these seeds, for the spread of the scores; the saved head uses --seed"
    )
    declare(
        parser,
        "embeddings",
        "lang",
        "device",
        source={"required": True, "help": source},
        part=text("only this part of it, such as outdoor"),
        out="folder for the head",
        seed="seed of weights and batches; default: 0",
        set="a setting of the head or of training, such as width=64 or lr=0.02",
        repeat={"type": numbers, "default": (), "metavar": "1,2", "help": repeat},
        no_calibration=flag("keep temperature 1: half the time"),
        resume=flag("resume a stopped training of --out"),
    )


def run(options: argparse.Namespace) -> None:
    """Check everything first; then train, evaluate on every domain, write the head folder."""
    from omnivat.data.store import load_embeddings
    from omnivat.head.checkpoint import require_head_folder, save_head
    from omnivat.head.head import parameter_count
    from omnivat.measure.known import scored
    from omnivat.training import STATE, TrainSettings, Watch, plan_training, trained_head

    require_head_folder(options.out, also=(STATE,))
    head_values, train_values = head_and_training(options.set)
    if options.source == "all":
        _of_all(options)
        return
    plan = plan_training(
        load_embeddings(options.embeddings),
        options.source,
        head=head_values,
        training=TrainSettings(**train_values),
        bank=options.lang,
        **passed(options, "part", "seed"),
    )
    without = f"; {plan.left_out} pairs without a class are left out" if plan.left_out else ""
    print(
        f"{parameter_count(plan.settings):,} trainable parameters, {len(plan.rows)} pairs{without}"
    )
    if not options.resume:
        (options.out / STATE).unlink(missing_ok=True)
    with progress_bar(f"train on {options.source}") as show:
        head = trained_head(
            plan,
            calibrate=not options.no_calibration,
            resume=options.out / STATE,
            watch=Watch(on_step=show),
        )
        others = [
            trained_head(replace(plan, seed=seed), calibrate=False) for seed in options.repeat
        ]
    head = scored(head, plan.embeddings, others)
    save_head(options.out, head)
    from omnivat.cli.evaluate import table

    print(table(*(head.metrics[k] for k in ("domains", "target_accuracy", "target_macro_f1"))))
    if search := head.metrics.get("order_search"):
        print(f"Order search: {search['note']}")
    print(f"Head written to {options.out}, learned order p = {head.model.order:.4f}")


def _of_all(options: argparse.Namespace) -> None:
    """Train and write a head of all domains, and print what it reads right in domains left out."""
    from omnivat.data.store import load_embeddings
    from omnivat.head.checkpoint import save_head
    from omnivat.study.pooled import pooled_head

    if options.set or options.part or options.repeat or options.resume:
        raise SettingsError("With --source all, give --embeddings, --seed and --out only.")
    with progress_bar("train on all domains") as show:
        head = pooled_head(load_embeddings(options.embeddings), seed=options.seed, on_step=show)
    save_head(options.out, head)
    print(
        f"{'pictures without labels':<24} {'both':>6} {'photo':>6} {'touch':>6}   (domains left"
        " out)"
    )
    for count, shares in head.metrics["left_out"].items():
        print(
            f"{count:<24} " + " ".join(f"{100 * shares[n]:6.1f}" for n in ("fused", "vis", "tac"))
        )
    print(f"Head written to {options.out}")
