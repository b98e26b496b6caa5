"""The paper's Baseline: style texts and source images through one D×D layer and a linear head.

This is our reading of the paper's PromptStyler row. Its results depend on the source, so it trains
on source images, and its 0.3 M parameters fit a D×D layer. Source: paper, Table of components, row
1.
"""

from collections.abc import Callable

import torch
from torch import Tensor, nn
from torch.nn.functional import cross_entropy, normalize

from omnivat.baselines.contract import Fitted, Source, fused, joined, seeded
from omnivat.baselines.descent import Descent, descend
from omnivat.baselines.evidence import best
from omnivat.seeding import derive_seed

EPOCHS = 20
CANDIDATES = {f"lr {lr:g}, text {share:g}": (lr, share) for lr in (0.02, 0.1) for share in (0.1, 1.0)}
TEXTS = 16  # style texts in each step


class Baseline(nn.Module):
    """One D×D layer and a bias-free linear head, shared by images and text."""

    def __init__(self, width: int, classes: int, text_width: int | None) -> None:
        super().__init__()
        self.text: nn.Module = nn.Identity()
        if text_width is not None:
            self.text = nn.Linear(text_width, width, bias=False)
        self.layer = nn.Linear(width, width)
        self.head = nn.Linear(width, classes, bias=False)

    def features(self, rows: Tensor) -> Tensor:
        """Return unit features (B, D) of rows (B, D), which are first scaled to length √D."""
        hidden: Tensor = self.layer(rows.shape[1] ** 0.5 * normalize(rows, dim=-1))
        return normalize(hidden, dim=-1)

    def forward(self, rows: Tensor) -> Tensor:
        """Return logits (B, K) of rows (B, D)."""
        logits: Tensor = self.head(self.features(rows) * 10.0)
        return logits

    def probabilities(self, rows: Tensor) -> Tensor:
        """Return class probabilities (B, K)."""
        logits: Tensor = self(rows)
        return logits.softmax(-1)


def fit(source: Source) -> Fitted:
    """Train with SGD as in the paper; held-out objects choose rate and weight of text."""
    chosen = best(source, CANDIDATES, lambda part, choice: _fused(_train(part, *choice)), repeats=1)
    model = _train(source, *CANDIDATES[chosen])

    @torch.inference_mode()
    def predict(vis: Tensor, tac: Tensor) -> dict[str, Tensor]:
        return fused({"vis": model.probabilities(vis), "tac": model.probabilities(tac)})

    @torch.inference_mode()
    def features(vis: Tensor, tac: Tensor) -> dict[str, Tensor]:
        return joined(model.features(vis), model.features(tac))

    return Fitted(
        predict=predict,
        features=features,
        chosen={"training": chosen},
        parameters=sum(p.numel() for p in model.parameters()),
    )


def _fused(model: Baseline) -> Callable[[Tensor, Tensor], Tensor]:
    @torch.inference_mode()
    def predict(vis: Tensor, tac: Tensor) -> Tensor:
        return (model.probabilities(vis) + model.probabilities(tac)) / 2

    return predict


def _train(source: Source, lr: float, text_weight: float) -> Baseline:
    lang, classes = source.lang, len(source.classes)
    mapped = lang is not None and not source.lang_of_images
    with seeded(derive_seed(source.seed, "baseline")):
        model = Baseline(source.width, classes, lang.shape[2] if mapped and lang is not None else None)

        def loss(rows: Tensor) -> Tensor:
            images = torch.cat(source.drawn(rows))
            total = cross_entropy(model(images), source.labels[rows].repeat(2))
            if lang is not None:
                truth = torch.randint(classes, (TEXTS,))
                texts = lang[truth, torch.randint(lang.shape[1], (TEXTS,))]
                total = total + text_weight * cross_entropy(model(model.text(texts)), truth)
            return total

        descend(model, len(source), Descent(lr=lr, epochs=EPOCHS), loss)
    return model
