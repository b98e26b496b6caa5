"""A head for one's own pictures: it learns from all domains of a set, each standardised by its own
profile.

Pictures of a sensor that nobody has seen are read best by a head of many sensors. Every domain is
moved onto the mean of all profiles, so that what is left differs by material and not by sensor; a
visitor's pictures are moved there by a profile of their own. Linear maps of photo, touch and both
decide (`omnivat.head.linear_maps`), at temperatures that domains give which the maps have not seen.
An OmniVaT head of the same pairs gives the stages and the tree.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from statistics import fmean
from typing import Any

import numpy as np
import torch
from torch import Tensor

from omnivat.data.profile import Channels, Profile, profile_of, profiled
from omnivat.data.store import Embeddings
from omnivat.head.calibration import familiarity_of, fit_temperature
from omnivat.head.checkpoint import Head
from omnivat.head.head import OmniVaT
from omnivat.head.linear_maps import FittedMaps, fit_maps
from omnivat.kit.errors import DataError
from omnivat.kit.progress import OnStep, Step, ignore
from omnivat.kit.stages import IMAGES
from omnivat.measure import rungs
from omnivat.measure.known import measured, parts
from omnivat.measure.readers import of_maps
from omnivat.measure.rungs import DRAWS
from omnivat.training import TrainSettings, Watch, plan_training, trained_head

ALL = "all domains"  # the source of such a head
PICTURES = (0, 5, 20)  # of a left-out domain, without labels
BODY = {"width": 64}
TRAINING = TrainSettings(epochs=30, batch=64, lang=False)
KEPT = 3  # every third pair is kept for familiarity, so that the folder stays small
NOISE, STEPS = 1.0, 150  # of the maps; 0 and 2 are worse on left-out domains, by 1 to 3 points
READINGS = ("fused", *IMAGES)
Raw = dict[str, Tensor]


def pooled_head(embeddings: Embeddings, *, seed: int, on_step: OnStep = ignore) -> Head:
    """Return a head that learned from the training pairs of all domains of a set.

    `metrics["left_out"]` has what such a head reads right in domains left out of its training:
    number of pictures without labels -> reading -> share, mean over domains and draws. Raises
    DataError for a set of fewer than three domains: one is left out to calibrate the others.
    """
    domains = embeddings.header.domains
    if len(domains) < 3:
        raise DataError(
            f"The set has {len(domains)} domain(s), and a head of all domains needs three or more: "
            "one after the other is left out to calibrate it."
        )
    temperature, left_out = _left_out(embeddings, seed, on_step)
    levelled, _ = level(embeddings, domains)
    pooled = _pooled(levelled)
    plan = plan_training(pooled, ALL, head=BODY, training=TRAINING, seed=seed)
    head = trained_head(plan, calibrate=False, watch=Watch(on_step=on_step))
    pairs = plan.pairs
    fitted = _fitted(pairs, head.source_profile.channels, seed)
    model = with_maps(head.model, fitted, temperature)
    some = pairs.select(np.arange(0, len(pairs), KEPT))
    familiar = familiarity_of(**_raw(some), objects=some.rows["object"])
    facts = {"maps": {"temperature": temperature}, "domains": list(domains)}
    return replace(
        head,
        model=model,
        familiarity=familiar,
        provenance={**head.provenance, **facts},
        metrics={"left_out": left_out},
    )


def level(embeddings: Embeddings, domains: Sequence[str]) -> tuple[Embeddings, Profile]:
    """Return embeddings with `domains` moved onto the mean of their profiles, and that mean."""
    profiles = {
        name: profile_of(embeddings, embeddings.rows_of(name, split="train"), domain=name)
        for name in domains
    }
    channels = {}
    for name in IMAGES:
        each = [profile.channels[name] for profile in profiles.values()]
        mean, variance = np.mean([(channel.mean, channel.variance) for channel in each], axis=0)
        channels[name] = Channels(mean=mean, variance=variance, count=sum(x.count for x in each))
    base = Profile(channels=channels, key=embeddings.header.key, domain=ALL)
    return profiled(embeddings, profiles, base), base


def with_maps(model: OmniVaT, fitted: FittedMaps, temperature: Mapping[str, float]) -> OmniVaT:
    """Return the model with linear maps that decide; each map's logits are divided by its
    temperature.
    """
    width = model.settings.input_width
    length = (2 * width) ** 0.5  # the maps learned rows of length √W, and `standing` has √½
    maps = fitted.maps.state_dict()
    weight = {n: maps[f"maps.{n}.weight"] * (length / t) for n, t in temperature.items()}
    bias = {n: maps[f"maps.{n}.bias"] / t for n, t in temperature.items()}
    state = {
        **model.state_dict(),
        "map_rows": torch.stack(weight["both"].split(width, dim=1)),
        "map_bias": bias["both"],
        "map_alone_rows": torch.stack([weight[name] for name in IMAGES]),
        "map_alone_bias": torch.stack([bias[name] for name in IMAGES]),
    }
    with torch.device("meta"):
        decided = OmniVaT(replace(model.settings, maps=True))
    decided.load_state_dict(state, assign=True)
    return decided.eval().requires_grad_(False)


def _fitted(pairs: Embeddings, profile: Mapping[str, Channels], seed: int) -> FittedMaps:
    labels, classes = torch.from_numpy(pairs.label), len(pairs.header.classes)
    return fit_maps(
        _raw(pairs), labels, classes, profile=profile, noise=NOISE, seed=seed, steps=STEPS
    )


def _raw(pairs: Embeddings) -> Raw:
    return {name: torch.from_numpy(np.array(getattr(pairs, name), np.float32)) for name in IMAGES}


def _pooled(embeddings: Embeddings) -> Embeddings:
    """Return the pairs as one domain; objects keep their domain in their name."""
    names = [embeddings.header.domains[index] for index in embeddings.domain]
    objects = [
        f"{domain}/{name or row}"
        for row, (domain, name) in enumerate(zip(names, embeddings.rows["object"], strict=True))
    ]
    return replace(
        embeddings,
        header=replace(embeddings.header, domains=(ALL,)),
        domain=np.zeros_like(embeddings.domain),
        rows={**embeddings.rows, "object": objects},
    )


def _left_out(
    embeddings: Embeddings, seed: int, on_step: OnStep
) -> tuple[dict[str, float], dict[str, dict[str, float]]]:
    """Leave out one domain after the other; return a temperature for each map, and accuracies."""
    domains = embeddings.header.domains
    logits: dict[str, list[Tensor]] = {}
    labels: list[Tensor] = []
    right: dict[int, list[dict[str, Any]]] = {count: [] for count in PICTURES}
    for done, name in enumerate(domains):
        others = tuple(other for other in domains if other != name)
        levelled, base = level(embeddings, others)
        rows = np.concatenate([levelled.rows_of(other, split="train") for other in others])
        pairs = levelled.select(rows)
        fitted = _fitted(pairs.select(pairs.labelled), base.channels, seed)
        maps = of_maps(fitted, embeddings.header, source="")
        left = embeddings.select(embeddings.rows_of(name))
        for count in PICTURES:
            right[count].append(measured(maps, left, rungs.pairs(count))["scores"])
        for draw in range(DRAWS):
            drawn = parts(maps, left, rungs.pairs(PICTURES[-1]), seed=draw)
            part = next(part for part in drawn if part.domain == name)
            test = part.embeddings.select(part.rows)
            test = test.select(test.labelled)
            for each, values in fitted.maps.logits(fitted.standard(_raw(test))).items():
                logits.setdefault(each, []).append(values)
            labels.append(torch.from_numpy(test.label))
        on_step(Step(done=done + 1, total=len(domains), text=f"{name} left out"))
    temperature = {n: fit_temperature(torch.cat(v), torch.cat(labels)) for n, v in logits.items()}
    means = {
        str(count): {n: round(fmean(result[n]["accuracy"] for result in each), 4) for n in READINGS}
        for count, each in right.items()
    }
    return temperature, means
