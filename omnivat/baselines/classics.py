"""Classic domain generalization over frozen embeddings, with the perceptron of ERM-MLP.

mixup       Zhang et al., ICLR 2018: mixes pairs and labels, λ ~ Beta(α, α)
mixstyle    Zhou et al., ICLR 2021, on vectors: mean and spread over the D axes replace those of a
            channel's feature map
fourier     Xu et al. (FACT), CVPR 2021, on vectors: mixes the amplitudes of two embeddings'
            spectra and keeps the phases
sam         Foret et al., ICLR 2021: minimises the worst loss within a radius
"""

from collections.abc import Callable
from functools import partial

import torch
from torch import Tensor
from torch.nn.functional import cross_entropy, one_hot

from omnivat.baselines.contract import Fitted, Source, seeded
from omnivat.baselines.descent import Descent, descend
from omnivat.baselines.erm_mlp import EPOCHS, INPUTS, Perceptron, of_perceptrons, predictor
from omnivat.baselines.evidence import best
from omnivat.seeding import derive_seed

Pair = tuple[Tensor, Tensor]
# (VIS, TAC, one-hot labels) of a batch -> the same, changed
Change = Callable[[Tensor, Tensor, Tensor], tuple[Tensor, Tensor, Tensor]]


def mixup(alpha: float, vis: Tensor, tac: Tensor, truth: Tensor) -> tuple[Tensor, Tensor, Tensor]:
    """Mix each pair and its label with another pair of the batch, with one λ."""
    share = float(torch.distributions.Beta(alpha, alpha).sample())
    other = torch.randperm(len(vis))
    mixed = [share * rows + (1 - share) * rows[other] for rows in (vis, tac, truth)]
    return mixed[0], mixed[1], mixed[2]


def mixstyle(alpha: float, vis: Tensor, tac: Tensor, truth: Tensor) -> tuple[Tensor, Tensor, Tensor]:
    """Set each embedding's mean and spread between its own and another's; keep the labels."""
    other = torch.randperm(len(vis))
    share = torch.distributions.Beta(alpha, alpha).sample((len(vis), 1))

    def restyled(rows: Tensor) -> Tensor:
        mean, spread = rows.mean(1, keepdim=True), rows.std(1, keepdim=True) + 1e-6
        plain = (rows - mean) / spread
        mean = share * mean + (1 - share) * mean[other]
        return plain * (share * spread + (1 - share) * spread[other]) + mean

    return restyled(vis), restyled(tac), truth


def fourier(strength: float, vis: Tensor, tac: Tensor, truth: Tensor) -> tuple[Tensor, Tensor, Tensor]:
    """Mix the amplitudes of each embedding's spectrum with another's; keep phases and labels."""
    other = torch.randperm(len(vis))
    share = strength * torch.rand(len(vis), 1)

    def respaced(rows: Tensor) -> Tensor:
        spectrum = torch.fft.rfft(rows)
        size = (1 - share) * spectrum.abs() + share * spectrum.abs()[other]
        mixed: Tensor = torch.fft.irfft(torch.polar(size, spectrum.angle()), n=rows.shape[1])
        return mixed

    return respaced(vis), respaced(tac), truth


def unchanged(_: float, vis: Tensor, tac: Tensor, truth: Tensor) -> tuple[Tensor, Tensor, Tensor]:
    """Return the batch unchanged."""
    return vis, tac, truth


def fit_mixup(source: Source) -> Fitted:
    """Train with mixup; held-out objects choose α."""
    return _fit(source, "mixup", mixup, (0.2, 1.0))


def fit_mixstyle(source: Source) -> Fitted:
    """Train with MixStyle on vectors; held-out objects choose α."""
    return _fit(source, "mixstyle", mixstyle, (0.1, 0.3))


def fit_fourier(source: Source) -> Fitted:
    """Train with mixed amplitudes; held-out objects choose the largest mixing."""
    return _fit(source, "fourier", fourier, (0.5, 1.0))


def fit_sam(source: Source) -> Fitted:
    """Train with sharpness-aware minimisation; held-out objects choose the radius."""
    return _fit(source, "sam", unchanged, (0.02, 0.05))


def _fit(
    source: Source, name: str, change: Callable[..., tuple[Tensor, Tensor, Tensor]], strengths: tuple[float, ...]
) -> Fitted:
    candidates = {f"{strength:g}": strength for strength in strengths}
    train = partial(_train, name=name, change=change)
    chosen = best(
        source,
        candidates,
        lambda part, strength: predictor(train(part, strength=strength, inputs=INPUTS["fused"])),
        repeats=1,
    )
    strength = candidates[chosen]
    models = {key: train(source, strength=strength, inputs=inputs) for key, inputs in INPUTS.items()}
    return of_perceptrons(models, {"strength": strength})


def _train(
    source: Source,
    *,
    name: str,
    change: Callable[..., tuple[Tensor, Tensor, Tensor]],
    strength: float,
    inputs: tuple[str, ...],
) -> Perceptron:
    with seeded(derive_seed(source.seed, name)):
        model = Perceptron(source.width, len(source.classes), inputs)

        def loss(rows: Tensor) -> Tensor:
            truth = one_hot(source.labels[rows], len(source.classes)).to(source.vis.dtype)
            vis, tac, mixed = change(strength, *source.drawn(rows), truth)
            return cross_entropy(model(vis, tac), mixed)

        radius = strength if name == "sam" else 0.0
        how = Descent(lr=1e-3, epochs=EPOCHS, weight_decay=1e-2, method="adam", sharpness=radius)
        descend(model, len(source), how, loss)
    return model.requires_grad_(False)
