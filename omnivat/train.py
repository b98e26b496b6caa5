"""Train a head on one domain's embeddings. Nothing here ever sees another domain."""

import copy
import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import torch
from torch import Tensor

from omnivat.data.splits import hold_out
from omnivat.data.store import Embeddings
from omnivat.errors import DataError, OmniVatError, SettingsError
from omnivat.evaluate import predicted_probabilities
from omnivat.gaps.confusion import macro_f1
from omnivat.lang.bank import LangBank
from omnivat.losses.total import joint_loss
from omnivat.model.head import OmniVaT, build_head
from omnivat.model.settings import HeadSettings
from omnivat.progress import OnStep, Step, ignore
from omnivat.seeding import derive_seed

SELECTIONS = ("last", "source-val")


@dataclass(frozen=True, slots=True, kw_only=True)
class TrainSettings:
    """How a head is trained; reasons in docs/method.md."""

    epochs: int = 20
    batch: int = 16
    lr: float = 0.05
    momentum: float = 0.9
    weight_decay: float = 5e-4  # not on p and θ_e
    warmup_epochs: float = 1.0
    clip: float = 1.0  # gradient norm of all but p
    order_lr_scale: float = 0.01  # p's gradient is tens of times larger than the rest
    order_clip: float = 1.0  # p's gradient, by value
    mma_weight: float = 10.0  # λ
    nod_weight: float = 1.0
    lang: bool = True
    lang_drop: float = 0.5  # share of pairs that train without LANG, as they are predicted
    class_token_drop: float = 0.5  # share that see no label in their class token
    selection: str = "last"
    val_fraction: float = 0.2  # of the source's objects, for "source-val"

    def __post_init__(self) -> None:
        if self.selection not in SELECTIONS:
            raise SettingsError(
                f"selection is '{self.selection}'; choose one of {', '.join(SELECTIONS)}."
            )
        for name, low, high in (
            ("epochs", 1, 100_000),
            ("batch", 1, 65_536),
            ("lr", 0.0, 100.0),
            ("mma_weight", 0.0, 1e6),
            ("nod_weight", 0.0, 1e6),
            ("lang_drop", 0.0, 1.0),
            ("class_token_drop", 0.0, 1.0),
            ("val_fraction", 0.0, 0.9),
        ):
            if not low <= getattr(self, name) <= high:
                raise SettingsError(f"{name} is {getattr(self, name)}; choose {low} to {high}.")


@dataclass(frozen=True, slots=True, kw_only=True)
class Trained:
    """A trained model and the record of its training."""

    model: OmniVaT
    epochs: list[dict[str, float]] = field(default_factory=list)
    chosen_epoch: int = 0


@dataclass(frozen=True, slots=True, kw_only=True)
class _Batch:
    vis: Tensor
    tac: Tensor
    lang: Tensor | None
    labels: Tensor
    lang_on: Tensor
    token_on: Tensor


def train(
    source: Embeddings,
    head: HeadSettings,
    settings: TrainSettings,
    *,
    bank: LangBank | None = None,
    seed: int = 0,
    on_step: OnStep = ignore,
) -> Trained:
    """Train a head on the pairs of one source domain.

    source  training pairs of one domain; their labels index header.classes, of which head.classes
            must be the ones present
    bank    LANG for those classes, or None to train without text
    seed    everything random derives from it: same seed, same machine, same weights

    Raises DataError when there is nothing to learn, OmniVatError when the loss is not finite.
    """
    labels = _labels(source, head)
    fit, held = _held_out(source, labels, settings, seed)
    model = build_head(head, seed=derive_seed(seed, "weights")).train()
    optimiser = _optimiser(model, settings)
    steps = math.ceil(len(fit) / settings.batch)
    epochs: list[dict[str, float]] = []
    best: tuple[float, int, dict[str, Any]] = (-1.0, settings.epochs - 1, {})
    for epoch in range(settings.epochs):
        sums: dict[str, float] = {}
        batches = _batches(source, labels, fit, bank, settings, derive_seed(seed, "epoch", epoch))
        for step, batch in enumerate(batches):
            _set_rate(optimiser, settings, (epoch * steps + step) / steps, 1 / steps)
            losses = _learn(model, optimiser, batch, settings)
            for name, value in losses.items():
                sums[name] = sums.get(name, 0.0) + value / steps
            done = epoch * steps + step + 1
            on_step(
                Step(done=done, total=steps * settings.epochs, text=f"loss {losses['loss']:.3f}")
            )
        record = {"epoch": float(epoch), **sums, "order": model.order}
        if len(held):
            score = _source_score(model, source.select(held), labels[held])
            record["source_val_macro_f1"] = score
            if score > best[0]:
                best = (score, epoch, copy.deepcopy(model.state_dict()))
        epochs.append(record)
    if best[2]:
        model.load_state_dict(best[2])
    return Trained(model=model.eval(), epochs=epochs, chosen_epoch=best[1])


def _labels(source: Embeddings, head: HeadSettings) -> np.ndarray[Any, Any]:
    """Return indices into head.classes of the source's pairs."""
    if not len(source):
        raise DataError("The source domain has no training pairs.")
    names = source.header.classes
    lookup = np.array([head.classes.index(n) if n in head.classes else -1 for n in names])
    labels = lookup[source.label]
    if (labels < 0).any():
        lacking = names[int(source.label[labels < 0][0])]
        raise DataError(f"The source has pairs of '{lacking}', which the head does not know.")
    if len(np.unique(labels)) < 2:
        raise DataError("The source domain has pairs of one class only; two or more are needed.")
    return labels


def _held_out(
    source: Embeddings, labels: np.ndarray[Any, Any], settings: TrainSettings, seed: int
) -> tuple[np.ndarray[Any, Any], np.ndarray[Any, Any]]:
    """Return indices of pairs to fit and of pairs held out for selection, whole objects each."""
    everything = np.arange(len(source))
    if settings.selection == "last" or settings.val_fraction == 0:
        return everything, everything[:0]
    held = hold_out(
        source.rows["object"], labels, settings.val_fraction, seed=derive_seed(seed, "hold-out")
    )
    return everything[~held], everything[held]


def _source_score(model: OmniVaT, held: Embeddings, labels: np.ndarray[Any, Any]) -> float:
    model.eval()
    answers = predicted_probabilities(model, held)["fused"].argmax(-1)
    model.train()
    return float(macro_f1(torch.from_numpy(labels), answers))


def _optimiser(model: OmniVaT, settings: TrainSettings) -> torch.optim.SGD:
    """SGD in three groups: p (slow, clamped), θ_e (no decay) and everything else."""
    order, theta = [model.mffa.order], list(model.mffa.theta.values())
    apart = {id(parameter) for parameter in (*order, *theta)}
    rest = [p for p in model.parameters() if id(p) not in apart]
    groups: list[dict[str, Any]] = [
        {"params": rest, "weight_decay": settings.weight_decay, "scale": 1.0},
        {"params": theta, "weight_decay": 0.0, "scale": 1.0},
    ]
    if model.mffa.order.requires_grad:
        groups.append({"params": order, "weight_decay": 0.0, "scale": settings.order_lr_scale})
    return torch.optim.SGD(groups, lr=settings.lr, momentum=settings.momentum)


def _set_rate(
    optimiser: torch.optim.SGD, settings: TrainSettings, epoch: float, step: float
) -> None:
    """Linear warm-up by step, then cosine to zero. epoch and step count in epochs."""
    warm = min(settings.warmup_epochs, settings.epochs)
    if epoch < warm:
        share = (epoch + step) / warm
    else:
        share = 0.5 * (1 + math.cos(math.pi * (epoch - warm) / max(settings.epochs - warm, step)))
    for group in optimiser.param_groups:
        group["lr"] = settings.lr * group["scale"] * share


def _batches(
    source: Embeddings,
    labels: np.ndarray[Any, Any],
    fit: np.ndarray[Any, Any],
    bank: LangBank | None,
    settings: TrainSettings,
    seed: int,
) -> Iterator[_Batch]:
    """Yield one epoch: shuffled pairs, each half mirrored or not, a random style of text each."""
    random = np.random.default_rng(seed)
    shuffled = fit[random.permutation(len(fit))]
    for start in range(0, len(shuffled), settings.batch):
        rows = shuffled[start : start + settings.batch]
        truth = labels[rows]
        lang = None
        if bank is not None and settings.lang:
            styles = random.integers(bank.embeddings.shape[1], size=len(rows))
            lang = torch.from_numpy(bank.embeddings[truth, styles])
        yield _Batch(
            vis=_mirrored(source.vis, source.vis_flip, rows, random),
            tac=_mirrored(source.tac, source.tac_flip, rows, random),
            lang=lang,
            labels=torch.from_numpy(truth),
            lang_on=torch.from_numpy(random.random(len(rows)) >= settings.lang_drop),
            token_on=torch.from_numpy(random.random(len(rows)) >= settings.class_token_drop),
        )


def _mirrored(
    plain: np.ndarray[Any, Any],
    flipped: np.ndarray[Any, Any] | None,
    rows: np.ndarray[Any, Any],
    random: np.random.Generator,
) -> Tensor:
    """Return embeddings of the rows, each of the mirrored image with probability a half."""
    chosen = np.asarray(plain[rows], dtype=np.float32)
    if flipped is not None:
        mirror = random.random(len(rows)) < 0.5
        chosen[mirror] = flipped[rows[mirror]]
    return torch.from_numpy(chosen)


def _learn(
    model: OmniVaT, optimiser: torch.optim.SGD, batch: _Batch, settings: TrainSettings
) -> dict[str, float]:
    """Take one optimiser step; return the losses as numbers."""
    output = model.training_pass(
        batch.vis,
        batch.tac,
        batch.lang,
        batch.labels,
        lang_on=batch.lang_on,
        token_on=batch.token_on,
    )
    losses = joint_loss(
        features=output.features,
        layers=output.layers,
        logits=output.logits,
        labels=batch.labels,
        mma_weight=settings.mma_weight,
        nod_weight=settings.nod_weight,
    )
    optimiser.zero_grad(set_to_none=True)
    losses.total.backward()  # type: ignore[no-untyped-call]
    order = model.mffa.order
    rest = [p for p in model.parameters() if p is not order]
    norm = torch.nn.utils.clip_grad_norm_(rest, settings.clip)
    if not (math.isfinite(float(losses.total.detach())) and math.isfinite(float(norm))):
        raise OmniVatError(
            f"Training stopped: the loss is {float(losses.total.detach()):g}. Lower lr or "
            "mma_weight, or look for extreme values in the embeddings."
        )
    if order.grad is not None:
        order.grad.clamp_(-settings.order_clip, settings.order_clip)
    optimiser.step()
    model.mffa.update_bank({n: t.detach() for n, t in output.tokens.items()}, batch.labels)
    return {
        "loss": float(losses.total.detach()),
        "mma": float(losses.mma.detach()),
        "nod": float(losses.nod.detach()),
        "cross_entropy": float(losses.cross_entropy.detach()),
    }
