"""The head with every setting, token by token: what exports run, and what the fast head is compared
with.

`reference.py` is the paper alone; here are also the ablations and what the paper leaves open.
A comment beside a line is the shape of its result. B pairs, C channels (Re and Im), E numbers θ_e,
T tokens, Q queries, D width, N nodes of the tree, K classes. No line looks at a value, so
`torch.export` takes `predict` with p as an input.
"""

from collections.abc import Mapping
from functools import lru_cache
from typing import Any, NamedTuple

import torch
from jaxtyping import Bool, Float, Float64
from torch import Tensor, nn
from torch.nn.functional import linear, normalize

from omnivat.fractional import Basis, basis
from omnivat.head.dtg import parents
from omnivat.head.fusion import fuse, tempered


def embedded(head: Any, name: str, raw: Float[Tensor, "B W"]) -> Float[Tensor, "B D"]:
    """Project an encoder's embeddings to width D; their length becomes √D.

    Ours, before it: each channel of an image by the source's mean and scale (docs/method.md).
    """
    if head.settings.standardize:
        raw = head.standardised(name, raw)  # (B, W)
    apart = name == "tac" and head.settings.projects_apart
    layer = head.project_tac if apart else head.project_image
    projected = (head.project_lang if name == "lang" else layer)(raw)  # (B, D)
    if head.settings.feature_scale == "literal":
        return projected  # type: ignore[no-any-return]
    return head.length * normalize(projected, dim=-1)  # type: ignore[no-any-return]


@lru_cache(maxsize=8)
def eigenbasis(width: int, dtype: torch.dtype, device: torch.device) -> Basis:
    """Return the eigenvectors V of the Fourier matrix, and the index k of each."""
    with torch.inference_mode(False):
        return basis(width, dtype=dtype, device=device)


def transform(
    embedding: Float[Tensor, "*any D"], order: Float64[Tensor, "..."]
) -> Float[Tensor, "2 *any D"]:
    """Return F_p(E) = V diag(exp(-iπpk/2)) Vᵀ E, as Re and Im. Eq. 2.

    order  broadcast against the leading axes of E; with gradients, once
    """
    vectors, k = eigenbasis(embedding.shape[-1], embedding.dtype, embedding.device)
    # (..., D) float64, quarter turns
    turns = torch.fmod(torch.fmod(order, 4.0)[..., None] * k, 4.0)
    whole = torch.round(turns)  # applied as 0 or ±1, so that even orders are exact
    angle, quarter = (turns - whole) * (torch.pi / 2), torch.remainder(whole.detach(), 4.0)
    step = (quarter - 2).abs() - 1, 1 - (quarter - 1).abs()  # cosine and sine of it
    cos = (angle.cos() * step[0] - angle.sin() * step[1]).to(embedding.dtype)
    sin = (angle.sin() * step[0] + angle.cos() * step[1]).to(embedding.dtype)
    inner = embedding @ vectors  # (..., D)
    return linear(torch.stack((inner * cos, inner * -sin)), vectors)  # (2, ..., D)


def tokens_of(
    parts: Float[Tensor, "2 B D"], theta: Float[Tensor, " E"], kind: str
) -> Float[Tensor, "#2 B T D"]:
    """Expand by θ_e and apply ReLU, Eq. 3.

    θ_e commutes with the transform. Re and Im become tokens side by side, T = 2E; other kinds
    take the modulus or Re alone, T = E, or keep complex tokens, (2, B, E, D).
    """
    if kind == "magnitude":
        parts, theta = torch.linalg.vector_norm(parts, dim=0, keepdim=True), theta.abs()
    parts = parts[:1] if kind == "real" else parts
    tokens = torch.relu(theta[:, None] * parts[:, :, None])  # (C, B, E, D)
    return tokens if kind == "hermitian" else tokens.movedim(0, 1).flatten(1, 2)[None]


def attention(
    fratt: nn.Module, queries: Float[Tensor, "C B Q D"], tokens: Float[Tensor, "C B T D"]
) -> tuple[Float[Tensor, "B D"], Float[Tensor, "B Q T"]]:
    """FrATT, Eq. 4: the feature and the weights.

    C = 1, or 2 for complex tokens: scores Re(Q Kᴴ), then the modulus; biases belong to Re.
    """
    fratt_any: Any = fratt
    score_root, value_root = fratt_any.roots
    query, key = (_layer(x, y) for x, y in ((fratt_any.query, queries), (fratt_any.key, tokens)))
    weights = torch.softmax((query @ key.mT).sum(0) / score_root, dim=-1)  # (B, Q, T)
    mixed = (weights @ _layer(fratt_any.value, tokens)).mean(2) / value_root  # (C, B, D)
    real = mixed[0] if len(mixed) == 1 else torch.linalg.vector_norm(mixed, dim=0)  # (B, D)
    return fratt_any.ffn(real), weights


def queries_of(
    tokens: Float[Tensor, "C B T D"],
    guide: Float[Tensor, "B D"] | None,
    guided: Bool[Tensor, " B"] | None,
) -> Float[Tensor, "C B T D"]:
    """Return queries: tokens, or F-bar of LANG where guided. Eq. 6."""
    if guide is None or guided is None:
        return tokens
    text = torch.stack((guide, torch.zeros_like(guide)))[: len(tokens), :, None]  # (C, B, 1, D)
    return torch.where(guided[:, None, None], text, tokens)


def with_class_token(
    tokens: Float[Tensor, "C B T D"], token: Float[Tensor, "#B D"] | None
) -> Float[Tensor, "C B T D"]:
    """Add F_g to the real part of the tokens."""
    if token is None:
        return tokens
    real = tokens[:1] + token[:, None]  # (1, B, T, D)
    return torch.cat((real, tokens[1:]))


def _layer(layer: nn.Linear, parts: Float[Tensor, "C B N _"]) -> Float[Tensor, "C B N _"]:
    """Apply a real layer to channels; its bias is added to the first one only."""
    return torch.cat((layer(parts[:1]), linear(parts[1:], layer.weight)))


class Feature(NamedTuple):
    """One modality after MFFA."""

    f_bar: Float[Tensor, "B D"]
    parts: Float[Tensor, "2 B D"]  # Re and Im of F_p(E)
    relu: Float[Tensor, "C B D"]  # F: the mean over θ_e of the tokens of each channel
    weights: Float[Tensor, "B Q T"] | None = None


def mffa(
    head: Any,
    name: str,
    embedding: Float[Tensor, "B D"],
    order: Float64[Tensor, "..."] | None,
    *,
    guide: Float[Tensor, "B D"] | None = None,
    guided: Bool[Tensor, " B"] | None = None,
    token: Any = None,
) -> Feature:
    """Return F-bar of embeddings, Eq. 3 to 6.

    guide   F-bar of LANG, the query of the pairs `guided`
    token   maps the mean token (B, D) to the class token F_g; None: the class-agnostic one
    """
    own = head.mffa
    p = own.orders([name]) if order is None else order
    parts = transform(embedding, p.reshape(-1))  # (2, B, D)
    if not head.settings.mffa:
        return Feature(embedding / head.length, parts, torch.relu(parts))
    tokens = tokens_of(parts, own.theta[name], own.real)  # (C, B, T, D)
    channels = 1 if own.real in ("magnitude", "real") else 2
    means = (
        tokens.mean(2)
        if own.real == "hermitian"
        else tokens[0].unflatten(1, (channels, -1)).mean(2).movedim(1, 0)
    )  # (C, B, D)
    queries = queries_of(tokens, guide, guided)
    if own.class_token:
        added = own.class_agnostic_tokens([name]) if token is None else token(tokens[0].mean(1))
        tokens = with_class_token(tokens, added)
    feature, weights = attention(own.fratt, queries, tokens)
    feature = normalize(feature, dim=-1) if own.unit else feature
    return Feature(feature, parts, means, weights)


def tree(
    head: Any, features: list[Float[Tensor, "B D"]], root: Float[Tensor, "B D"]
) -> Float[Tensor, "B N D"] | None:
    """DTG: return nodes, the root T first; a child is W x + b of its parent. Eq. 7, 8."""
    settings, dtg = head.settings, head.dtg
    if settings.generation == "none":
        return None
    if settings.generation == "interpolation":
        shares = [n / 2**settings.levels for n in range(1, 2**settings.levels)]
        return torch.stack([torch.lerp(features[0], features[-1], s) for s in shares], dim=1)
    nodes = [root]  # (B, D) each
    for child, parent in enumerate(parents(dtg.arrangement, len(dtg.weight) + 1)[1:]):
        nodes.append(linear(nodes[parent], dtg.weight[child], dtg.bias[child]))
    return torch.stack(nodes, dim=1)


class Predicted(NamedTuple):
    """A prediction, by modality where it is a dictionary."""

    probabilities: Float[Tensor, "B K"]
    logits: dict[str, Float[Tensor, "B K"]]
    features: dict[str, Feature]
    f_hat: dict[str, Float[Tensor, "B D"]]
    nodes: Float[Tensor, "B N D"] | None


def predict(
    head: Any,
    images: Mapping[str, Float[Tensor, "B W"]],
    order: Float64[Tensor, "*any"] | None = None,
) -> Predicted:
    """Predict from embeddings of "vis", "tac" or both, at one order or one for each pair; None:
    the learned one.
    """
    features = {n: mffa(head, n, embedded(head, n, raw), order) for n, raw in images.items()}
    found = [one.f_bar for one in features.values()]  # (B, D) each
    nodes = tree(head, found, torch.stack(found).sum(0))
    grows = nodes is not None and head.settings.tree_at_inference
    mean = nodes.mean(1) if nodes is not None and grows else 0.0  # (B, D)
    f_hat = {name: one.f_bar + mean for name, one in features.items()}
    logits = {name: head.classify(one) for name, one in f_hat.items()}
    if len(logits) == 1:
        ((name, only),) = logits.items()
        shares = tempered(only, head.calibration.temperature[name])
    else:
        pair = head.classify(torch.stack(list(f_hat.values())).sum(0))
        shares = fuse(head.settings.fusion, logits, pair, head.calibration)
    return Predicted(shares, logits, features, f_hat, nodes)
