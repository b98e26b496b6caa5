"""ERM-MLP: a two-layer perceptron on concatenated VIS and TAC, trained on the source.

Photo only and touch only are perceptrons of one modality, trained the same way.
"""

from collections.abc import Mapping
from dataclasses import replace
from functools import partial

import torch
from torch import Tensor, nn
from torch.nn.functional import cross_entropy

from omnivat.study.baselines.contract import Fitted, Rows, Source, joined, sized
from omnivat.study.baselines.descent import Descent, learned, size
from omnivat.study.baselines.evidence import best

HIDDEN, EPOCHS = 256, 20
Inputs = Mapping[str, tuple[str, ...]]  # reading -> modalities that its perceptron gets
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
        images = {"vis": vis, "tac": tac}
        rows = torch.cat([sized(images[name]) for name in self.inputs], dim=-1)
        hidden: Tensor = self.hidden(rows)
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
    """Train one perceptron for each reading in `inputs`; features need all of `INPUTS`."""
    lr, decay = choice
    how = Descent(lr=lr, epochs=source.epochs or EPOCHS, weight_decay=decay, method="adam")
    classes = len(source.classes)

    def loss(model: nn.Module, rows: Tensor) -> Tensor:
        return cross_entropy(model(*source.drawn(rows)), source.labels[rows])

    models = {
        name: learned(source, partial(Perceptron, source.width, classes, own), how, loss, "erm-mlp")
        for name, own in inputs.items()
    }

    def predict(vis: Tensor, tac: Tensor) -> Rows:
        return {name: model(vis, tac).softmax(-1) for name, model in models.items()}

    def features(vis: Tensor, tac: Tensor) -> Rows:
        own = {name: model.features(vis, tac) for name, model in models.items()}
        return {**joined(own["vis"], own["tac"]), "pair": own["fused"]}

    return Fitted(predict=predict, features=features, parameters=size(models["fused"]))
