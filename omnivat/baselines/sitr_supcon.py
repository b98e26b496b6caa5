"""SITR's objective as a head over TAC embeddings: a surrogate, for touch alone.

The published method (Gupta et al., ICLR 2025) trains a transformer of its own on simulated sensors,
with calibration presses that the data sets here lack. Over frozen embeddings, only its supervised
contrastive loss (τ = 0.07) and a linear probe remain. Its prediction for a pair uses the touch
alone; "photo only" is the same head trained on photos, for comparison.
"""

import torch
from torch import Tensor, nn
from torch.nn.functional import normalize

from omnivat.baselines.contract import Fitted, Source, joined, seeded
from omnivat.baselines.descent import Descent, descend
from omnivat.baselines.logistic import Logistic, fit_logistic
from omnivat.seeding import derive_seed

WIDTH, TEMPERATURE = 128, 0.07
HOW = Descent(lr=0.03, epochs=40, batch=128)


def supcon_loss(rows: Tensor, labels: Tensor) -> Tensor:
    """Return the supervised contrastive loss of unit rows (B, W); it pulls equal labels together.

    Rows without a partner in the batch do not count; 0 if none has one.
    Source: Khosla et al., NeurIPS 2020, L_out.
    """
    others = ~torch.eye(len(rows), dtype=torch.bool, device=rows.device)
    partners = (labels[:, None] == labels) & others
    scores = (rows @ rows.T / TEMPERATURE).masked_fill(~others, -torch.inf)
    logs = (scores - scores.logsumexp(1, keepdim=True)).masked_fill(~partners, 0.0)
    counts = partners.sum(1)
    return -(logs.sum(1) / counts.clamp_min(1))[counts > 0].sum() / (counts > 0).sum().clamp_min(1)


def fit(source: Source) -> Fitted:
    """Train the projections with SupCon, then a probe; held-out objects choose its C."""
    maps = {name: _projection(source, name) for name in ("vis", "tac")}
    probes: dict[str, Logistic] = {
        "vis": fit_logistic(source, lambda pairs: _rows(maps["vis"], pairs.vis)),
        "tac": fit_logistic(source, lambda pairs: _rows(maps["tac"], pairs.tac)),
    }

    def predict(vis: Tensor, tac: Tensor) -> dict[str, Tensor]:
        touched = probes["tac"].probabilities(_rows(maps["tac"], tac))
        seen = probes["vis"].probabilities(_rows(maps["vis"], vis))
        return {"fused": touched, "vis": seen, "tac": touched}

    return Fitted(
        predict=predict,
        features=lambda vis, tac: joined(_rows(maps["vis"], vis), _rows(maps["tac"], tac)),
        chosen={"C of TAC": probes["tac"].strength},
        parameters=sum(p.numel() for p in maps["tac"].parameters()) + probes["tac"].parameters,
    )


def _rows(projection: nn.Module, rows: Tensor) -> Tensor:
    return normalize(projection(rows.shape[1] ** 0.5 * normalize(rows, dim=-1)), dim=-1)


def _projection(source: Source, name: str) -> nn.Module:
    with seeded(derive_seed(source.seed, "sitr", name)):
        projection = nn.Linear(source.width, WIDTH)
        which = ("vis", "tac").index(name)

        def loss(rows: Tensor) -> Tensor:
            return supcon_loss(_rows(projection, source.drawn(rows)[which]), source.labels[rows])

        descend(projection, len(source), HOW, loss)
    return projection.requires_grad_(False)
