"""One training batch through the head: with LANG, class tokens and the whole tree."""

from collections.abc import Mapping

import torch
from jaxtyping import Bool, Float, Float64, Int
from torch import Tensor

from omnivat.head.body import Body
from omnivat.head.dtg import grow
from omnivat.head.output import TrainingOutput


def training_pass(
    model: Body,
    images: Mapping[str, Float[Tensor, "B W"]],
    lang: Float[Tensor, "B L"] | None,
    labels: Int[Tensor, " B"],
    *,
    lang_on: Bool[Tensor, " B"],
    token_on: Bool[Tensor, " B"],
    order: Float64[Tensor, "*any"] | None = None,
) -> TrainingOutput:
    """Run one batch.

    images    "vis", "tac" or both
    lang      of each pair's class, or None
    lang_on   pairs whose VIS and TAC are guided by LANG
    token_on  pairs that use the token of their class; the others use the class-agnostic one, as in
              prediction
    order     orders that replace the learned one, without gradient
    """
    names = tuple(images)
    embedding = model.embedded(images)
    text = None if lang is None else model.embedded({"lang": lang})
    if not model.settings.mffa:  # the tree grows from the embeddings, and MMA has nothing to align
        found = embedding / model.length
        root = found.sum(0)
        if text is not None:
            root = root + text[0] / model.length * lang_on[:, None]
        return _output(model, dict(zip(names, found, strict=True)), found, root, {})
    features: dict[str, Tensor] = {}
    tokens: dict[str, Tensor] = {}

    def run(some: tuple[str, ...], rows: Tensor, guide: Tensor | None = None) -> Tensor:
        """Return F-bar; the mean token of each pair is added to `tokens`, for the bank."""
        expanded = model.mffa.expand(some, model.mffa.parts(some, rows, order))
        token = None
        if model.settings.class_token:
            means = model.mffa.mean_tokens(expanded)
            tokens.update(zip(some, means, strict=True))
            agnostic = model.mffa.class_agnostic_tokens(some)[:, None]
            token = torch.where(token_on[:, None], class_means(means, labels), agnostic)
        bars = model.mffa.features(expanded, guide=guide, guided=lang_on, token=token)
        features.update(zip(some, bars, strict=True))
        return bars

    guide = None
    if text is not None:
        length = model.length if model.settings.guide_length == "embedding" else 1.0
        run(("lang",), text)
        guide = length * features["lang"]
        if model.settings.guide != "query":
            embedding = embedding + guide * lang_on[:, None]
    found = run(names, embedding, None if model.settings.guide == "added" else guide)
    root = found.sum(0)
    if text is not None:
        root = root + features["lang"] * lang_on[:, None]
    return _output(model, features, found, root, tokens)


def _output(
    model: Body,
    features: dict[str, Float[Tensor, "B D"]],
    bars: Float[Tensor, "M B D"],
    root: Float[Tensor, "B D"],
    tokens: dict[str, Float[Tensor, "B D"]],
) -> TrainingOutput:
    """Grow nodes from `root`, add their mean to the features, classify."""
    names = [name for name in features if name != "lang"]
    grown = grow(model.dtg, model.settings, bars, root)
    f_hat = bars if grown is None else bars + grown.nodes.mean(1)
    return TrainingOutput(
        features=features,
        layers=[root[:, None]] if grown is None else grown.groups,
        logits=dict(zip(names, model.classify(f_hat), strict=True)),
        tokens=tokens,
    )


def class_means(
    values: Float[Tensor, "*any B D"], labels: Int[Tensor, " B"]
) -> Float[Tensor, "*any B D"]:
    """Return each sample's class mean in the batch."""
    same = (labels[:, None] == labels[None]).to(values.dtype)
    return same / same.sum(1, keepdim=True) @ values
