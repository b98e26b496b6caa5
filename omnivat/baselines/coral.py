"""CORAL between modalities: it aligns the covariances of VIS and TAC features.

Sun and Saenko, Deep CORAL, ECCV 2016 workshops, aligns two domains. Here a method has one domain
only, so its two modalities are aligned instead.
"""

import torch
from torch import Tensor, nn
from torch.nn.functional import cross_entropy, normalize

from omnivat.baselines.contract import Fitted, Source, fused, joined, seeded
from omnivat.baselines.descent import Descent, descend
from omnivat.baselines.evidence import best
from omnivat.seeding import derive_seed

HIDDEN = 256
CANDIDATES = {f"{weight:g}": weight for weight in (0.1, 1.0, 10.0)}


class Towers(nn.Module):
    """A hidden layer for each modality and one linear head."""

    def __init__(self, width: int, classes: int) -> None:
        super().__init__()
        self.vis = nn.Sequential(nn.Linear(width, HIDDEN), nn.GELU())
        self.tac = nn.Sequential(nn.Linear(width, HIDDEN), nn.GELU())
        self.head = nn.Sequential(nn.Dropout(0.5), nn.Linear(HIDDEN, classes))

    def features(self, vis: Tensor, tac: Tensor) -> dict[str, Tensor]:
        """Return the hidden layers (B, 256)."""
        scale = vis.shape[1] ** 0.5
        return {"vis": self.vis(scale * normalize(vis, dim=-1)), "tac": self.tac(scale * normalize(tac, dim=-1))}

    def forward(self, vis: Tensor, tac: Tensor) -> dict[str, Tensor]:
        """Return logits (B, K) of each modality."""
        return {name: self.head(rows) for name, rows in self.features(vis, tac).items()}


def coral_loss(first: Tensor, second: Tensor) -> Tensor:
    """Return the squared distance of the covariances of rows (B, W) and (B, W), over 4 W²."""
    gap = torch.cov(first.T) - torch.cov(second.T)
    return gap.square().sum() / (4 * first.shape[1] ** 2)


def fit(source: Source) -> Fitted:
    """Train with AdamW; held-out objects choose the weight of the alignment."""
    chosen = best(
        source, CANDIDATES, lambda part, weight: lambda v, t: _predict(_train(part, weight), v, t)["fused"], repeats=1
    )
    model = _train(source, CANDIDATES[chosen])
    return Fitted(
        predict=lambda vis, tac: _predict(model, vis, tac),
        features=lambda vis, tac: joined(*model.features(vis, tac).values()),
        chosen={"weight": CANDIDATES[chosen]},
        parameters=sum(p.numel() for p in model.parameters()),
    )


def _predict(model: Towers, vis: Tensor, tac: Tensor) -> dict[str, Tensor]:
    return fused({name: logits.softmax(-1) for name, logits in model(vis, tac).items()})


def _train(source: Source, weight: float) -> Towers:
    with seeded(derive_seed(source.seed, "coral")):
        model = Towers(source.width, len(source.classes))

        def loss(rows: Tensor) -> Tensor:
            vis, tac = source.drawn(rows)
            labels, hidden = source.labels[rows], model.features(vis, tac)
            right = sum(cross_entropy(model.head(values), labels) for values in hidden.values())
            if len(rows) < 2:  # one pair has no covariance
                return torch.as_tensor(right)
            return right + weight * coral_loss(hidden["vis"], hidden["tac"])

        how = Descent(lr=1e-3, epochs=20, batch=32, weight_decay=1e-2, method="adam")
        descend(model, len(source), how, loss)
    return model.requires_grad_(False)
