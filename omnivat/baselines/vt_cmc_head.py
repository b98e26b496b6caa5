"""VT CMC, head only: a contrastive loss over VIS and TAC of a contact, then a linear probe.

Photo only and touch only are probes of one modality's projection.

Source: Yang et al., NeurIPS 2022. It trains two ResNets; here the embeddings are frozen and only
the projections to 128 numbers are trained.
"""

import torch
from torch import Tensor, nn
from torch.nn.functional import cross_entropy, normalize

from omnivat.baselines.contract import Fitted, Source, seeded
from omnivat.baselines.descent import Descent, descend
from omnivat.baselines.logistic import View, fit_logistic
from omnivat.seeding import derive_seed

WIDTH, TEMPERATURE = 128, 0.07  # as published
HOW = Descent(lr=0.03, epochs=40, batch=128)


class Projections(nn.Module):
    """A linear map of each modality to unit vectors of 128 numbers."""

    def __init__(self, width: int) -> None:
        super().__init__()
        self.vis = nn.Linear(width, WIDTH)
        self.tac = nn.Linear(width, WIDTH)

    def forward(self, vis: Tensor, tac: Tensor) -> tuple[Tensor, Tensor]:
        """Return VIS and TAC (B, 128)."""
        scale = vis.shape[1] ** 0.5
        seen = normalize(self.vis(scale * normalize(vis, dim=-1)), dim=-1)
        touched = normalize(self.tac(scale * normalize(tac, dim=-1)), dim=-1)
        return seen, touched


def contrastive_loss(seen: Tensor, touched: Tensor) -> Tensor:
    """Return the symmetric InfoNCE of B pairs of unit vectors; row i matches row i."""
    scores = seen @ touched.T / TEMPERATURE
    own = torch.arange(len(scores))
    return (cross_entropy(scores, own) + cross_entropy(scores.T, own)) / 2


def fit(source: Source) -> Fitted:
    """Train the projections without labels, then a probe; held-out objects choose its C."""
    with seeded(derive_seed(source.seed, "vt-cmc")):
        model = Projections(source.width)
        descend(model, len(source), HOW, lambda rows: contrastive_loss(*model(*source.drawn(rows))))
    model.requires_grad_(False)
    probes = {name: fit_logistic(source, view(model, name)) for name in ("fused", "vis", "tac")}

    def predict(vis: Tensor, tac: Tensor) -> dict[str, Tensor]:
        rows = features(model, vis, tac)
        return {
            "fused": probes["fused"].probabilities(rows["pair"]),
            "vis": probes["vis"].probabilities(rows["vis"]),
            "tac": probes["tac"].probabilities(rows["tac"]),
        }

    return Fitted(
        predict=predict,
        features=lambda vis, tac: features(model, vis, tac),
        chosen={"C": probes["fused"].strength, "scaling": probes["fused"].kind},
        parameters=sum(p.numel() for p in model.parameters()) + probes["fused"].parameters,
    )


def features(model: Projections, vis: Tensor, tac: Tensor) -> dict[str, Tensor]:
    """Return the projections (B, 128) by modality, and concatenated as "pair"."""
    seen, touched = model(vis, tac)
    return {"vis": seen, "tac": touched, "pair": torch.cat((seen, touched), dim=-1)}


def view(model: Projections, name: str) -> View:
    """Return the inputs of a probe: the projections of one modality, or of both."""
    which = "pair" if name == "fused" else name
    return lambda pairs: features(model, pairs.vis, pairs.tac)[which]
