"""ERM-MLP: a two-layer perceptron on concatenated VIS and TAC, trained on the source.

Photo only and touch only are perceptrons of one modality, trained the same way.
"""

from collections.abc import Callable

import torch
from torch import Tensor, nn
from torch.nn.functional import cross_entropy, normalize

from omnivat.baselines.contract import Fitted, Source, joined, seeded
from omnivat.baselines.descent import Descent, descend
from omnivat.baselines.evidence import best
from omnivat.seeding import derive_seed

HIDDEN, EPOCHS = 256, 20
INPUTS = {"fused": ("vis", "tac"), "vis": ("vis",), "tac": ("tac",)}
CANDIDATES = {f"lr {lr:g}, decay {decay:g}": (lr, decay) for lr in (3e-4, 1e-3) for decay in (1e-2, 1.0)}
Predictor = Callable[[Tensor, Tensor], Tensor]


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
    chosen = best(source, CANDIDATES, lambda part, choice: predictor(_train(part, *choice, INPUTS["fused"])), repeats=1)
    models = {name: _train(source, *CANDIDATES[chosen], inputs) for name, inputs in INPUTS.items()}
    return of_perceptrons(models, {"training": chosen})


def of_perceptrons(models: dict[str, Perceptron], chosen: dict[str, float | str]) -> Fitted:
    """Return the method that predicts with one perceptron for each of `INPUTS`."""

    @torch.inference_mode()
    def features(vis: Tensor, tac: Tensor) -> dict[str, Tensor]:
        own = {name: model.features(vis, tac) for name, model in models.items()}
        return {**joined(own["vis"], own["tac"]), "pair": own["fused"]}

    return Fitted(
        predict=lambda vis, tac: {n: predictor(model)(vis, tac) for n, model in models.items()},
        features=features,
        chosen=chosen,
        parameters=sum(p.numel() for p in models["fused"].parameters()),
    )


def predictor(model: nn.Module) -> Predictor:
    """Return (vis, tac) -> probabilities (B, K)."""

    @torch.inference_mode()
    def predict(vis: Tensor, tac: Tensor) -> Tensor:
        probabilities: Tensor = model(vis, tac).softmax(-1)
        return probabilities

    return predict


def _train(source: Source, lr: float, decay: float, inputs: tuple[str, ...]) -> Perceptron:
    with seeded(derive_seed(source.seed, "erm-mlp")):
        model = Perceptron(source.width, len(source.classes), inputs)
        descend(
            model,
            len(source),
            Descent(lr=lr, epochs=source.epochs or EPOCHS, weight_decay=decay, method="adam"),
            lambda rows: cross_entropy(model(*source.drawn(rows)), source.labels[rows]),
        )
    return model
