"""The search for p on chirps of this program and of another, for the study of the order."""

import time
from dataclasses import asdict
from typing import Any

import numpy as np

from benchmarks.studies._order_runs import CHIRP_HEAD, CHIRP_TRAINING, other_seed, scored
from benchmarks.studies._order_sets import WIDTH
from benchmarks.studies._other_chirps import Recipe, beside, drawn, embeddings_of
from omnivat.data.store import Embeddings
from omnivat.simulate.chirps import ChirpSettings, chirp_embeddings
from omnivat.training import TrainSettings, Watch, train
from omnivat.training.from_pairs import plan_training
from omnivat.training.order_search import search_order

NEAR = (0.05, 0.1, 0.15, 0.2)  # p* beside interference at 0
CURVE = ("orders", "score", "spread", "round")  # what a search found at each order


def search_of(seed: int) -> dict[str, Any]:
    """Run one search and one training by gradient alone."""
    settings = other_seed(ChirpSettings(), seed)
    made, source = chirp_embeddings(settings), settings.domain_names[0]
    pairs = made.in_domain(source, split="train")
    start = float(np.random.default_rng([7, seed]).uniform(-2, 2))
    values = {"width": WIDTH, "order": start, **CHIRP_HEAD}
    head = plan_training(made, source, head=values, training=CHIRP_TRAINING).settings
    found: dict[str, Any] = {"seed": seed, "p_star": settings.order, "start": start}
    for name, asked in (("search", True), ("gradient", False)):
        training = TrainSettings(epochs=40, lang=False, order_search=asked)
        before = time.process_time()
        trained = train(pairs, head, training, seed=seed)
        found[name] = {
            "order": trained.model.order,
            "unseen": scored(trained.model, made, source).unseen,
            "cpu_s": round(time.process_time() - before, 2),
            "search_steps": trained.search.get("steps", 0),
        }
    return found


def alone_of(program: str, seed: int) -> dict[str, Any]:
    """Search for p* of one draw of chirps: of "this" program, of the "other", or "beside" p*."""
    if program == "this":
        settings = other_seed(ChirpSettings(), seed)
        made, known = chirp_embeddings(settings), {"order": settings.order, "width": settings.width}
    else:
        recipe = beside(seed) if program == "beside" else drawn(seed)
        made, known = embeddings_of(recipe), asdict(recipe)
    head = {"width": known["width"], **CHIRP_HEAD}
    found = search_alone(made, made.header.domains[0], head, CHIRP_TRAINING)
    return {"program": program, "seed": seed} | known | found


def near_of(order: float, touch: float, seed: int) -> dict[str, Any]:
    """Search for p* of a draw whose interference is at 0 in photos and at `touch` in touches."""
    made = embeddings_of(Recipe(order=order, near=((0.0, touch),) * 3, seed=seed))
    head = {"width": made.width, **CHIRP_HEAD}
    found = search_alone(made, made.header.domains[0], head, CHIRP_TRAINING)
    return {"seed": seed, "order": order, "touch": touch} | found


def search_alone(
    made: Embeddings, source: str, head: dict[str, Any], training: TrainSettings, curve: bool = False
) -> dict[str, Any]:
    """Search without a training; return the order, its ties and the cost, and the curve if asked."""
    plan = plan_training(made, source, head=head, training=training)
    before = time.process_time()
    found = search_order(plan.pairs, plan.settings, plan.training, seed=0, watch=Watch())
    return {
        "found": found["start"],
        "between": found["between"],
        "ties": found["ties"],
        "lowest": min(found["score"]),
        "highest": max(found["score"]),
        "orders": found["steps"],
        "cpu_s": round(time.process_time() - before, 2),
    } | ({"curve": {name: found[name] for name in CURVE}} if curve else {})
