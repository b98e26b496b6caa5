"""Contrastive projections of frozen embeddings to 128 numbers, then a linear probe.

VT CMC, head only: a contrastive loss over VIS and TAC of a contact. Photo only and touch only are
probes of one modality's projection. Source: Yang et al., NeurIPS 2022, which trains two ResNets.

SITR's objective: a surrogate, for touch alone. The published method (Gupta et al., ICLR 2025)
trains a transformer of its own on simulated sensors, with calibration presses that the data sets
here lack; only its supervised contrastive loss remains. Its prediction for a pair uses the touch
alone; "photo only" is the same head trained on photos, for comparison.
"""

import torch
from torch import Tensor, nn
from torch.nn.functional import cross_entropy, normalize

from omnivat.kit.stages import IMAGES
from omnivat.study.baselines.contract import Fitted, Predict, Rows, Source, joined, sized
from omnivat.study.baselines.descent import Descent, learned, size
from omnivat.study.baselines.logistic import fit_logistic

WIDTH, TEMPERATURE = 128, 0.07  # as published, in both
HOW = Descent(lr=0.03, epochs=40, batch=128)


def contrastive_loss(seen: Tensor, touched: Tensor) -> Tensor:
    """Return the symmetric InfoNCE of B pairs of unit vectors; row i matches row i."""
    scores = seen @ touched.T / TEMPERATURE
    own = torch.arange(len(scores))
    return (cross_entropy(scores, own) + cross_entropy(scores.T, own)) / 2


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


def _unit(projection: nn.Module, rows: Tensor) -> Tensor:
    return normalize(projection(sized(rows)), dim=-1)


def _probed(**probes: Fitted) -> Predict:
    """Return the predictions of a probe for each reading."""
    return lambda vis, tac: {n: probe.predict(vis, tac)["fused"] for n, probe in probes.items()}


def fit_vt_cmc(source: Source) -> Fitted:
    """Train the projections without labels, then a probe; held-out objects choose its C."""

    def loss(maps: nn.ModuleDict, rows: Tensor) -> Tensor:
        return contrastive_loss(*map(_unit, maps.values(), source.drawn(rows)))

    maps = learned(
        source,
        lambda: nn.ModuleDict({n: nn.Linear(source.width, WIDTH) for n in IMAGES}),
        HOW,
        loss,
        "vt-cmc",
    )

    def features(vis: Tensor, tac: Tensor) -> Rows:
        seen, touched = _unit(maps["vis"], vis), _unit(maps["tac"], tac)
        return {"vis": seen, "tac": touched, "pair": torch.cat((seen, touched), dim=-1)}

    def probe(name: str) -> Fitted:
        return fit_logistic(source, lambda vis, tac: features(vis, tac)[name])

    seen, touched, both = map(probe, (*IMAGES, "pair"))
    return Fitted(
        predict=_probed(fused=both, vis=seen, tac=touched),
        features=features,
        chosen={**both.chosen, "scaling": "unit"},
        parameters=size(maps) + both.parameters,
    )


def fit_sitr(source: Source) -> Fitted:
    """Train the projections with SupCon, then a probe; held-out objects choose its C."""

    def projection(which: int) -> nn.Module:
        def loss(head: nn.Module, rows: Tensor) -> Tensor:
            return supcon_loss(_unit(head, source.drawn(rows)[which]), source.labels[rows])

        return learned(
            source, lambda: nn.Linear(source.width, WIDTH), HOW, loss, "sitr", IMAGES[which]
        )

    seen, touched = projection(0), projection(1)
    of_vis = fit_logistic(source, lambda vis, tac: _unit(seen, vis))
    of_tac = fit_logistic(source, lambda vis, tac: _unit(touched, tac))

    return Fitted(
        predict=_probed(fused=of_tac, vis=of_vis, tac=of_tac),
        features=lambda vis, tac: joined(_unit(seen, vis), _unit(touched, tac)),
        chosen={"C of TAC": of_tac.chosen["C"]},
        parameters=size(touched) + of_tac.parameters,
    )
