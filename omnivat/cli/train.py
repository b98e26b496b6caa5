"""Train a head on one domain of an embeddings file, and evaluate it on all.

python -m omnivat train --embeddings FILE --source DOMAIN --out DIR [--set key=value ...]

The state after every epoch lies in DIR until the head is there; --resume takes a stopped training
up again and gives the weights that it would have given.
"""

import argparse
import math
import platform
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from omnivat.cli.bar import progress_bar
from omnivat.cli.protocol import numbers
from omnivat.errors import DataError, SettingsError
from omnivat.heads import default_embeddings
from omnivat.tables import suggestion

if TYPE_CHECKING:
    from omnivat.checkpoint import Head


def add(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("--embeddings", type=Path, default=default_embeddings())
    parser.add_argument("--source", required=True, help="the one domain to learn from")
    parser.add_argument("--part", default="", help="only this part of it, such as outdoor")
    parser.add_argument("--out", type=Path, required=True, help="folder for the head")
    parser.add_argument("--lang", type=Path, help="LANG bank; the project's own if left out")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument(
        "--repeat",
        default="",
        metavar="1,2",
        help="train again with these seeds for the spread of the scores; the head is --seed's",
    )
    parser.add_argument(
        "--resume", action="store_true", help="go on from where a stopped training of --out was"
    )
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="key=value",
        help="a setting of the head or of training, such as width=64 or lr=0.02",
    )


def run(options: argparse.Namespace) -> None:
    """Train, evaluate on every domain, write the head folder."""
    from omnivat.checkpoint import Head, save_head
    from omnivat.config import settings_dict
    from omnivat.data.store import load_embeddings
    from omnivat.evaluate import evaluate
    from omnivat.lang.bank import DEFAULT_BANK, load_bank
    from omnivat.model.head import parameter_count
    from omnivat.model.settings import HeadSettings
    from omnivat.train import STATE, TrainSettings, train

    embeddings = load_embeddings(options.embeddings)
    source = embeddings.in_domain(options.source, split="train", part=options.part)
    if not len(source):
        raise DataError(f"'{options.source}' has no pairs of part '{options.part}' to train on.")
    classes = _classes(source.label, embeddings.header.classes)
    head_values, train_values = split_settings(options.set, HeadSettings, TrainSettings)
    training = TrainSettings(**train_values)
    bank = load_bank(options.lang or DEFAULT_BANK).for_classes(classes) if training.lang else None
    settings = HeadSettings(
        **{
            "classes": classes,
            "input_width": embeddings.width,
            "lang_width": bank.width if bank else 1,
            **head_values,
        }
    )
    print(f"{parameter_count(settings):,} trainable parameters, {len(source)} pairs")
    state = options.out / STATE
    if not options.resume:
        state.unlink(missing_ok=True)
    with progress_bar(f"train on {options.source}") as show:
        trained = train(
            source,
            settings,
            training,
            bank=bank,
            seed=options.seed,
            resume=state,
            on_step=show,
        )
    header = embeddings.header
    encoder = {
        "name": header.encoder,
        "weights_hash": header.weights_hash,
        "preprocessing": header.preprocessing,
    }
    provenance: dict[str, Any] = {
        "source": options.source,
        "part": options.part,
        "simulated": header.simulated,
        "data": header.origin,
        "pairs": len(source),
        "seed": options.seed,
        "train": settings_dict(training),
        "lang": {"origin": bank.origin, "hash": bank.hash} if bank else None,
        "versions": _versions(),
    }
    head = Head(model=trained.model, settings=settings, encoder=encoder, provenance=provenance)
    records = evaluate(head, embeddings)
    head.metrics.update(
        selection=training.selection,
        chosen_epoch=trained.chosen_epoch,
        order=trained.model.order,
        target_accuracy=_mean(records),
        target_macro_f1=_mean(records, "macro_f1"),
        domains=records,
        epochs=trained.epochs,
        seeds=[_summary(options.seed, head, records)],
    )
    for seed in numbers(options.repeat, name="--repeat") if options.repeat else ():
        with progress_bar(f"train on {options.source}, seed {seed}") as show:
            again = train(source, settings, training, bank=bank, seed=seed, on_step=show)
        other = replace(head, model=again.model, metrics={})
        head.metrics["seeds"].append(_summary(seed, other, evaluate(other, embeddings)))
    save_head(options.out, head)
    from omnivat.cli.evaluate import table

    print(table(records))
    print(f"Head written to {options.out}, learned order p = {trained.model.order:.4f}")


def _summary(seed: int, head: "Head", records: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Return what metrics.json tells of one seed: means over targets, and every domain's scores."""
    return {
        "seed": seed,
        "order": head.model.order,
        "target_accuracy": _mean(records),
        "target_macro_f1": _mean(records, "macro_f1"),
        "domains": {r["domain"]: r["scores"]["fused"] for r in records if r["scores"]},
    }


def _mean(records: Sequence[dict[str, Any]], score: str = "accuracy") -> float | None:
    """Return a mean over targets; None without any, since JSON has no NaN."""
    from omnivat.evaluate import target_mean

    mean = target_mean(records, score)
    return None if math.isnan(mean) else mean


def split_settings(texts: list[str], *kinds: type[Any]) -> tuple[dict[str, Any], ...]:
    """Give each `key=value` text to the settings record that has the key.

    Raises SettingsError for a key that none has.
    """
    from omnivat.config import field_names, parse_assignments

    found: list[dict[str, Any]] = [{} for _ in kinds]
    names = [field_names(kind) for kind in kinds]
    for text in texts:
        key = text.partition("=")[0]
        owner = next((i for i, own in enumerate(names) if key in own), None)
        if owner is None:
            known = [name for own in names for name in own]
            hint = suggestion(key, known) or f" There are {', '.join(known)}."
            raise SettingsError(f"There is no setting '{key}'.{hint}")
        found[owner] |= parse_assignments(kinds[owner], [text])
    return tuple(found)


def _classes(labels: Any, names: tuple[str, ...]) -> tuple[str, ...]:
    """Return the classes that the source has, in the order of the file."""
    present = set(labels.tolist())
    return tuple(name for index, name in enumerate(names) if index in present)


def _versions() -> dict[str, str]:
    from importlib.metadata import version

    packages = {name: version(name) for name in ("torch", "numpy", "safetensors")}
    return {"python": platform.python_version(), **packages}
