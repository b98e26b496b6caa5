"""The OmniVaT head: from frozen embeddings to class probabilities and all stages."""

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from typing import Any

import torch
from jaxtyping import Float
from torch import Tensor
from torch.nn.functional import linear

from omnivat.fractional import Coefficients, coefficients, synthesise
from omnivat.head.body import Body
from omnivat.head.dtg import grow
from omnivat.head.folded import FoldedMFFA, Folds, fold_mffa
from omnivat.head.output import HeadOutput, Lessons, joined
from omnivat.head.settings import HeadSettings
from omnivat.kit.errors import ShapeError
from omnivat.kit.shapes import floating
from omnivat.kit.threads import FEW_PAIRS, one_thread

CHUNK = 512  # pairs predicted at once


@dataclass(frozen=True, slots=True)
class PairCoefficients:
    """Eigenbasis coefficients of B pairs; they do not depend on p."""

    names: tuple[str, ...]  # of the M modalities
    stacked: Coefficients  # values "M B D"
    maps: dict[str, Float[Tensor, "B K"]] = field(default_factory=dict)  # see `Body.map_logits`
    lessons: Lessons | None = None

    def __getitem__(self, pairs: Any) -> "PairCoefficients":
        """Return the coefficients of some pairs: a slice, a mask or indices."""
        maps = {name: rows[pairs] for name, rows in self.maps.items()}
        lessons = self.lessons[pairs] if self.lessons else None
        return PairCoefficients(self.names, self.stacked[:, pairs], maps, lessons)

    def __len__(self) -> int:
        return self.stacked.shape[1]


class OmniVaT(Body):
    """MFFA, then DTG, then one cosine classifier shared by VIS and TAC.

    A call with VIS and TAC embeddings predicts. LANG is used only in `omnivat.head.training`.
    The prediction for a pair does not depend on the other pairs of its batch.
    Source: paper, Fig. 2; docs/method.md lists the choices that the paper leaves open.

    >>> head = build_head(HeadSettings(classes=("wood", "steel"), input_width=8, width=16))
    >>> vis, tac = torch.randn(2, 5, 8)
    >>> tuple(head(vis, tac).probabilities.shape), tuple(head(vis, None).f_hat["vis"].shape)
    ((5, 2), (5, 16))
    >>> kept = head.coefficients(vis, tac)  # once; then each order is one product
    >>> [tuple(head.from_coefficients(kept, p).probabilities.shape) for p in (0.2, 0.8)]
    [(5, 2), (5, 2)]
    """

    def __init__(self, settings: HeadSettings) -> None:
        super().__init__(settings)
        self._folds = Folds()

    def forward(
        self,
        vis: Float[Tensor, "B W"] | None,
        tac: Float[Tensor, "B W"] | None,
        *,
        order: float | Float[Tensor, "..."] | None = None,
        nodes: bool = False,
        attention: bool = False,
    ) -> HeadOutput:
        """Predict from raw embeddings of B pairs; see `coefficients` and `from_coefficients`."""
        vis, tac = (e if e is None else floating(n, e) for n, e in (("vis", vis), ("tac", tac)))
        few = all(rows.shape[:1] <= (FEW_PAIRS,) for rows in (vis, tac) if rows is not None)
        with one_thread(few):
            kept = self.coefficients(vis, tac)
            return self.from_coefficients(kept, order, nodes=nodes, attention=attention)

    def coefficients(
        self, vis: Float[Tensor, "_ _"] | None, tac: Float[Tensor, "_ _"] | None
    ) -> PairCoefficients:
        """Return the coefficients of B pairs; keep them to change p. One image may be None.

        Raises DataError if both are missing, ShapeError for a wrong width or unequal B.
        """
        given = {n: e for n, e in (("vis", vis), ("tac", tac)) if e is not None}
        kept = coefficients(self.embedded(given))
        return PairCoefficients(tuple(given), kept, self.map_logits(given), self.lessons(given))

    def from_coefficients(
        self,
        kept: PairCoefficients,
        order: float | Float[Tensor, "..."] | None = None,
        *,
        nodes: bool = False,
        attention: bool = False,
    ) -> HeadOutput:
        """Predict at one order, or at one order for each pair.

        kept       from `coefficients`
        order      quarter turns: a number, or one for each pair; None: the learned one
        nodes      also return the tree's nodes
        attention  also return attention weights

        Weights are folded, once for all calls without gradients, and pairs go in chunks that fit
        the processor's cache.
        """
        names, stacked = kept.names, kept.stacked
        order = self.mffa.orders(names) if order is None else order
        self._folds.refresh(self)
        outputs = []
        with one_thread(len(kept) <= FEW_PAIRS):
            for start in range(0, max(1, len(kept)), CHUNK):
                rows = slice(start, start + CHUNK)
                some, embedding = stacked[:, rows], None
                parts = synthesise(some, _rows(order, rows), planar=True)
                if not self.settings.mffa:
                    embedding = synthesise(some, 0.0, planar=True)[0]
                outputs.append(
                    self.output(names, parts, embedding, nodes=nodes, attention=attention)
                )
        whole = outputs[0] if len(outputs) == 1 else joined(outputs)
        return replace(whole, maps=kept.maps, lessons=kept.lessons)

    def output(
        self,
        names: tuple[str, ...],
        parts: Float[Tensor, "2 M B D"],
        embedding: Float[Tensor, "M B D"] | None,
        *,
        nodes: bool,
        attention: bool,
    ) -> HeadOutput:
        """Predict from transformed embeddings.

        parts      Re and Im
        embedding  before the transform; only a head without MFFA needs it
        """
        weights: Tensor | None = None
        if not self.settings.mffa:
            assert embedding is not None, "without MFFA the tree grows from the embeddings"
            relu, bars = torch.relu(parts), embedding / self.length
        else:
            folded: FoldedMFFA = self._folds.get(names, lambda: fold_mffa(self.mffa, names))
            bars, relu, weights = folded.features(self.mffa.channels(parts))
        root = bars.sum(0)
        alone = f_hat = bars + self._mean(bars, root)
        if len(names) > 1:  # T is then the F-bar of each
            alone = bars + torch.stack([self._mean(bar[None], bar) for bar in bars])
        directions = self._folds.get(("directions",), self.directions)
        logits = self.classify(torch.stack((f_hat, alone)), directions)
        grown = grow(self.dtg, self.settings, bars, root) if nodes else None
        if len(relu) == 1:  # |F| or Re F alone: there is no imaginary part
            relu = torch.cat((relu, torch.zeros_like(relu)))

        def by_name(rows: Iterable[Tensor]) -> dict[str, Tensor]:
            return dict(zip(names, rows, strict=True))

        return HeadOutput(
            logits=by_name(logits[0]),
            alone=by_name(logits[1]),
            pair=self.classify(f_hat.sum(0), directions),
            fusion=self.settings.fusion,
            temperatures=self.temperatures,
            frft=by_name(parts.unbind(1)),
            relu=by_name(relu.unbind(1)),
            f_bar=by_name(bars),
            f_hat=by_name(f_hat),
            attention=by_name(weights) if attention and weights is not None else {},
            nodes=grown and grown.nodes,
        )

    def _mean(
        self, features: Float[Tensor, "M B D"], root: Float[Tensor, "B D"]
    ) -> Float[Tensor, "B D"]:
        """Return the mean over the nodes that grow from the features; zeros without any."""
        if not self.settings.tree_at_inference or self.settings.generation == "none":
            return torch.zeros_like(root)
        if self.settings.generation == "interpolation":
            return root / len(features)  # points are evenly spaced between the features
        return linear(root, *self._folds.get(("tree",), self.dtg.fold))


def _rows(order: float | Tensor, rows: slice) -> float | Tensor:
    """Return the orders of some pairs; a single order serves all. Raises ShapeError."""
    if isinstance(order, Tensor) and order.ndim > 2:  # (M, 1): one a modality
        raise ShapeError(f"The order has {order.ndim} axes; give one, or one a pair, (B,).")
    return (
        order[rows] if isinstance(order, Tensor) and order.ndim == 1 and len(order) > 1 else order
    )


def build_head(settings: HeadSettings, *, seed: int = 0) -> OmniVaT:
    """Return a head with initial weights; they depend on `seed` only."""
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(seed)
        return OmniVaT(settings)


def parameter_count(settings: HeadSettings) -> int:
    """Return the number of trainable parameters, without allocating them."""
    with torch.device("meta"):
        head = OmniVaT(settings)
    return sum(p.numel() for p in head.parameters() if p.requires_grad)
