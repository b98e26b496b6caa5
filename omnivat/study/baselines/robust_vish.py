"""RobustVisH-2: convolutions and a recurrent net over embeddings as sequences, fused by attention.

Source: the published architecture without its kinaesthetic branch. A fit takes minutes to hours on
a CPU, so it is not among the default methods. An absent image is its training mean, zero after
scaling.
"""

import torch
from torch import Tensor, nn
from torch.nn.functional import cross_entropy

from omnivat.kit.logistic import scaling
from omnivat.study.baselines.contract import Fitted, Rows, Source
from omnivat.study.baselines.descent import Descent, learned, size

WIDTH, KERNELS, HEADS = (128, 256, 128), (8, 5, 3), 3
HOW = Descent(lr=1e-3, epochs=100, batch=8, method="adam", weight_decay=0.0)


class Convolutions(nn.Sequential):
    """Three convolutions over a sequence: (B, D) -> (B, D, 128)."""

    def __init__(self) -> None:
        inputs = (1, *WIDTH[:-1])
        layers: list[nn.Module] = []
        for into, out, kernel in zip(inputs, WIDTH, KERNELS, strict=True):
            layers += [
                nn.Conv1d(into, out, kernel, padding=kernel // 2),
                nn.BatchNorm1d(out),
                nn.ReLU(),
            ]
        super().__init__(*layers)

    def forward(self, rows: Tensor) -> Tensor:
        features: Tensor = super().forward(rows[:, None])  # type: ignore[no-untyped-call]
        return features.mT


class RobustVisH(nn.Module):
    """VIS and TAC as sequences, a learned weighted sum of both, two attention layers, a softmax."""

    def __init__(self, classes: int) -> None:
        super().__init__()
        self.vis, self.tac = Convolutions(), Convolutions()
        self.recurrent = nn.GRU(WIDTH[-1], WIDTH[-1] // 2, bidirectional=True, batch_first=True)
        self.share = nn.Parameter(torch.zeros(2))
        layer = nn.TransformerEncoderLayer(
            WIDTH[-1] + 1, HEADS, dim_feedforward=128, dropout=0.5, batch_first=True
        )
        self.attention = nn.TransformerEncoder(layer, 2, enable_nested_tensor=False)
        self.head = nn.Linear(WIDTH[-1] + 1, classes)

    def forward(self, vis: Tensor, tac: Tensor) -> Tensor:
        """Return logits (B, K) of scaled embeddings (B, D)."""
        seen = self.vis(vis).mean(1)
        touched = self.recurrent(self.tac(tac))[0].mean(1)
        share = self.share.softmax(0)
        both = torch.stack((share[0] * seen, share[1] * touched), dim=1)
        place = torch.tensor([0.0, 1.0]).expand(len(both), 2)[..., None]
        mixed = self.attention(torch.cat((both, place), dim=-1)).mean(1)
        logits: Tensor = self.head(mixed)
        return logits


def fit(source: Source) -> Fitted:
    """Train with AdamW and a cosine rate from 1e-3, the middle of the published cyclic rate."""
    scale_vis, scale_tac = scaling(source.vis, "standard"), scaling(source.tac, "standard")

    def loss(model: RobustVisH, rows: Tensor) -> Tensor:
        vis, tac = source.drawn(rows)
        return cross_entropy(model(scale_vis(vis), scale_tac(tac)), source.labels[rows])

    model = learned(source, lambda: RobustVisH(len(source.classes)), HOW, loss, "robust-vish")

    def predict(vis: Tensor, tac: Tensor) -> Rows:
        seen, touched = scale_vis(vis), scale_tac(tac)
        no_photo, no_touch = torch.zeros_like(seen), torch.zeros_like(touched)
        given = {"fused": (seen, touched), "vis": (seen, no_touch), "tac": (no_photo, touched)}
        return {name: model(*rows).softmax(-1) for name, rows in given.items()}

    return Fitted(predict=predict, parameters=size(model))
