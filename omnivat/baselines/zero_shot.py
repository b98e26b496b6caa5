"""Zero-shot: cosine of images with class texts, for image encoders with a text tower."""

from torch import Tensor
from torch.nn.functional import normalize

from omnivat.baselines.contract import Fitted, Source, fused
from omnivat.errors import DataError

LOGIT_SCALE = 100.0  # the limit in CLIP's training, which published models reach


def fit(source: Source) -> Fitted:
    """Compare with "a photo of a CLASS." at the model's own scale; nothing is learned.

    Source: Radford et al., CLIP, 2021.
    Raises DataError where the texts are not of the image encoder's own text tower.
    """
    texts_of_the_image_encoder(source, "Zero-shot prediction")
    if source.plain is None:
        raise DataError(
            "Zero-shot prediction needs the plain prompts, which this LANG bank lacks; make it again "
            "with `python -m omnivat prompts`, or use zero_shot_styles."
        )
    return _compared(source.plain, source.logit_scale or LOGIT_SCALE)


def fit_styles(source: Source) -> Fitted:
    """Compare with the mean of each class's texts in all styles; nothing is learned.

    Raises DataError where the texts are not of the image encoder's own text tower.
    """
    lang = texts_of_the_image_encoder(source, "Zero-shot prediction")
    return _compared(normalize(lang, dim=-1).mean(1), source.logit_scale or LOGIT_SCALE)


def _compared(texts: Tensor, scale: float) -> Fitted:
    prototypes = normalize(texts, dim=-1)

    def alone(rows: Tensor) -> Tensor:
        return (scale * normalize(rows, dim=-1) @ prototypes.T).softmax(-1)

    return Fitted(predict=lambda vis, tac: fused({"vis": alone(vis), "tac": alone(tac)}), chosen={"logit scale": scale})


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
