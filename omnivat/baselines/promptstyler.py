"""PromptStyler, source-free: a linear head trained on style texts alone classifies images.

Stage 1, the styles, is the LANG bank. Stage 2 is trained here: with ArcFace, at the paper's rate,
which stays, for the paper states no schedule, decay or clip; or with plain cross-entropy, at the rate
and with the schedule of a public re-implementation (Dassl's warm-up, cosine and decay). Source: Cho
et al., PromptStyler, ICCV 2023; ArcFace: Deng et al., CVPR 2019.
"""

from collections.abc import Callable

import torch
from torch import Tensor, nn
from torch.nn.functional import cross_entropy, linear, normalize, one_hot

from omnivat.baselines.contract import Fitted, Source, fused, seeded
from omnivat.baselines.descent import Descent, descend
from omnivat.baselines.zero_shot import texts_of_the_image_encoder
from omnivat.seeding import derive_seed

PAPER = Descent(lr=0.005, epochs=50, batch=128, weight_decay=0.0, cosine=False, clip=0.0)
PUBLIC = Descent(lr=0.05, epochs=50, batch=128, warmup=0.02, clip=0.0)
SCALE, MARGIN = 5.0, 0.5  # of ArcFace, as published; the margin in radians
Logits = Callable[[Tensor, Tensor], Tensor]
Loss = Callable[[Tensor, Tensor, Tensor], Tensor]


def fit(source: Source) -> Fitted:
    """Train a head of unit weights with ArcFace; no image of the source is used.

    Raises DataError where the texts are not of the image encoder's own text tower.
    """
    return _fit(source, scaled_cosines, arcface, PAPER)


def fit_cross_entropy(source: Source) -> Fitted:
    """Train a bias-free linear head with cross-entropy; no image of the source is used.

    Raises DataError where the texts are not of the image encoder's own text tower.
    """
    return _fit(source, linear, lambda rows, w, labels: cross_entropy(rows @ w.T, labels), PUBLIC)


def arcface(rows: Tensor, weight: Tensor, labels: Tensor) -> Tensor:
    """Return the cross-entropy of scaled cosines with an angular margin for the true class.

    rows (B, D), weight (K, D), labels (B,) -> (): the true class's angle θ counts as θ + MARGIN
    """
    cosines = linear(normalize(rows, dim=-1), normalize(weight, dim=-1)).clamp(-1 + 1e-6, 1 - 1e-6)
    turned = torch.cos(torch.acos(cosines) + MARGIN)
    true = one_hot(labels, len(weight)).bool()
    return cross_entropy(SCALE * torch.where(true, turned, cosines), labels)


def scaled_cosines(rows: Tensor, weight: Tensor) -> Tensor:
    """Return logits (B, K) of a head of unit weights, without a margin."""
    return SCALE * linear(normalize(rows, dim=-1), normalize(weight, dim=-1))


def _fit(source: Source, logits: Logits, loss: Loss, how: Descent) -> Fitted:
    lang = normalize(texts_of_the_image_encoder(source, "Source-free PromptStyler"), dim=-1)
    classes, styles, width = lang.shape
    rows, labels = lang.flatten(0, 1), torch.arange(classes).repeat_interleave(styles)
    with seeded(derive_seed(source.seed, "promptstyler")):
        head = nn.Linear(width, classes, bias=False)
        descend(head, len(rows), how, lambda some: loss(rows[some], head.weight, labels[some]))
    weight = head.weight.detach()

    def predict(vis: Tensor, tac: Tensor) -> dict[str, Tensor]:
        return fused(
            {
                name: logits(normalize(images, dim=-1), weight).softmax(-1)
                for name, images in (("vis", vis), ("tac", tac))
            }
        )

    return Fitted(predict=predict, parameters=weight.numel())
