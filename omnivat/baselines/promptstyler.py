"""PromptStyler, source-free: a linear head learns from style texts alone and answers images.

Source: Cho et al., ICCV 2023, stage 2; stage 1, the styles, is the LANG bank.
"""

import torch
from torch import Tensor, nn
from torch.nn.functional import cross_entropy, normalize

from omnivat.baselines.contract import Fitted, Source, fused, seeded
from omnivat.baselines.descent import Descent, descend
from omnivat.baselines.zero_shot import texts_of_the_image_encoder
from omnivat.seeding import derive_seed

HOW = Descent(lr=0.05, epochs=50, batch=128)  # as published


def fit(source: Source) -> Fitted:
    """Train a bias-free linear head on normalised texts; no image of the source is used.

    Raises DataError where the texts are not of the image encoder's own text tower.
    """
    lang = normalize(texts_of_the_image_encoder(source, "Source-free PromptStyler"), dim=-1)
    classes, styles, width = lang.shape
    rows, labels = lang.flatten(0, 1), torch.arange(classes).repeat_interleave(styles)
    with seeded(derive_seed(source.seed, "promptstyler")):
        head = nn.Linear(width, classes, bias=False)
        descend(
            head, len(rows), HOW, lambda chosen: cross_entropy(head(rows[chosen]), labels[chosen])
        )

    @torch.inference_mode()
    def predict(vis: Tensor, tac: Tensor) -> dict[str, Tensor]:
        return fused(
            {
                name: head(normalize(images, dim=-1)).softmax(-1)
                for name, images in (("vis", vis), ("tac", tac))
            }
        )

    return Fitted(predict=predict, parameters=head.weight.numel())
