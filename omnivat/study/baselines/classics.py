"""Classic domain generalization over frozen embeddings, with the perceptron of ERM-MLP or its like.

mixup       Zhang et al., ICLR 2018: mixes pairs and labels, λ ~ Beta(α, α)
mixstyle    Zhou et al., ICLR 2021, on vectors: mean and spread over the D axes replace those of a
            channel's feature map
fourier     Xu et al. (FACT), CVPR 2021, on vectors: mixes the amplitudes of two embeddings'
            spectra and keeps the phases
sam         Foret et al., ICLR 2021: minimises the worst loss within a radius
coral       Sun and Saenko, Deep CORAL, ECCV 2016 workshops: aligns the covariances of two domains. Here a
            method has one domain only, so its two modalities are aligned instead
"""

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import torch
from torch import Tensor, nn
from torch.nn.functional import cross_entropy, one_hot

from omnivat.kit.stages import IMAGES
from omnivat.study.baselines.contract import Fitted, Source, joined, late, sized
from omnivat.study.baselines.descent import Descent, learned, size
from omnivat.study.baselines.erm_mlp import EPOCHS, FUSED, HIDDEN, INPUTS, Inputs, perceptrons
from omnivat.study.baselines.evidence import best

WEIGHTS = {f"{weight:g}": weight for weight in (0.1, 1.0, 10.0)}  # of CORAL's alignment
ALIGNING = Descent(lr=1e-3, epochs=20, batch=32, weight_decay=1e-2, method="adam")
Batch = tuple[Tensor, Tensor, Tensor]  # VIS, TAC and one-hot labels


def mixup(alpha: float, vis: Tensor, tac: Tensor, truth: Tensor) -> Batch:
    """Mix each pair and its label with another pair of the batch, with one λ."""
    share = float(torch.distributions.Beta(alpha, alpha).sample())
    other = torch.randperm(len(vis))
    mixed = [share * rows + (1 - share) * rows[other] for rows in (vis, tac, truth)]
    return mixed[0], mixed[1], mixed[2]


def mixstyle(alpha: float, vis: Tensor, tac: Tensor, truth: Tensor) -> Batch:
    """Set each embedding's mean and spread between its own and another's; keep the labels."""
    other = torch.randperm(len(vis))
    share = torch.distributions.Beta(alpha, alpha).sample((len(vis), 1))

    def restyled(rows: Tensor) -> Tensor:
        mean, spread = rows.mean(1, keepdim=True), rows.std(1, keepdim=True) + 1e-6
        plain = (rows - mean) / spread
        mean = share * mean + (1 - share) * mean[other]
        return plain * (share * spread + (1 - share) * spread[other]) + mean

    return restyled(vis), restyled(tac), truth


def fourier(strength: float, vis: Tensor, tac: Tensor, truth: Tensor) -> Batch:
    """Mix the amplitudes of each embedding's spectrum with another's; keep phases and labels."""
    other = torch.randperm(len(vis))
    share = strength * torch.rand(len(vis), 1)

    def respaced(rows: Tensor) -> Tensor:
        spectrum = torch.fft.rfft(rows)
        size = (1 - share) * spectrum.abs() + share * spectrum.abs()[other]
        mixed: Tensor = torch.fft.irfft(torch.polar(size, spectrum.angle()), n=rows.shape[1])
        return mixed

    return respaced(vis), respaced(tac), truth


def _fit(source: Source, *, name: str, change: Callable[..., Batch], strengths: tuple[float, ...]) -> Fitted:
    """Train with `change` on every batch; held-out objects choose its strength: α, the largest mixing or the radius."""

    def fitted(part: Source, strength: float, inputs: Inputs = FUSED) -> Fitted:
        def loss(model: nn.Module, rows: Tensor) -> Tensor:
            truth = one_hot(part.labels[rows], len(part.classes)).to(part.vis.dtype)
            vis, tac, mixed = change(strength, *part.drawn(rows), truth)
            return cross_entropy(model(vis, tac), mixed)

        radius = strength if name == "sam" else 0.0
        how = Descent(lr=1e-3, epochs=EPOCHS, weight_decay=1e-2, method="adam", sharpness=radius)
        return perceptrons(part, inputs, how, loss, name)

    candidates = {f"{strength:g}": strength for strength in strengths}
    strength = candidates[best(source, candidates, fitted, repeats=1)]
    return replace(fitted(source, strength, INPUTS), chosen={"strength": strength})


fit_mixup = partial(_fit, name="mixup", change=mixup, strengths=(0.2, 1.0))
fit_mixstyle = partial(_fit, name="mixstyle", change=mixstyle, strengths=(0.1, 0.3))
fit_fourier = partial(_fit, name="fourier", change=fourier, strengths=(0.5, 1.0))
fit_sam = partial(_fit, name="sam", change=lambda radius, *batch: batch, strengths=(0.02, 0.05))


class Towers(nn.Module):
    """A hidden layer for each modality and one linear head."""

    def __init__(self, width: int, classes: int) -> None:
        super().__init__()
        self.towers = nn.ModuleDict({n: nn.Sequential(nn.Linear(width, HIDDEN), nn.GELU()) for n in IMAGES})
        self.head = nn.Sequential(nn.Dropout(0.5), nn.Linear(HIDDEN, classes))

    def features(self, name: str, rows: Tensor) -> Tensor:
        """Return the hidden layer (B, 256) of a modality."""
        hidden: Tensor = self.towers[name](sized(rows))
        return hidden


def coral_loss(first: Tensor, second: Tensor) -> Tensor:
    """Return the squared distance of the covariances of rows (B, W) and (B, W), over 4 W²."""
    gap = torch.cov(first.T) - torch.cov(second.T)
    return gap.square().sum() / (4 * first.shape[1] ** 2)


def fit_coral(source: Source) -> Fitted:
    """Train with AdamW; held-out objects choose the weight of the alignment."""
    chosen = best(source, WEIGHTS, fitted_coral, repeats=1)
    return fitted_coral(source, WEIGHTS[chosen])


def fitted_coral(source: Source, weight: float) -> Fitted:
    """Train with one weight of the alignment."""

    def loss(model: Towers, rows: Tensor) -> Tensor:
        labels = source.labels[rows]
        vis, tac = map(model.features, IMAGES, source.drawn(rows))
        right = cross_entropy(model.head(vis), labels) + cross_entropy(model.head(tac), labels)
        return right + weight * coral_loss(vis, tac) if len(rows) > 1 else right  # one pair has no covariance

    model = learned(source, lambda: Towers(source.width, len(source.classes)), ALIGNING, loss, "coral")
    return Fitted(
        predict=late(lambda name, rows: model.head(model.features(name, rows)).softmax(-1)),
        features=lambda vis, tac: joined(model.features("vis", vis), model.features("tac", tac)),
        chosen={"weight": weight},
        parameters=size(model),
    )
