"""LDC-ICD: a small network over the image corrects logits that confuse classes.

After Li et al., CVPR 2025, the logit part only. The published method also adapts inner tokens of
the image encoder, which pooled embeddings lack, so the feature here is the embedding. This network
is ours besides: logits and feature are concatenated where the published one adds two perceptrons,
the estimate is subtracted, each class has a gate of its own, layers have biases and no BatchNorm, and
gradients are clipped at 5. `ldc` has both parts as published, and needs images and the live tower.
"""

import torch
from torch import Tensor, nn
from torch.nn.functional import cross_entropy, l1_loss, normalize

from omnivat.baselines.contract import Fitted, Source, fused, seeded
from omnivat.baselines.descent import Descent, descend
from omnivat.baselines.evidence import best
from omnivat.baselines.nearest_mean import class_directions
from omnivat.seeding import derive_seed

HIDDEN = 512
CANDIDATES = {f"lr {lr:g}, scale {scale:g}": (lr, scale) for lr in (1e-4, 1e-3) for scale in (10.0, 30.0)}


class DeConfusion(nn.Module):
    """Base logits, an MLP's logits, base logits without estimated confusion, and a gated mix."""

    def __init__(self, width: int, classes: int) -> None:
        super().__init__()
        self.head = nn.Sequential(nn.Linear(width, HIDDEN), nn.ReLU(), nn.Linear(HIDDEN, classes))
        self.confusion = nn.Sequential(nn.Linear(width + classes, HIDDEN), nn.ReLU(), nn.Linear(HIDDEN, classes))
        self.gate = nn.Linear(width, classes)

    def forward(self, rows: Tensor, base: Tensor) -> tuple[Tensor, Tensor, Tensor]:
        """Return the MLP's, the corrected and the mixed logits (B, K)."""
        rows = rows.shape[1] ** 0.5 * normalize(rows, dim=-1)
        own = self.head(rows)
        clear = base - self.confusion(torch.cat((rows, base), dim=-1))
        gate = self.gate(rows).sigmoid()
        return own, clear, gate * own + (1 - gate) * clear


class Model(nn.Module):
    """De-confusion over base logits of each modality, with shared weights."""

    def __init__(self, source: Source, scale: float) -> None:
        super().__init__()
        self.scale = scale
        self.network = DeConfusion(source.width, len(source.classes))
        self.prototypes = _prototypes(source)

    def base(self, name: str, rows: Tensor) -> Tensor:
        return self.scale * normalize(rows, dim=-1) @ self.prototypes[name].T

    def probabilities(self, name: str, rows: Tensor) -> Tensor:
        """Return class probabilities (B, K) of the mixed logits."""
        mixed: Tensor = self.network(rows, self.base(name, rows))[2]
        return mixed.softmax(-1)

    def loss(self, name: str, rows: Tensor, labels: Tensor) -> Tensor:
        """Return three cross-entropies and two distances to the base logits, each of weight 1."""
        base = self.base(name, rows)
        own, clear, mixed = self.network(rows, base)
        right = [cross_entropy(logits, labels) for logits in (own, clear, mixed)]
        return torch.stack([*right, l1_loss(own, base), l1_loss(clear, base)]).sum()


def _prototypes(source: Source) -> dict[str, Tensor]:
    if source.lang is not None and source.lang_of_images:
        texts = normalize(normalize(source.lang, dim=-1).mean(1), dim=-1)
        return {"vis": texts, "tac": texts}
    full = source.both_views()
    return {
        name: class_directions(rows, full.labels, len(source.classes))
        for name, rows in (("vis", full.vis), ("tac", full.tac))
    }


def fit(source: Source) -> Fitted:
    """Train with AdamW; held-out objects choose learning rate and scale of the base logits."""
    chosen = best(
        source, CANDIDATES, lambda part, choice: lambda v, t: _predict(_train(part, *choice), v, t)["fused"], repeats=1
    )
    model = _train(source, *CANDIDATES[chosen])
    return Fitted(
        predict=lambda vis, tac: _predict(model, vis, tac),
        chosen={"training": chosen},
        parameters=sum(p.numel() for p in model.parameters()),
    )


@torch.inference_mode()
def _predict(model: Model, vis: Tensor, tac: Tensor) -> dict[str, Tensor]:
    return fused({"vis": model.probabilities("vis", vis), "tac": model.probabilities("tac", tac)})


def _train(source: Source, lr: float, scale: float) -> Model:
    with seeded(derive_seed(source.seed, "ldc-icd")):
        model = Model(source, scale)

        def loss(rows: Tensor) -> Tensor:
            vis, tac = source.drawn(rows)
            labels = source.labels[rows]
            return model.loss("vis", vis, labels) + model.loss("tac", tac, labels)

        how = Descent(lr=lr, epochs=30, batch=64, weight_decay=1e-4, method="adam")
        descend(model, len(source), how, loss)
    return model
