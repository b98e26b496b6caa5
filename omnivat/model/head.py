"""The OmniVaT head: frozen embeddings in, class probabilities and every stage out."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import torch
from torch import Tensor, nn
from torch.nn.functional import linear, normalize

from omnivat.errors import DataError, ShapeError
from omnivat.fractional import coefficients, synthesise
from omnivat.model.dtg import DTG
from omnivat.model.mffa import MFFA, expanded, planar
from omnivat.model.output import HeadOutput, TrainingOutput
from omnivat.model.settings import HeadSettings

IMAGE_MODALITIES = ("vis", "tac")


@dataclass(frozen=True, slots=True)
class PairCoefficients:
    """What stays fixed while p moves: eigenbasis coefficients of B pairs, by modality."""

    by_modality: Mapping[str, Any]

    def __getitem__(self, pairs: Any) -> "PairCoefficients":
        """Return the coefficients of some pairs: a slice, a mask or indices."""
        return PairCoefficients({name: c[pairs] for name, c in self.by_modality.items()})

    def __len__(self) -> int:
        return int(next(iter(self.by_modality.values())).shape[0])


class _Bars(NamedTuple):
    """F-bar of each modality with what was seen on the way."""

    frft: dict[str, Tensor]
    relu: dict[str, Tensor]
    f_bar: dict[str, Tensor]
    attention: dict[str, Tensor]


class OmniVaT(nn.Module):
    """MFFA, then DTG, then one cosine classifier shared by VIS and TAC.

    Called with VIS and TAC embeddings it predicts; LANG exists only in `training_pass`.
    The prediction of a pair does not depend on the other pairs of its batch.
    Source: paper, Fig. 2; docs/method.md says how open points were settled.
    """

    def __init__(self, settings: HeadSettings) -> None:
        super().__init__()
        self.settings = settings
        width = settings.width
        if settings.projects:
            self.project_image: nn.Module = nn.Linear(settings.input_width, width)
        else:
            self.project_image = nn.Identity()
        if settings.project or settings.lang_width != width:
            self.project_lang: nn.Module = nn.Linear(settings.lang_width, width)
        else:
            self.project_lang = nn.Identity()
        self.mffa = MFFA(settings)
        self.dtg = DTG.from_settings(settings)
        self.classifier = nn.Parameter(torch.empty(len(settings.classes), width))
        nn.init.normal_(self.classifier, std=width**-0.5)
        self._folded: tuple[Tensor, Tensor] | None = None

    @property
    def order(self) -> float:
        """The learned fractional order p, in quarter turns."""
        return float(self.mffa.order.detach())

    @property
    def dtype(self) -> torch.dtype:
        """The precision the head computes in."""
        return self.classifier.dtype

    # ---- prediction --------------------------------------------------------------------------

    def forward(
        self,
        vis: Tensor | None,
        tac: Tensor | None,
        *,
        order: float | Tensor | None = None,
        nodes: bool = False,
        attention: bool = False,
    ) -> HeadOutput:
        """Predict from raw embeddings of B pairs; see `coefficients` and `from_coefficients`."""
        return self.from_coefficients(
            self.coefficients(vis, tac), order, nodes=nodes, attention=attention
        )

    def coefficients(self, vis: Tensor | None, tac: Tensor | None) -> PairCoefficients:
        """Return what to keep while p moves.

        vis, tac  (B, input_width) as the encoder gave them; either may be None, not both
        Raises DataError when both are missing, ShapeError on a wrong width or differing B.
        """
        given = {"vis": vis, "tac": tac}
        kept = {
            name: coefficients(self._embedded(name, embedding))
            for name, embedding in given.items()
            if embedding is not None
        }
        if not kept:
            raise DataError("Neither VIS nor TAC was given; give one of them or both.")
        if len({len(e) for e in given.values() if e is not None}) > 1:
            raise ShapeError("vis and tac hold different numbers of pairs; give one each per pair.")
        return PairCoefficients(kept)

    def from_coefficients(
        self,
        kept: PairCoefficients,
        order: float | Tensor | None = None,
        *,
        nodes: bool = False,
        attention: bool = False,
    ) -> HeadOutput:
        """Predict at one order, or at one order a pair.

        kept       from `coefficients`
        order      quarter turns: a number, or (B,) for one order a pair; the learned one if None
        nodes      also return the tree's nodes
        attention  also return attention weights
        """
        order = self.order if order is None else order
        bars = self._bars(kept, order)
        root = torch.stack(list(bars.f_bar.values())).sum(0)
        mean = linear(root, *self._fold()) if self.settings.tree_at_inference else 0.0
        f_hat = {name: feature + mean for name, feature in bars.f_bar.items()}
        return HeadOutput(
            logits={name: self.classify(feature) for name, feature in f_hat.items()},
            frft=bars.frft,
            relu=bars.relu,
            f_bar=bars.f_bar,
            f_hat=f_hat,
            attention=bars.attention if attention else {},
            nodes=self.dtg.nodes(root) if nodes else None,
        )

    def classify(self, features: Tensor) -> Tensor:
        """Return logits (..., K) of features (..., D): tree nodes can be asked, too."""
        if self.settings.feature_scale == "literal":
            return linear(features, self.classifier)
        directions = normalize(self.classifier, dim=-1)
        return self.settings.logit_scale * linear(normalize(features, dim=-1), directions)

    def _bars(self, kept: PairCoefficients, order: float | Tensor) -> _Bars:
        bars = _Bars({}, {}, {}, {})
        for name, own in kept.by_modality.items():
            parts = planar(synthesise(own, order))
            attended = self.mffa.attend(name, parts)
            bars.frft[name] = parts
            bars.relu[name] = expanded(parts, self.mffa.theta[name]).unflatten(1, (2, -1)).mean(2)
            bars.f_bar[name] = attended.feature
            bars.attention[name] = attended.weights
        return bars

    def _fold(self) -> tuple[Tensor, Tensor]:
        if self.training or torch.is_grad_enabled():
            return self.dtg.fold()
        if self._folded is None or self._folded[0].dtype != self.dtype:
            self._folded = self.dtg.fold()
        return self._folded

    def train(self, mode: bool = True) -> "OmniVaT":
        """Switch between training and prediction; what was folded is forgotten."""
        self._folded = None
        return super().train(mode)

    # ---- training ----------------------------------------------------------------------------

    def training_pass(
        self,
        vis: Tensor,
        tac: Tensor,
        lang: Tensor | None,
        labels: Tensor,
        *,
        lang_on: Tensor | None = None,
        token_on: Tensor | None = None,
    ) -> TrainingOutput:
        """Run one batch with LANG and class tokens, as the losses need it.

        vis, tac  (B, input_width);  lang  (B, lang_width) of each pair's class, or None
        labels    (B,) class indices
        lang_on   (B,) bool: pairs whose VIS and TAC are guided by LANG; all where None
        token_on  (B,) bool: pairs that see their own class's token; others see the
                  class-agnostic one, as in prediction, where labels are not known
        """
        tokens: dict[str, Tensor] = {}
        features: dict[str, Tensor] = {}
        guide = None
        if lang is not None:
            parts = self.mffa.parts(self._embedded("lang", lang))
            features["lang"] = self._attend_in_training("lang", parts, labels, token_on, tokens)
            guide = self._scale() * features["lang"]
        lang_on = torch.ones_like(labels, dtype=torch.bool) if lang_on is None else lang_on
        for name, raw in (("vis", vis), ("tac", tac)):
            embedding = self._embedded(name, raw)
            query = None
            if guide is not None:
                embedding = embedding + guide * lang_on[:, None]
            parts = self.mffa.parts(embedding)
            if guide is not None:
                own = expanded(parts, self.mffa.theta[name])
                query = torch.where(lang_on[:, None, None], guide[:, None].expand_as(own), own)
            features[name] = self._attend_in_training(
                name, parts, labels, token_on, tokens, query=query
            )
        root = features["vis"] + features["tac"]
        if guide is not None:
            root = root + features["lang"] * lang_on[:, None]
        layers = self.dtg.layers(root)
        mean = torch.cat(layers, dim=1).mean(1)
        logits = {name: self.classify(features[name] + mean) for name in IMAGE_MODALITIES}
        return TrainingOutput(features=features, layers=layers, logits=logits, tokens=tokens)

    def _attend_in_training(
        self,
        name: str,
        parts: Tensor,
        labels: Tensor,
        token_on: Tensor | None,
        tokens: dict[str, Tensor],
        *,
        query: Tensor | None = None,
    ) -> Tensor:
        tokens[name] = expanded(parts, self.mffa.theta[name]).mean(1)
        token = None
        if self.settings.class_token:
            token = class_means(tokens[name], labels)
            if token_on is not None:
                agnostic = self.mffa.class_agnostic_token(name)
                token = torch.where(token_on[:, None], token, agnostic)
        return self.mffa.attend(name, parts, query=query, token=token).feature

    # ---- both --------------------------------------------------------------------------------

    def _scale(self) -> float:
        """Length given to a unit vector before the transform: √D, so that entries are near 1."""
        return 1.0 if self.settings.feature_scale == "literal" else self.settings.width**0.5

    def _embedded(self, name: str, raw: Tensor) -> Tensor:
        """Return an embedding (B, D) as the transform wants it: projected, of length √D."""
        lang = name == "lang"
        width = self.settings.lang_width if lang else self.settings.input_width
        if raw.ndim != 2 or raw.shape[1] != width:
            raise ShapeError(
                f"{name} has shape {tuple(raw.shape)}; this head wants (B, {width}). "
                "Use embeddings of the encoder that the head was trained with."
            )
        projected = (self.project_lang if lang else self.project_image)(raw.to(self.dtype))
        if self.settings.feature_scale == "literal":
            return projected  # type: ignore[no-any-return]
        return self._scale() * normalize(projected, dim=-1)


def class_means(values: Tensor, labels: Tensor) -> Tensor:
    """Return for each sample the mean over its class in the batch: (B, D), (B,) -> (B, D)."""
    same = (labels[:, None] == labels[None]).to(values.dtype)
    return same @ values / same.sum(1, keepdim=True)


def build_head(settings: HeadSettings, *, seed: int = 0) -> OmniVaT:
    """Return a head with fresh weights that depend on `seed` alone."""
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(seed)
        return OmniVaT(settings)


def parameter_count(settings: HeadSettings) -> int:
    """Return how many trainable numbers the head has, without making them."""
    with torch.device("meta"):
        head = OmniVaT(replace(settings, tree_init="default"))
    return sum(p.numel() for p in head.parameters() if p.requires_grad)
