"""The methods of `benchmarks.table`: each learns the training pairs of one source domain."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor
from torch.nn.functional import cross_entropy, normalize, one_hot

from omnivat.data.embeddings import Embeddings
from omnivat.data.profile import STEP_SHIFTED, Channels, profile_of, standardised
from omnivat.encoders.lang.bank import DEFAULT_BANK, load_bank
from omnivat.head.linear_maps import FittedMaps, fit_maps
from omnivat.kit.seeding import derive_seed
from omnivat.kit.stages import IMAGES
from omnivat.kit.tables import load
from omnivat.study.baselines import BASELINES
from omnivat.study.baselines import linear_maps as maps_method
from omnivat.study.baselines.contract import Source, seeded
from omnivat.study.baselines.descent import size
from omnivat.study.baselines.erm_mlp import Perceptron
from omnivat.study.comparison.ridge import ridge as regression
from omnivat.training import TrainingPlan, TrainSettings, plan_training, train
from omnivat.training.batches import batches, labels_of

Array = NDArray[Any]
Raw = Mapping[str, Tensor]  # embeddings (N, W) of "vis", "tac" or both
# of every head that is trained in batches
RECIPE: dict[str, Any] = {"noise": 4.0, "shift": 1.0, "epochs": 120}
# as their own files train them
PUBLISHED = ("baseline", "vt_cmc_head", "ldc_icd", "sitr_supcon")
PENALTY = 1.0  # of the ridge regression


@dataclass(frozen=True, slots=True, kw_only=True)
class Learned:
    """A method that has learned one source.

    readings  raw embeddings -> class probabilities (N, K): "fused", and of one image "vis", "tac"
    features  raw embeddings of both -> (N, F), the last before classification
    step      share of the way that a profile moves a target, as in a head of the recipe
    alone     it reads one image alone
    """

    readings: Callable[[Raw], dict[str, Tensor]]
    features: Callable[[Raw], Tensor]
    parameters: int
    step: float = 1.0
    alone: bool = True


def raw_of(embeddings: Embeddings, rows: Array) -> dict[str, Tensor]:
    """Return embeddings of some pairs by modality."""
    return {n: torch.from_numpy(np.array(getattr(embeddings, n)[rows], np.float32)) for n in IMAGES}


def _plan(embeddings: Embeddings, source: str, seed: int, **head: Any) -> TrainingPlan:
    head, training = {"width": 64, **head}, TrainSettings(**RECIPE)
    return plan_training(embeddings, source, head=head, training=training, seed=seed)


def omnivat(embeddings: Embeddings, source: str, seed: int, **head: Any) -> Learned:
    """Train OmniVaT by the page's recipe: D = 64, noise and imitated sensors, texts in training."""
    plan = _plan(embeddings, source, seed, **head)
    model = train(plan.pairs, plan.settings, plan.training, bank=plan.bank, seed=seed).model
    places = [embeddings.header.classes.index(name) for name in plan.settings.classes]

    def wide(values: Tensor) -> Tensor:
        return values.new_zeros(len(values), len(embeddings.header.classes)).index_copy(
            1, torch.tensor(places), values
        )

    @torch.inference_mode()
    def readings(raw: Raw) -> dict[str, Tensor]:
        output = model(raw.get("vis"), raw.get("tac")).readings
        return {name: wide(output[name]) for name in ("fused", *raw)}

    @torch.inference_mode()
    def features(raw: Raw) -> Tensor:
        rows = model(raw["vis"], raw["tac"]).f_hat.values()
        return torch.cat([normalize(x, dim=-1) for x in rows], 1)

    return Learned(readings=readings, features=features, parameters=size(model), step=STEP_SHIFTED)


def dtg(embeddings: Embeddings, source: str, seed: int) -> Learned:
    """Train the tree alone, without MFFA, by the same recipe."""
    return omnivat(embeddings, source, seed, mffa=False)


def erm_mlp(embeddings: Embeddings, source: str, seed: int) -> Learned:
    """Train ERM-MLP on both images by the same recipe: input, mirroring, noise, shift, batches."""
    plan = _plan(embeddings, source, seed)
    own = profile_of(plan.pairs).channels
    labels = labels_of(plan.pairs, plan.settings)
    with seeded(derive_seed(seed, "erm-mlp")):
        model = Perceptron(plan.pairs.width, len(plan.settings.classes), IMAGES)
        optimiser = torch.optim.AdamW(model.parameters(), lr=3e-4, weight_decay=1e-2, fused=True)
        steps = plan.training.epochs * -(-len(labels) // plan.training.batch)
        rates = torch.optim.lr_scheduler.CosineAnnealingLR(optimiser, steps)
        for epoch in range(plan.training.epochs):
            stream = derive_seed(seed, "epoch", epoch)
            for batch in batches(plan.pairs, labels, None, plan.training, stream):
                logits = model(*(_standard(batch.images[n], own[n]) for n in IMAGES))
                optimiser.zero_grad(set_to_none=True)
                cross_entropy(logits, batch.labels).backward()
                optimiser.step()
                rates.step()
    model.requires_grad_(False).eval()
    places = torch.tensor([embeddings.header.classes.index(n) for n in plan.settings.classes])

    def readings(raw: Raw) -> dict[str, Tensor]:
        shares = model(*(_standard(raw[n], own[n]) for n in IMAGES)).softmax(-1)
        wide = shares.new_zeros(len(shares), len(embeddings.header.classes))
        return {"fused": wide.index_copy(1, places, shares)}

    def features(raw: Raw) -> Tensor:
        rows: Tensor = model.features(*(_standard(raw[n], own[n]) for n in IMAGES))
        return rows

    return Learned(
        readings=readings, features=features, parameters=size(model), step=STEP_SHIFTED, alone=False
    )


def _standard(rows: Tensor, source: Channels) -> Tensor:
    return torch.from_numpy(standardised(rows.numpy(), source)).float()


@cache
def _noise_of(digest: str) -> list[str]:
    """Return what the first seed chose for a source; empty before."""
    return []


def noise_of(embeddings: Embeddings, source: str) -> str:
    """Return the training noise that linear maps choose on a source."""
    chosen = _noise_of(f"{source}, {embeddings.header.origin}")
    if not chosen:
        chosen.append(maps_method._chosen(source_of(embeddings, source, 0)))
    return chosen[0]


def _fitted_maps(embeddings: Embeddings, source: str, seed: int) -> FittedMaps:
    noise = noise_of(embeddings, source)
    origin, pairs = embeddings.header.origin, source_of(embeddings, source, seed)
    return _maps(origin, source, seed, noise, pairs)


_KEPT: dict[tuple[str, str, int, int], FittedMaps] = {}


def _maps(origin: str, source: str, seed: int, noise: str, pairs: Source) -> FittedMaps:
    key = (origin, source, seed, len(pairs))
    if key not in _KEPT:
        for old in list(_KEPT)[:-1]:  # that of the colours and that of the relief are kept
            del _KEPT[old]
        _KEPT[key] = maps_method._fitted(pairs, noise)
    return _KEPT[key]


def three_maps(colours: Embeddings, drawn: Embeddings, source: str, seed: int) -> FittedMaps:
    """Train linear maps of photo, touch in colours, touch as relief, and all three side by side;
    their noise is that of the colours' maps.
    """
    rows = colours.rows_of(source, split="train")
    raw = raw_of(colours, rows) | {"relief": raw_of(drawn, rows)["tac"]}
    return _of_colours(colours, raw, source, seed)


def wide_maps(colours: Embeddings, wide: Embeddings, source: str, seed: int) -> Learned:
    """Train linear maps of photo, touch and both on a touch that is one vector of its colours
    beside its relief; their noise is that of the colours' maps.
    """
    rows = colours.rows_of(source, split="train")
    return of_maps(_of_colours(colours, raw_of(wide, rows), source, seed))


def _of_colours(colours: Embeddings, raw: Raw, source: str, seed: int) -> FittedMaps:
    """Train linear maps on the training pairs of a source, with the noise that colours choose."""
    rows = colours.rows_of(source, split="train")
    white, shift = maps_method.CANDIDATES[noise_of(colours, source)]
    return fit_maps(
        raw,
        torch.from_numpy(colours.label[rows]),
        len(colours.header.classes),
        noise=white,
        shift=shift,
        seed=derive_seed(seed, "linear maps"),
    )


def linear_maps(embeddings: Embeddings, source: str, seed: int) -> Learned:
    """Train linear maps of photo, touch and both; their noise is chosen on the source."""
    return of_maps(_fitted_maps(embeddings, source, seed))


def of_maps(fitted: FittedMaps) -> Learned:
    """Return fitted linear maps as a method."""
    return Learned(readings=fitted, features=_both(fitted), parameters=size(fitted.maps))


def logistic(embeddings: Embeddings, source: str, seed: int) -> Learned:
    """Return the map of both alone: logistic regression with the same fresh noise."""
    fitted = _fitted_maps(embeddings, source, seed)

    def readings(raw: Raw) -> dict[str, Tensor]:
        found = fitted(raw)
        if len(raw) > 1:
            found["fused"] = fitted.maps.logits(fitted.standard(raw))["both"].softmax(-1)
        return found

    return Learned(
        readings=readings, features=_both(fitted), parameters=size(fitted.maps.maps["both"])
    )


def _both(fitted: FittedMaps) -> Callable[[Raw], Tensor]:
    return lambda raw: torch.cat(list(fitted.standard(raw).values()), 1)


def nearest_mean(embeddings: Embeddings, source: str, seed: int) -> Learned:
    """Return softmax(10 cosine) to class means of standardised rows."""
    pairs = source_of(embeddings, source, seed)
    own = profile_of(embeddings.in_domain(source, split="train")).channels
    classes = len(pairs.classes)

    def rows_of(raw: Raw) -> Tensor:
        return torch.cat([normalize(_standard(x, own[n]), dim=-1) for n, x in raw.items()], 1)

    def shares(raw: Raw) -> Tensor:
        known = {n: x for n, x in pairs.images.items() if n in raw}
        rows, labels = rows_of(known), pairs.labels
        sums = rows.new_zeros(classes, rows.shape[1]).index_add(0, labels, rows)
        cosines = normalize(rows_of(raw), dim=-1) @ normalize(sums, dim=-1).T
        absent = torch.bincount(labels, minlength=classes) == 0
        return (10 * cosines).masked_fill(absent, -torch.inf).softmax(-1)

    def readings(raw: Raw) -> dict[str, Tensor]:
        return {"fused": shares(raw), **{n: shares({n: x}) for n, x in raw.items()}}

    return Learned(readings=readings, features=rows_of, parameters=2 * classes * pairs.width)


def published(name: str, embeddings: Embeddings, source: str, seed: int) -> Learned:
    """Train a method of the paper as its file does, on rows standardised by the source's
    profile.
    """
    pairs = source_of(embeddings, source, seed)
    own = profile_of(embeddings.in_domain(source, split="train")).channels
    standard = {n: _standard(x, own[n]) for n, x in pairs.images.items()}
    fitted = load(BASELINES, name, kind="method")(
        replace(pairs, vis=standard["vis"], tac=standard["tac"])
    )

    def readings(raw: Raw) -> dict[str, Tensor]:
        rows = {n: _standard(x, own[n]) for n, x in raw.items()}
        other = next(iter(rows.values()))
        found = fitted.predict(rows.get("vis", other), rows.get("tac", other))
        return (
            found
            if len(raw) > 1
            else {n: found[n] for n in raw} | {"fused": found[next(iter(raw))]}
        )

    def features(raw: Raw) -> Tensor:
        rows: Tensor = fitted.features(*(_standard(raw[n], own[n]) for n in IMAGES))["pair"]
        return rows

    return Learned(readings=readings, features=features, parameters=fitted.parameters)


def source_of(embeddings: Embeddings, source: str, seed: int) -> Source:
    """Return the training pairs of a domain as a method of the paper takes them."""
    pairs = embeddings.in_domain(source, split="train")
    raw = raw_of(pairs, np.arange(len(pairs)))
    return Source(
        vis=raw["vis"],
        tac=raw["tac"],
        labels=torch.from_numpy(pairs.label),
        objects=tuple(pairs.rows["object"]),
        classes=embeddings.header.classes,
        lang=torch.from_numpy(
            load_bank(DEFAULT_BANK).for_classes(embeddings.header.classes).embeddings
        ),
        seed=seed,
    )


METHODS: dict[str, Callable[[Embeddings, str, int], Learned]] = {
    "omnivat": omnivat,
    "dtg": dtg,
    "erm_mlp": erm_mlp,
    "linear_maps": linear_maps,
    "logistic": logistic,
    "nearest_mean": nearest_mean,
}


def ridge(rows: Tensor, labels: Tensor, classes: int, weights: Tensor, queries: Tensor) -> Tensor:
    """Return the scores of a weighted ridge regression of one-hot classes as probabilities.

    Rows are brought to unit length. A class without a row gets probability 0.
    """
    rows, queries = (normalize(x.double(), dim=-1) for x in (rows, queries))
    hot = one_hot(labels, classes).double()
    learned = regression(rows.numpy(), hot.numpy(), PENALTY, weights.double().numpy())
    scores = torch.from_numpy(learned(queries.numpy()))
    absent = hot.sum(0) == 0
    shares: Tensor = (10 * scores).masked_fill(absent, -torch.inf).softmax(-1).float()
    return shares
