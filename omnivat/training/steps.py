"""The optimiser, its learning rate, and one step."""

import math
from collections.abc import Sequence
from typing import Any

import torch
from torch import Tensor
from torch.optim.sgd import sgd

from omnivat.head.head import OmniVaT
from omnivat.head.losses import joint_loss
from omnivat.head.training import training_pass
from omnivat.kit.errors import OmniVatError
from omnivat.kit.stages import IMAGES
from omnivat.training.batches import Batch
from omnivat.training.settings import TrainSettings


class Momentum:
    """SGD with momentum, by torch's function.

    `torch.optim.SGD` imports torch's compiler when it is made: 1.5 s of CPU, in which a page that
    trains replies to nobody.
    """

    def __init__(self, groups: list[dict[str, Any]], momentum: float) -> None:
        self.param_groups, self.momentum = groups, momentum
        self.state: dict[Tensor, Tensor] = {}  # parameter -> its momentum

    @torch.no_grad()
    def step(self) -> None:
        """Move every parameter that has a gradient."""
        for group in self.param_groups:
            moved = [parameter for parameter in group["params"] if parameter.grad is not None]
            momenta = [self.state.get(parameter) for parameter in moved]
            sgd(
                moved,
                [parameter.grad for parameter in moved],
                momenta,
                fused=True,
                weight_decay=group["weight_decay"],
                momentum=self.momentum,
                lr=group["lr"],
                dampening=0.0,
                nesterov=False,
                maximize=False,
            )
            kept = zip(moved, momenta, strict=True)
            self.state |= {
                parameter: momentum for parameter, momentum in kept if momentum is not None
            }


def make_optimiser(model: OmniVaT, settings: TrainSettings) -> Momentum:
    """Return SGD in three groups: p (slow, clamped), θ_e (no decay) and everything else."""
    order, theta = [model.mffa.order], list(model.mffa.theta.values())
    apart = {id(parameter) for parameter in (*order, *theta)}
    rest = [p for p in model.parameters() if id(p) not in apart]
    groups: list[dict[str, Any]] = [
        {"params": rest, "weight_decay": settings.weight_decay, "scale": 1.0},
        {"params": theta, "weight_decay": 0.0, "scale": 1.0},
        {"params": order, "weight_decay": 0.0, "scale": settings.order_lr_scale},
    ]
    return Momentum([group | {"lr": settings.lr} for group in groups], settings.momentum)


def parameters_of(optimiser: Momentum) -> list[Tensor]:
    """Return all parameters, group by group."""
    return [parameter for group in optimiser.param_groups for parameter in group["params"]]


def set_rate(optimiser: Momentum, settings: TrainSettings, epoch: float, step: float) -> None:
    """Set the rate: linear warm-up by step, then cosine to zero. epoch and step count in epochs."""
    warm = min(settings.warmup_epochs, settings.epochs)
    if epoch < warm:
        share = (epoch + step) / warm
    else:
        share = 0.5 * (1 + math.cos(math.pi * (epoch - warm) / max(settings.epochs - warm, step)))
    for group in optimiser.param_groups:
        group["lr"] = settings.lr * group["scale"] * share


def pairs_of(kind: str, batch: Batch) -> Tensor | None:
    """Return a mask (B,) of the pairs of a kind: "guided" by LANG, "unguided"; None for all.

    Without LANG, all pairs are unguided. If a batch has no pair of the kind, all of its pairs
    count; otherwise a training that guides every pair would never fill its bank.
    """
    if kind == "all" or batch.lang is None:
        return None
    mask = batch.lang_on if kind == "guided" else ~batch.lang_on
    return mask if bool(mask.any()) else None


@torch.no_grad()
def taught_logits(teachers: Sequence[OmniVaT], batch: Batch) -> dict[str, Tensor]:
    """Return the teachers' mean logits (B, K) of VIS and TAC, each at its own order, without
    LANG.
    """
    images = {name: batch.images.get(name) for name in IMAGES}
    found = [teacher(**images).logits for teacher in teachers]
    return {name: torch.stack([part[name] for part in found]).mean(0) for name in found[0]}


def learn(
    model: OmniVaT,
    optimiser: Momentum,
    batch: Batch,
    settings: TrainSettings,
    teachers: Sequence[OmniVaT] = (),
) -> dict[str, float]:
    """Take one optimiser step; return the losses as numbers.

    teachers  heads whose mean logits for the batch are the targets, in place of the labels

    "clipped" and "order_clipped" are 1 if a gradient was clipped.
    Raises OmniVatError if the loss or a gradient is not finite.
    """
    output = training_pass(
        model,
        batch.images,
        batch.lang,
        batch.labels,
        lang_on=batch.lang_on,
        token_on=batch.token_on,
        order=batch.order,
    )
    losses = joint_loss(
        output,
        batch.labels,
        aligned=pairs_of(settings.mma_on, batch),
        mma_weight=settings.mma_weight,
        nod_weight=settings.nod_weight,
        targets=taught_logits(teachers, batch) if teachers else None,
    )
    parameters = parameters_of(optimiser)
    for parameter in parameters:
        parameter.grad = None
    losses.total.backward()
    order = model.mffa.order
    rest = [p.grad for p in parameters if p is not order and p.grad is not None]
    norms = torch.stack(torch._foreach_norm(rest))
    norm = float(torch.linalg.vector_norm(norms))
    values = torch.stack(losses).tolist()
    if not (math.isfinite(values[0]) and math.isfinite(norm)):
        raise OmniVatError(
            f"Training stopped: the loss is {values[0]:g}. Lower lr or "
            "mma_weight, or look for extreme values in the embeddings."
        )
    clipped = norm > settings.clip
    if clipped:
        torch._foreach_mul_(rest, settings.clip / norm)
    held = False
    if order.grad is not None:
        held = bool((order.grad.abs() > settings.order_clip).any())
        order.grad.clamp_(-settings.order_clip, settings.order_clip)
    optimiser.step()
    if output.tokens:
        some = pairs_of(settings.bank_from, batch)
        rows = slice(None) if some is None else some
        tokens = {name: values.detach()[rows] for name, values in output.tokens.items()}
        model.mffa.update_bank(tokens, batch.labels[rows])
    record = dict(zip(("loss", "mma", "nod", "cross_entropy"), values, strict=True))
    return record | {"clipped": float(clipped), "order_clipped": float(held)}
