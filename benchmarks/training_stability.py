"""Does training ever give NaN? Seeds, sources, λ, R, rates, and embeddings and orders at extremes.

    python -m benchmarks.training_stability [--pairs 60] [--out docs/benchmarks/training_stability]

Short trainings of the light head (2 epochs, the warm-up and the full rate): every λ with every R,
rate, shipped source and two seeds, then synthetic extremes of embeddings, batches and orders. A run
passes if every weight, loss and prediction is finite. A run that stops with an explanation counts
as refused. "Held back" counts steps with a clipped gradient.
"""

import argparse
import itertools
import json
import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
import torch

from benchmarks.measure import machine
from omnivat.data.materials import MATERIALS
from omnivat.data.store import ROW_NAMES, Embeddings, Header, load_embeddings
from omnivat.encoders.lang.bank import LangBank, load_bank
from omnivat.head.settings import HeadSettings
from omnivat.kit.errors import OmniVatError
from omnivat.measure.evaluate import predicted_probabilities
from omnivat.training import TrainSettings, train

WIDTH = 96
SHIPPED = Path("examples/simulated.safetensors")
SEEDS = (0, 1)
LEVELS = (1, 2, 3, 4, 5)
RATES = (0.005, 0.05, 0.5)
LAMBDAS = (0.0, 0.1, 1.0, 10.0, 100.0)
ORDERS = (0.0, 1.0, 2.0, 3.7, -2.0, 1000.3)
P_EXPLAINED = (
    "**How far p goes.** The transform has period 4, so p is told modulo 4, too. By default p's "
    "gradient is held to 1 and its rate is a hundredth of the rest's: with momentum 0.9 a step "
    "moves p by at most 0.01 lr / (1 - 0.9) = 0.1 lr, 0.05 at the largest rate here. With its rate "
    "× 10 the same step is 100 lr, 50 at lr 0.5: p then runs through many periods although its "
    "gradient is held to 1, and what it ends at says nothing. Nothing breaks, but cross-entropy "
    "stays high. Even orders are points of rest: there Im is zero and Re has no slope in p, ReLU "
    "passes no gradient at zero, and p stays to the bit."
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Run:
    """One short training: the name of its row, and its settings that differ from the defaults."""

    group: str
    source: str = "clusters"
    seed: int = 0
    head: dict[str, Any] = field(default_factory=dict)
    train: dict[str, Any] = field(default_factory=dict)


def made_source(kind: str, pairs: int, seed: int) -> Embeddings:
    """Return synthetic training pairs: regular clusters, or an extreme named by `kind`."""
    random = np.random.default_rng(seed)
    label = np.arange(pairs) % len(MATERIALS)
    centres = 2 * random.normal(size=(len(MATERIALS), WIDTH))
    vis, tac = (centres[label] + random.normal(size=(pairs, WIDTH)) for _ in range(2))
    if kind in ("zero", "constant"):
        vis = tac = np.full((pairs, WIDTH), 0.0 if kind == "zero" else 1.0)
    elif kind == "duplicated":
        vis = tac = np.repeat(vis[:1], pairs, axis=0) + 0.0 * tac
    elif kind in ("huge", "tiny"):
        factor = 1e30 if kind == "huge" else 1e-30
        vis, tac = vis * factor, tac * factor
    elif kind == "half zero":
        vis, tac = vis * (np.arange(pairs) % 2)[:, None], tac
    elif kind == "one sample a class":
        label, vis, tac = label[:5], vis[:5], tac[:5]
    order = np.argsort(label, kind="stable")
    header = Header(
        encoder="made", weights_hash="none", preprocessing="none", domains=("made",), classes=MATERIALS, simulated=True
    )
    return Embeddings(
        header=header,
        vis=vis[order].astype(np.float32),
        tac=tac[order].astype(np.float32),
        domain=np.zeros(len(label), dtype=np.int64),
        label=label[order],
        rows={name: [""] * len(label) for name in ROW_NAMES},
    )


def runs(domains: Sequence[str]) -> list[Run]:
    """Return every training of the report; `domains` of the shipped set are the sources."""
    everything = itertools.product(LAMBDAS, RATES, SEEDS, domains, LEVELS)
    extremes = ("zero", "constant", "duplicated", "huge", "tiny", "half zero", "one sample a class")
    listed = [
        Run(
            group=f"λ {weight:g}, lr {rate:g}, R 1 to 5, eight sources, two seeds",
            source=domain,
            seed=seed,
            head={"levels": levels},
            train={"mma_weight": weight, "lr": rate},
        )
        for weight, rate, seed, domain, levels in everything
    ]
    listed += [
        Run(group=f"{kind} embeddings" if "sample" not in kind else kind, source=kind, seed=s)
        for kind in extremes
        for s in (0, 1)
    ]
    listed += [Run(group="batches of one pair, so of one class", train={"batch": 1}, seed=s) for s in (0, 1)]
    listed += [
        Run(
            group=f"p learned from {order:g}, its rate × {scale:g}",
            head={"order": order},
            train={"order_lr_scale": scale, "lr": 0.5},
        )
        for scale in (0.01, 10.0)
        for order in ORDERS
    ]
    listed += [
        Run(group="p without its clamp and slow rate", train={"order_lr_scale": s, "order_clip": 1e9})
        for s in (1.0, 10.0)
    ]
    listed += [
        Run(group="the literal profile", train={"lr": rate},
            head={"feature_scale": "literal", "attention_scale": "outside"})
        for rate in RATES
    ]  # fmt: skip
    return listed


def attempt(run: Run, pairs: int, bank: LangBank, shipped: Embeddings) -> dict[str, Any]:
    """Train once; return whether it passed, and the number of clipped steps."""
    if run.source in shipped.header.domains:
        source = shipped.in_domain(run.source, split="train")
    else:
        source = made_source(run.source, pairs, run.seed)
    names = source.header.classes
    classes = tuple(name for i, name in enumerate(names) if (source.label == i).any())
    bank = bank.for_classes(classes)
    light = HeadSettings(classes=classes, input_width=source.width, lang_width=bank.width, width=64)
    head = replace(light, **run.head)
    settings = replace(TrainSettings(epochs=2), **run.train)
    try:
        trained = train(source, head, settings, bank=bank, seed=run.seed)
    except OmniVatError as error:
        return {"group": run.group, "held": False, "refused": str(error)}
    answers = predicted_probabilities(trained.model, source)["fused"]
    values = [value for record in trained.epochs for value in record.values()]
    finite = (
        all(bool(t.isfinite().all()) for t in trained.model.state_dict().values())
        and bool(answers.isfinite().all())
        and all(map(math.isfinite, values))
    )
    last = trained.epochs[-1]
    return {
        "group": run.group,
        "held": finite,
        "refused": "",
        "clipped": last["clipped"],
        "order_clipped": last["order_clipped"],
        "order": last["order"],
        "turns": last["order"] % 4,
        "cross_entropy": last["cross_entropy"],
    }


def table(records: list[dict[str, Any]]) -> str:
    """Return the report's table: one row for each group."""
    lines = [
        "| what | runs | held | refused | steps clipped | p clamped | p at the end | mod 4 | CE |",
        "| --- | --- | --- | --- | --- | --- | --- | --- | --- |",
    ]
    for group, members in itertools.groupby(sorted(records, key=lambda r: r["place"]), key=lambda r: r["group"]):
        rows = list(members)
        done = [r for r in rows if not r["refused"]]
        cells = [group, str(len(rows)), str(sum(r["held"] for r in rows))]
        cells.append(str(len(rows) - len(done)))
        cells += [_range(done, name, form) for name, form in (
            ("clipped", ".0%"), ("order_clipped", ".0%"), ("order", ".3f"), ("turns", ".3f"),
            ("cross_entropy", ".2f"),
        )]  # fmt: skip
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines)


def _range(records: list[dict[str, Any]], name: str, form: str) -> str:
    if not records:
        return ""
    low, high = (f(r[name] for r in records) for f in (min, max))
    return f"{low:{form}}" if low == high else f"{low:{form}} to {high:{form}}"


def main() -> None:
    """Run all, print the table, write the report and its JSON."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--pairs", type=int, default=60)
    parser.add_argument("--out", type=Path, default=Path("docs/benchmarks/training_stability"))
    arguments = parser.parse_args()
    torch.set_num_threads(1)
    bank, shipped, records = load_bank(), load_embeddings(SHIPPED), []
    listed = runs(shipped.header.domains)
    first = {run.group: place for place, run in reversed(list(enumerate(listed)))}
    for run in listed:
        records.append(attempt(run, arguments.pairs, bank, shipped) | {"place": first[run.group]})
    held, refused = sum(r["held"] for r in records), sum(bool(r["refused"]) for r in records)
    summary = (
        f"{len(records)} trainings of two epochs: {held} held, {refused} refused with a sentence, "
        f"{len(records) - held - refused} gave NaN or infinity."
    )
    print(summary)
    print(table(records))
    arguments.out.parent.mkdir(parents=True, exist_ok=True)
    arguments.out.with_suffix(".json").write_text(
        json.dumps({"machine": machine(), "runs": records}, indent=1) + "\n", encoding="utf-8"
    )
    arguments.out.with_suffix(".md").write_text(
        f"# Does training hold?\n\n`python -m benchmarks.training_stability`\n\n{summary}\n\n"
        "The light head, the project's LANG bank; sources are the eight shipped domains, and "
        "made-up embeddings of five classes for what follows them. *Steps clipped*: share of the last epoch's steps on which the gradient norm was held to its "
        "limit; *p clamped*: the same for p's own gradient; ranges are over runs.\n\n"
        f"{table(records)}\n\n{P_EXPLAINED}\n",
        encoding="utf-8",
    )


if __name__ == "__main__":
    main()
