"""Frames with a separate head at every stop, trained with p fixed there."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from statistics import fmean, stdev
from typing import Any

from omnivat.head.checkpoint import Head, load_head
from omnivat.kit.errors import DataError
from omnivat.kit.progress import OnStep, Step, ignore
from omnivat.maps.frames.builder import FrameBuilder
from omnivat.maps.frames.records import FrameSet
from omnivat.maps.sweep import MEASURES, STAGES, STILL, walk
from omnivat.training.from_pairs.at_stops import stop_folder
from omnivat.training.from_pairs.plan import TrainingPlan

MAPS: Mapping[str, int] = {
    **{f"pca/{stage}": 1001 for stage in STAGES},
    "umap/raw": 1,
    "umap/f_hat": 1001,
}


def retrained_frames(
    plan: TrainingPlan,
    orders: Sequence[float],
    folder: Path,
    *,
    seeds: Sequence[int] = (0,),
    maps: Mapping[str, int] = MAPS,
    measures: Sequence[str] = MEASURES,
    on_step: OnStep = ignore,
) -> FrameSet:
    """Return the frames of the heads that `heads_at_stops` wrote to `folder`.

    Maps, predictions and most curves come from the first seed's heads. Curves whose names start
    with "seeds:" hold mean, standard deviation (n - 1), minimum and maximum over all seeds.

    Raises DataError if a head is missing.
    """
    # with a projection of its own each, heads differ in distances after the transform, too
    still = ("raw",) if plan.settings.projects else STILL
    builder = FrameBuilder(
        plan.settings,
        plan.embeddings,
        orders=orders,
        maps=maps,
        measures=measures,
        source=plan.source,
        still=still,
    )
    over_seeds: dict[str, list[float | None]] = {}
    for index, order in enumerate(orders):
        heads = [load_head(stop_folder(folder, order, one)) for one in seeds]
        stages = [stage for stage in builder.stages if index == 0 or stage not in still]
        found = next(
            iter(walk(heads[0].model, plan.embeddings, [order], stages=stages, predictions=True))
        )
        builder.add(replace(found, index=index))
        for name, value in _spread(heads).items():
            over_seeds.setdefault(name, [None] * len(orders))[index] = value
        on_step(Step(done=index + 1, total=len(orders), text=f"map of the head at {order:.2f}"))
    builder.curves |= over_seeds
    return builder.finish(
        {
            "kind": "retrained",
            "learned_order": None,
            "source": plan.source,
            "width": plan.settings.width,
            "epochs": plan.training.epochs,
            "seeds": list(seeds),
            "simulated": plan.embeddings.header.simulated,
        }
    )


def _spread(heads: Sequence[Head]) -> dict[str, float | None]:
    """Return "seeds:NAME/mean" and so on for every score of heads that differ only in the seed."""
    each = [_scores(head) for head in heads]
    found: dict[str, float | None] = {}
    for name in (name for name in each[0] if all(name in scores for scores in each)):
        values = [scores[name] for scores in each]
        std = stdev(values) if len(values) > 1 else None
        of_seeds = {"mean": fmean(values), "std": std, "low": min(values), "high": max(values)}
        found |= {f"seeds:{name}/{kind}": value for kind, value in of_seeds.items()}
    return found


def _scores(head: Head) -> dict[str, float]:
    """Return the scores in a head's folder, by curve name."""
    metrics: Mapping[str, Any] = head.metrics
    if "measures" not in metrics:
        raise DataError(f"'{head.path}' holds no measures; remove it and train it again.")
    found = {name: float(value) for name, value in metrics["measures"].items()}
    if metrics.get("target_macro_f1") is not None:
        found["macro_f1/unseen"] = float(metrics["target_macro_f1"])
    for record in metrics["domains"]:
        if record["scores"]:
            found[f"accuracy/{record['domain']}"] = record["scores"]["fused"]["accuracy"]
    return found
