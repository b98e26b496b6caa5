"""Zero-shot: cosine of images with the class's texts, where the image encoder can read text."""

from torch import Tensor
from torch.nn.functional import normalize

from omnivat.baselines.contract import Fitted, Source, fused
from omnivat.errors import DataError

LOGIT_SCALE = 100.0  # CLIP's own, to which its training was clamped


def fit(source: Source) -> Fitted:
    """Average each class's texts into a prototype; nothing is learned from the source.

    Raises DataError where the texts are not of the image encoder's own text tower.
    """
    lang = texts_of_the_image_encoder(source, "Zero-shot prediction")
    prototypes = normalize(normalize(lang, dim=-1).mean(1), dim=-1)

    def alone(rows: Tensor) -> Tensor:
        return (LOGIT_SCALE * normalize(rows, dim=-1) @ prototypes.T).softmax(-1)

    return Fitted(predict=lambda vis, tac: fused({"vis": alone(vis), "tac": alone(tac)}))


def texts_of_the_image_encoder(source: Source, what: str) -> Tensor:
    """Return LANG (K, S, D), or say why it cannot stand for images."""
    if source.lang is None or not source.lang_of_images:
        raise DataError(
            f"{what} needs texts in the image encoder's own space, and this LANG bank is of "
            "another encoder. Embed the pairs with a CLIP encoder and pass its bank as --lang FILE."
        )
    return source.lang
