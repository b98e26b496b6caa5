"""ERM-MLP: a two-layer perceptron on concatenated VIS and TAC, trained on the source.

Photo only and touch only are perceptrons of one modality, trained the same way.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial

import torch
from torch import Tensor, nn
from torch.nn.functional import cross_entropy, normalize

from omnivat.study.baselines.contract import Fitted, Source, joined
from omnivat.study.baselines.descent import Descent, learned, size
from omnivat.study.baselines.evidence import best

HIDDEN, EPOCHS = 256, 20
Inputs = Mapping[str, tuple[str, ...]]  # reading -> modalities that its perceptron gets
Loss = Callable[[nn.Module, Tensor], Tensor]
FUSED: Inputs = {"fused": ("vis", "tac")}  # enough to choose settings
INPUTS: Inputs = {**FUSED, "vis": ("vis",), "tac": ("tac",)}
CANDIDATES = {
    f"lr {lr:g}, decay {decay:g}": (lr, decay) for lr in (3e-4, 1e-3) for decay in (1e-2, 1.0)
}


class Perceptron(nn.Module):
    """A hidden layer and a linear head over some of the modalities."""

    def __init__(self, width: int, classes: int, inputs: tuple[str, ...]) -> None:
        super().__init__()
        self.inputs = inputs
        self.hidden = nn.Sequential(nn.Linear(len(inputs) * width, HIDDEN), nn.GELU())
        self.head = nn.Sequential(nn.Dropout(0.5), nn.Linear(HIDDEN, classes))

    def features(self, vis: Tensor, tac: Tensor) -> Tensor:
        """Return the hidden layer (B, 256)."""
        given = {"vis": vis, "tac": tac}
        rows = torch.cat([normalize(given[name], dim=-1) for name in self.inputs], dim=-1)
        hidden: Tensor = self.hidden(vis.shape[1] ** 0.5 * rows)
        return hidden

    def forward(self, vis: Tensor, tac: Tensor) -> Tensor:
        """Return logits (B, K)."""
        logits: Tensor = self.head(self.features(vis, tac))
        return logits


def fit(source: Source) -> Fitted:
    """Train with AdamW; held-out objects choose learning rate and weight decay."""
    chosen = best(source, CANDIDATES, lambda part, choice: _fitted(part, choice, FUSED), repeats=1)
    return replace(_fitted(source, CANDIDATES[chosen], INPUTS), chosen={"training": chosen})


def _fitted(source: Source, choice: tuple[float, float], inputs: Inputs) -> Fitted:
    how = Descent(
        lr=choice[0], epochs=source.epochs or EPOCHS, weight_decay=choice[1], method="adam"
    )

    def loss(model: nn.Module, rows: Tensor) -> Tensor:
        return cross_entropy(model(*source.drawn(rows)), source.labels[rows])

    return perceptrons(source, inputs, how, loss, "erm-mlp")


def perceptrons(source: Source, inputs: Inputs, how: Descent, loss: Loss, stream: str) -> Fitted:
    """Train one perceptron for each reading in `inputs`; features need all of `INPUTS`."""
    classes = len(source.classes)
    models = {
        name: learned(source, partial(Perceptron, source.width, classes, own), how, loss, stream)
        for name, own in inputs.items()
    }

    def features(vis: Tensor, tac: Tensor) -> dict[str, Tensor]:
        own = {name: model.features(vis, tac) for name, model in models.items()}
        return {**joined(own["vis"], own["tac"]), "pair": own["fused"]}

    return Fitted(
        predict=lambda vis, tac: {
            name: model(vis, tac).softmax(-1) for name, model in models.items()
        },
        features=features,
        parameters=size(models["fused"]),
    )
