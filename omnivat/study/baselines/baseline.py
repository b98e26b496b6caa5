"""The paper's Baseline: style texts and source images through one D×D layer and a linear head.

This is our reading of the paper's PromptStyler row. Its results depend on the source, so it trains
on source images, and its 0.3 M parameters fit a D×D layer. Source: paper, Table of components, row
1.
"""

from dataclasses import replace

import torch
from torch import Tensor, nn
from torch.nn.functional import cross_entropy, normalize

from omnivat.study.baselines.contract import Fitted, Source, joined, late, sized
from omnivat.study.baselines.descent import Descent, learned, size
from omnivat.study.baselines.evidence import best

EPOCHS = 20
CANDIDATES = {
    f"lr {lr:g}, text {share:g}": (lr, share) for lr in (0.02, 0.1) for share in (0.1, 1.0)
}
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
        return normalize(self.layer(sized(rows)), dim=-1)

    def forward(self, rows: Tensor) -> Tensor:
        """Return logits (B, K) of rows (B, D)."""
        logits: Tensor = self.head(self.features(rows) * 10.0)
        return logits


def fit(source: Source) -> Fitted:
    """Train with SGD as in the paper; held-out objects choose rate and weight of text."""
    chosen = best(source, CANDIDATES, _fitted, repeats=1)
    return replace(_fitted(source, CANDIDATES[chosen]), chosen={"training": chosen})


def _fitted(source: Source, choice: tuple[float, float]) -> Fitted:
    lang, classes, (lr, text_weight) = source.lang, len(source.classes), choice
    present = source.labels.unique()  # texts of other classes would teach what no picture shows

    def loss(model: Baseline, rows: Tensor) -> Tensor:
        images = torch.cat(source.drawn(rows))
        total = cross_entropy(model(images), source.labels[rows].repeat(2))
        if lang is not None:
            truth = present[torch.randint(len(present), (TEXTS,))]
            texts = lang[truth, torch.randint(lang.shape[1], (TEXTS,))]
            total = total + text_weight * cross_entropy(model(model.text(texts)), truth)
        return total

    mapped = None if lang is None or source.lang_of_images else lang.shape[2]
    how = Descent(lr=lr, epochs=EPOCHS)
    model = learned(source, lambda: Baseline(source.width, classes, mapped), how, loss, "baseline")
    return Fitted(
        predict=late(lambda _, rows: model(rows).softmax(-1)),
        features=lambda vis, tac: joined(model.features(vis), model.features(tac)),
        parameters=size(model),
    )
