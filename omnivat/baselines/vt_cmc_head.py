"""VT CMC, its head alone: VIS and TAC of a contact are drawn together, then probed linearly.

Source: Yang et al., NeurIPS 2022. There two ResNets are trained so; here the embeddings stay as
they are and only the projections to 128 numbers learn.
"""

import torch
from torch import Tensor, nn
from torch.nn.functional import cross_entropy, normalize

from omnivat.baselines.contract import Fitted, Source, seeded
from omnivat.baselines.descent import Descent, descend
from omnivat.baselines.logistic import fit_logistic
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
    """Return the symmetric InfoNCE of B pairs of unit vectors: row i belongs to row i."""
    scores = seen @ touched.T / TEMPERATURE
    own = torch.arange(len(scores))
    return (cross_entropy(scores, own) + cross_entropy(scores.T, own)) / 2


def fit(source: Source) -> Fitted:
    """Learn the projections without labels, then a probe whose C held-out objects choose."""
    with seeded(derive_seed(source.seed, "vt-cmc")):
        model = Projections(source.width)
        descend(model, len(source), HOW, lambda rows: contrastive_loss(*model(*source.drawn(rows))))
    model.requires_grad_(False)
    probe = fit_logistic(source, lambda pairs: torch.cat(model(pairs.vis, pairs.tac), dim=-1))

    def predict(vis: Tensor, tac: Tensor) -> dict[str, Tensor]:
        return {"fused": probe.probabilities(torch.cat(model(vis, tac), dim=-1))}

    return Fitted(
        predict=predict,
        chosen={"C": probe.strength, "scaling": probe.kind},
        parameters=sum(p.numel() for p in model.parameters()) + probe.parameters,
    )
