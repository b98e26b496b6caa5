"""ERM-MLP: a two-layer perceptron on VIS and TAC side by side, trained on the source alone."""

from functools import partial

import torch
from torch import Tensor, nn
from torch.nn.functional import cross_entropy, normalize

from omnivat.baselines.contract import Fitted, Source, seeded
from omnivat.baselines.descent import Descent, descend
from omnivat.baselines.evidence import best
from omnivat.seeding import derive_seed

HIDDEN = 256
CANDIDATES = {
    f"lr {lr:g}, decay {decay:g}": (lr, decay) for lr in (3e-4, 1e-3) for decay in (1e-2, 1.0)
}


def fit(source: Source) -> Fitted:
    """Train with AdamW; learning rate and weight decay by held-out objects."""
    chosen = best(
        source,
        CANDIDATES,
        lambda part, choice: partial(_answer, _train(part, *choice)),
        repeats=2,
    )
    model = _train(source, *CANDIDATES[chosen])
    return Fitted(
        predict=lambda vis, tac: {"fused": _answer(model, vis, tac)},
        chosen={"training": chosen},
        parameters=sum(p.numel() for p in model.parameters()),
    )


def _model(source: Source) -> nn.Module:
    return nn.Sequential(
        nn.Linear(2 * source.width, HIDDEN),
        nn.GELU(),
        nn.Dropout(0.5),
        nn.Linear(HIDDEN, len(source.classes)),
    )


def _rows(vis: Tensor, tac: Tensor) -> Tensor:
    scale: float = vis.shape[1] ** 0.5
    return scale * torch.cat((normalize(vis, dim=-1), normalize(tac, dim=-1)), dim=-1)


@torch.inference_mode()
def _answer(model: nn.Module, vis: Tensor, tac: Tensor) -> Tensor:
    probabilities: Tensor = model(_rows(vis, tac)).softmax(-1)
    return probabilities


def _train(source: Source, lr: float, decay: float) -> nn.Module:
    with seeded(derive_seed(source.seed, "erm-mlp")):
        model = _model(source)
        descend(
            model,
            len(source),
            Descent(lr=lr, weight_decay=decay, method="adam"),
            lambda rows: cross_entropy(model(_rows(*source.drawn(rows))), source.labels[rows]),
        )
    return model
