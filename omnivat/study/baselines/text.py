"""Methods that learn from class texts alone, for image encoders with a text tower.

Zero-shot compares images with texts by cosine (Radford et al., CLIP, 2021).

PromptStyler, source-free: a linear head trained on style texts classifies images. Stage 1, the
styles, is the LANG bank. Stage 2 is trained here with ArcFace at the paper's rate, which stays, for
the paper states no schedule, decay or clip. Source: Cho et al., PromptStyler, ICCV 2023; ArcFace:
Deng et al., CVPR 2019.
"""

import torch
from torch import Tensor, nn
from torch.nn.functional import cross_entropy, linear, normalize, one_hot

from omnivat.kit.errors import DataError
from omnivat.kit.seeding import derive_seed
from omnivat.study.baselines.contract import Fitted, Source, late, seeded
from omnivat.study.baselines.descent import Descent, descend

LOGIT_SCALE = 100.0  # the limit in CLIP's training, which published models reach
PAPER = Descent(lr=0.005, epochs=50, batch=128, weight_decay=0.0, cosine=False, clip=0.0)
SCALE, MARGIN = 5.0, 0.5  # of ArcFace, as published; the margin in radians


def fit_zero_shot(source: Source) -> Fitted:
    """Classify by cosine with the text "a photo of a CLASS."; nothing is learned.

    Logits are cosines times the logit scale of the model, or LOGIT_SCALE if it has none.

    Raises DataError if the LANG bank is not from the text tower of the image encoder.
    """
    texts_of_the_image_encoder(source, "Zero-shot prediction")
    if source.plain is None:
        raise DataError(
            "Zero-shot prediction needs the plain prompts, which this LANG bank lacks; make it"
            " again with `python -m omnivat prompts`."
        )
    prototypes, scale = normalize(source.plain, dim=-1), source.logit_scale or LOGIT_SCALE

    def alone(_: str, rows: Tensor) -> Tensor:
        return (scale * normalize(rows, dim=-1) @ prototypes.T).softmax(-1)

    return Fitted(predict=late(alone), chosen={"logit scale": scale})


def texts_of_the_image_encoder(source: Source, what: str) -> Tensor:
    """Return LANG (K, S, D). Raises DataError if it is not in the images' space."""
    if source.lang is None:
        raise DataError(f"{what} needs the classes' texts. {source.why_no_lang}".strip())
    if not source.lang_of_images:
        raise DataError(
            f"{what} needs texts in the image encoder's own space, and this LANG bank is of "
            "another encoder. Embed the pairs with a CLIP encoder and pass its bank as --lang FILE."
        )
    return source.lang


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


def fit_promptstyler(source: Source) -> Fitted:
    """Train a bias-free linear head on the texts with ArcFace; no image of the source is used.

    Raises DataError if the LANG bank is not from the text tower of the image encoder.
    """
    lang = normalize(texts_of_the_image_encoder(source, "Source-free PromptStyler"), dim=-1)
    classes, styles, width = lang.shape
    rows, labels = lang.flatten(0, 1), torch.arange(classes).repeat_interleave(styles)
    with seeded(derive_seed(source.seed, "promptstyler")):
        head = nn.Linear(width, classes, bias=False)
        descend(head, len(rows), PAPER, lambda some: arcface(rows[some], head.weight, labels[some]))
    weight = head.weight.detach()
    return Fitted(
        predict=late(lambda _, images: scaled_cosines(images, weight).softmax(-1)),
        parameters=weight.numel(),
    )
