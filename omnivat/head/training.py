"""One training batch through the head: with LANG, class tokens and the whole tree."""

import torch
from jaxtyping import Bool, Float, Float64, Int
from torch import Tensor

from omnivat.head.body import Body
from omnivat.head.dtg import grow
from omnivat.head.mffa import Expanded
from omnivat.head.output import TrainingOutput


def training_pass(
    model: Body,
    images: dict[str, Float[Tensor, "B W"]],
    lang: Float[Tensor, "B L"] | None,
    labels: Int[Tensor, " B"],
    *,
    lang_on: Bool[Tensor, " B"] | None,
    token_on: Bool[Tensor, " B"] | None,
    order: Float64[Tensor, "*any"] | None = None,
) -> TrainingOutput:
    """Run one batch; see `OmniVaT.training_pass`. given: "vis", "tac" or both."""
    names = tuple(images)
    lang_on = torch.ones_like(labels, dtype=torch.bool) if lang_on is None else lang_on
    if not model.settings.mffa:  # the tree grows from the embeddings, and MMA has nothing to align
        found = model.embedded(images) / model.length
        root = found.sum(0)
        if lang is not None:
            root = root + model.embedded({"lang": lang})[0] / model.length * lang_on[:, None]
        return _output(model, dict(zip(images, found, strict=True)), found, root, {})
    features: dict[str, Tensor] = {}
    tokens: dict[str, Tensor] = {}
    embedding = model.embedded(images)
    guide = None
    if lang is not None:
        text = model.embedded({"lang": lang})
        own = model.mffa.expand(("lang",), model.mffa.parts(("lang",), text, order))
        token = _class_tokens(model, ("lang",), own, labels, token_on, tokens)
        features["lang"] = model.mffa.features(("lang",), own, token=token)[0]
        length = model.length if model.settings.guide_length == "embedding" else 1.0
        guide = length * features["lang"]
        if model.settings.guide != "query":
            embedding = embedding + guide * lang_on[:, None]
    own = model.mffa.expand(names, model.mffa.parts(names, embedding, order))
    token = _class_tokens(model, names, own, labels, token_on, tokens)
    query = None if model.settings.guide == "added" else guide
    found = model.mffa.features(names, own, guide=query, guided=lang_on, token=token)
    features |= dict(zip(names, found, strict=True))
    root = found.sum(0)
    if guide is not None:
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


def _class_tokens(
    model: Body,
    names: tuple[str, ...],
    expanded: Expanded,
    labels: Int[Tensor, " B"],
    token_on: Bool[Tensor, " B"] | None,
    tokens: dict[str, Float[Tensor, "B D"]],
) -> Float[Tensor, "M B D"] | None:
    """Return class tokens: of the pair's class, or the class-agnostic one.

    The mean token of each pair is added to `tokens`, for the bank.
    """
    if not model.settings.class_token:
        return None
    values = model.mffa.mean_tokens(expanded)
    tokens |= dict(zip(names, values, strict=True))
    own = class_means(values, labels)
    if token_on is None:
        return own
    return torch.where(token_on[:, None], own, model.mffa.class_agnostic_tokens(names)[:, None])


def class_means(
    values: Float[Tensor, "*any B D"], labels: Int[Tensor, " B"]
) -> Float[Tensor, "*any B D"]:
    """Return each sample's class mean in the batch."""
    same = (labels[:, None] == labels[None]).to(values.dtype)
    return same / same.sum(1, keepdim=True) @ values
