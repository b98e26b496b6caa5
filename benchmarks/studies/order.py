"""When does a fractional order help? The studies of docs/order.md, one for each subcommand.

    python -m benchmarks.studies.order STUDY [--jobs N] [--seeds N] [--first N] [--out DIR]

    basin     loss against p around a trained head's own p, for D = 16 to 512, and its width
    strength  chirps: gain of the right order over p = 0 and p = 1, by strength and domain shift
    search    chirps: result and cost of the search, with a new p* for every seed
    others    chirps of this program, of another, and with interference 0.12 from p*: result and cost of the search alone
    near      chirps of another program with interference at 0: the search for p* beside it
    shipped   the shipped chirps: the curve of the search
    ties      simulated sensors: the orders that the search cannot tell apart
    channels  channels in their order against permuted ones, projected or not, and rows of pictures
    sensors   search against p fixed at 0.5, on every source of the simulated sensors
    power     number of runs that shows a difference of one point, from the spread over seeds

Each writes DIR/order_STUDY.json; `python -m benchmarks.studies.order_figures` draws the figures.
"""

import argparse
import json
import time
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from itertools import product
from pathlib import Path
from statistics import fmean, stdev
from typing import Any

import numpy as np
import torch

from benchmarks.measure import machine
from benchmarks.studies._order_runs import (
    CHIRP_HEAD,
    CHIRP_TRAINING,
    QUICK_SENSORS,
    SENSORS,
    carried_out,
    chirp_head,
    head_at,
    other_seed,
    scored,
)
from benchmarks.studies._order_search import CURVE, NEAR, alone_of, near_of, search_alone, search_of
from benchmarks.studies._order_sets import WIDTH, permuted, picture_rows, some_channels
from omnivat.data.store import Embeddings, load_embeddings
from omnivat.head.head import OmniVaT
from omnivat.head.heads import EXAMPLES, default_embeddings
from omnivat.maps.frames import read_frames
from omnivat.measure.evaluate import predicted_probabilities
from omnivat.simulate.chirps import ChirpSettings, chirp_embeddings
from omnivat.training import train
from omnivat.training.from_pairs import plan_training

WIDTHS = (16, 32, 64, 128, 256, 512)
OFFSETS = np.linspace(-6.0, 6.0, 97)  # of p from the head's own, in units of 1/D quarter turns
STRENGTHS = (0.0, 0.5, 1.0, 2.0, 3.0, 4.0)
SHIFTS = (0.0, 1.0)
STOPS = (0.0, 0.25, 0.5, 0.75, 1.0)


def basin(options: argparse.Namespace) -> list[dict[str, Any]]:
    """Loss on training pairs against p, weights fixed."""
    jobs = [(width, away) for width in WIDTHS for away in (0.0, 0.15) if width <= options.widest]
    return list(carried_out(basin_of, jobs, options.jobs))


def basin_of(width: int, away: float) -> dict[str, Any]:
    """Train at p* + away, then move p: the loss at each offset, and the half width of its valley."""
    settings = ChirpSettings(width=width, seed=1)
    made = chirp_embeddings(settings)
    order = settings.order + away
    source = made.in_domain(settings.domain_names[0], split="train")
    model = chirp_head(settings, made, order)
    losses = [_loss(model, source, order + float(offset) / width) for offset in OFFSETS]
    return {
        "width": width,
        "p_star": settings.order,
        "trained_at": order,
        "offsets": (OFFSETS / width).tolist(),
        "loss": losses,
        "loss_at_p_star": _loss(model, source, settings.order),
        "half_width": half_width(OFFSETS / width, losses),
    }


def half_width(offsets: np.ndarray[Any, Any], losses: list[float]) -> float:
    """Return the half width of the valley at half height; mean of both sides."""
    middle, level = len(losses) // 2, np.array(losses)
    half = (level[middle] + np.median(level)) / 2
    sides = []
    for step in (1, -1):
        place = middle
        while 0 < place < len(level) - 1 and level[place] < half:
            place += step
        sides.append(abs(float(offsets[place])))
    return fmean(sides)


def _loss(model: OmniVaT, pairs: Embeddings, order: float) -> float:
    shares = predicted_probabilities(model, pairs, order=order)["fused"]
    right = shares[torch.arange(len(pairs)), torch.from_numpy(np.array(pairs.label))]
    return float(-right.double().clamp_min(1e-12).log().mean())


def strength(options: argparse.Namespace) -> list[dict[str, Any]]:
    """Accuracy of heads trained at p*, 0 and 1."""
    jobs = [(value, shift, seed) for value in STRENGTHS for shift in SHIFTS for seed in range(options.seeds)]
    return list(carried_out(strength_of, jobs, options.jobs))


def strength_of(value: float, shift: float, seed: int) -> dict[str, Any]:
    """Score heads at three orders on one set of chirps."""
    settings = other_seed(ChirpSettings(strength=value, shift=shift), seed)
    made, source = chirp_embeddings(settings), settings.domain_names[0]
    found = {
        name: scored(chirp_head(settings, made, order), made, source)
        for name, order in (("p*", settings.order), ("0", 0.0), ("1", 1.0))
    }
    return {
        "strength": value,
        "shift": shift,
        "seed": seed,
        "p_star": settings.order,
        "unseen": {name: score.unseen for name, score in found.items()},
        "source_test": {name: score.source_test for name, score in found.items()},
    }


def search(options: argparse.Namespace) -> list[dict[str, Any]]:
    """Search for p* from a random start, with a new p* for every seed; also the gradient alone."""
    return list(carried_out(search_of, [(seed,) for seed in range(options.seeds)], options.jobs))


def others(options: argparse.Namespace) -> list[dict[str, Any]]:
    """Search alone, on chirps of this program and of another."""
    jobs = [(name, seed) for name in ("other", "beside", "this") for seed in seeds_of(options)]
    return list(carried_out(alone_of, jobs, options.jobs))


def seeds_of(options: argparse.Namespace) -> range:
    """Return the seeds of the draws."""
    return range(options.first, options.first + options.seeds)


def near(options: argparse.Namespace) -> list[dict[str, Any]]:
    """Search alone, for p* near interference at 0 in photos, or in photos and touches."""
    jobs = product((0.5, 0.0), NEAR, seeds_of(options))
    return [near_of(order, touch, seed) for touch, order, seed in jobs]


def shipped(options: argparse.Namespace) -> list[dict[str, Any]]:
    """Search alone, on the shipped chirps, with its curve."""
    made = load_embeddings(EXAMPLES / "chirps" / "chirps.safetensors")
    head = {"width": made.width, **CHIRP_HEAD}
    return [search_alone(made, made.header.domains[0], head, CHIRP_TRAINING, curve=True)]


def ties(options: argparse.Namespace) -> list[dict[str, Any]]:
    """Search alone, on every source of the simulated sensors."""
    made = signals_of("projected", False)
    return [{"source": s} | search_alone(made, s, {"width": WIDTH}, SENSORS) for s in made.header.domains]


def channels(options: argparse.Namespace) -> list[dict[str, Any]]:
    """Heads at five orders on channels in their order and permuted."""
    jobs = [
        (kind, shuffled, order, seed)
        for seed in range(options.seeds)
        for kind in ("chirps", "projected", "unprojected", "rows")
        for shuffled in (False, True)
        for order in STOPS
    ]
    return list(carried_out(channels_of, jobs, options.jobs))


def channels_of(kind: str, shuffled: bool, order: float, seed: int) -> dict[str, Any]:
    """Score one head; chirps have their spike at the order 0.25."""
    made = signals_of(kind, shuffled)
    if kind == "chirps":
        source, training, head = made.header.domains[0], CHIRP_TRAINING, dict(CHIRP_HEAD)
    else:
        source, training, head = "TAG-sim", QUICK_SENSORS, {}
    model = head_at(made, source, order, seed, training, {**head, "width": WIDTH})
    found = scored(model, made, source)
    return {
        "kind": kind,
        "permuted": shuffled,
        "order": order,
        "seed": seed,
        "unseen": found.unseen,
        "source_test": found.source_test,
    }


@cache
def signals_of(kind: str, shuffled: bool) -> Embeddings:
    """Return the set of a kind, its channels in order or permuted."""
    if shuffled:
        return permuted(signals_of(kind, False))
    if kind == "chirps":
        return chirp_embeddings(ChirpSettings(order=0.25, seed=1))
    makers: dict[str, Callable[[Path], Embeddings]] = {
        "projected": load_embeddings,
        "unprojected": _some,
        "rows": picture_rows,
    }
    return makers[kind](default_embeddings())


def _some(file: Path) -> Embeddings:
    return some_channels(load_embeddings(file))


def sensors(options: argparse.Namespace) -> list[dict[str, Any]]:
    """Search for p on the simulated sensors, against p fixed at 0.5."""
    domains = load_embeddings(default_embeddings()).header.domains
    jobs = [(source, seed) for seed in range(options.seeds) for source in domains]
    return list(carried_out(sensors_of, jobs, options.jobs))


def sensors_of(source: str, seed: int) -> dict[str, Any]:
    """Score one head with a searched p and one with a fixed p."""
    made = signals_of("projected", False)
    found: dict[str, Any] = {"source": source, "seed": seed}
    for name, asked in (("search", True), ("fixed", False)):
        training = replace(SENSORS, order_search=asked)
        head = {"width": WIDTH, "learn_order": asked}
        plan = plan_training(made, source, head=head, training=training)
        before = time.process_time()
        trained = train(plan.pairs, plan.settings, plan.training, bank=plan.bank, seed=seed)
        found[name] = {
            "order": trained.model.order,
            "unseen": scored(trained.model, made, source).unseen,
            "cpu_s": round(time.process_time() - before, 2),
            **{key: trained.search[key] for key in CURVE if trained.search},
        }
    print(json.dumps(found), flush=True)
    return found


def power(options: argparse.Namespace) -> list[dict[str, Any]]:
    """Number of runs for a difference of one point: two-sided 5 %, power 80 %."""
    frames = read_frames(options.frames)
    deviations = [100 * (s or 0.0) for s in frames.curves["seeds:accuracy/unseen/std"]]
    means = [100 * (m or 0.0) for m in frames.curves["seeds:accuracy/unseen/mean"]]
    pooled = float(np.sqrt(np.mean(np.square(deviations))))
    seeds = len(frames.head["seeds"])
    return [
        {
            "orders": len(means),
            "seeds": seeds,
            "pooled_std": pooled,
            "runs_for_one_point": int(np.ceil(2 * (1.96 + 0.8416) ** 2 * pooled**2)),
            "std_of_means": stdev(means),
            "std_of_means_expected_from_seeds": pooled / seeds**0.5,
            "range_of_means": max(means) - min(means),
        }
    ]


STUDIES: dict[str, Callable[[argparse.Namespace], list[dict[str, Any]]]] = {
    "basin": basin,
    "strength": strength,
    "search": search,
    "others": others,
    "near": near,
    "shipped": shipped,
    "ties": ties,
    "channels": channels,
    "sensors": sensors,
    "power": power,
}


def main() -> None:
    """Run one study and write its rows."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("study", choices=STUDIES)
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--first", type=int, default=0, help="first seed, of others and near")
    parser.add_argument("--widest", type=int, default=512, help="of basin")
    parser.add_argument("--frames", type=Path, default=EXAMPLES / "trained.bin", help="of power")
    parser.add_argument("--out", type=Path, default=Path("docs/benchmarks"))
    options = parser.parse_args()
    rows = STUDIES[options.study](options)
    record = {"study": options.study, "machine": machine(), "rows": rows}
    file = options.out / f"order_{options.study}.json"
    file.write_text(json.dumps(record, indent=1) + "\n", encoding="utf-8")
    print(f"{len(rows)} rows written to {file}")


if __name__ == "__main__":
    main()
