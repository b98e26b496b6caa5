"""What every baseline gets and gives: one source domain in, a function that predicts out."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from typing import Protocol

import torch
from torch import Tensor
from torch.nn.functional import normalize

from omnivat.errors import DataError


class PromptTower(Protocol):
    """A text tower that takes learned vectors in the place of words."""

    @property
    def word_width(self) -> int:
        """W, the length of a word vector."""
        ...

    def words(self, text: str) -> Tensor:
        """Return the word vectors (T, W) of a text, without the marks at its ends."""
        ...

    def embed_contexts(self, contexts: Tensor, classes: Sequence[str]) -> Tensor:
        """Return text embeddings (B, K, D) of "CONTEXT CLASS." for contexts (B, T, W)."""
        ...


@dataclass(frozen=True, slots=True, kw_only=True)
class Source:
    """Training pairs of one domain. Nothing of any other domain is ever in here.

    vis, tac            (N, D) as the encoder gave them
    vis_flip, tac_flip  (N, D) of the mirrored images, or None
    labels              (N,) indices into classes
    objects             N names of the things touched: hold-outs keep them whole
    lang                (K, S, W) text embeddings of each class in S styles, or None
    why_no_lang         a sentence on why lang is None
    lang_of_images      whether the images' own encoder (its text tower) made `lang`
    plain               (K, D) text embeddings of "a photo of a CLASS.", or None
    logit_scale         what that encoder multiplies cosines by, or None where unknown
    prompts             loads the live text tower, for methods that learn prompts; None without one

    Raises DataError where an embedding is not finite.
    """

    vis: Tensor
    tac: Tensor
    labels: Tensor
    objects: tuple[str, ...]
    classes: tuple[str, ...]
    vis_flip: Tensor | None = None
    tac_flip: Tensor | None = None
    lang: Tensor | None = None
    lang_of_images: bool = False
    why_no_lang: str = ""
    plain: Tensor | None = None
    logit_scale: float | None = None
    prompts: "Callable[[], PromptTower] | None" = None
    seed: int = 0

    def __post_init__(self) -> None:
        for name in ("vis", "tac", "vis_flip", "tac_flip", "lang", "plain"):
            rows = getattr(self, name)
            if rows is not None and not rows.isfinite().all():
                raise DataError(
                    f"{name} has NaN or infinite values; a method can learn nothing from them. Embed "
                    "the pairs again."
                )

    def __len__(self) -> int:
        return len(self.labels)

    @property
    def width(self) -> int:
        """D, the encoder's width."""
        return self.vis.shape[1]

    def select(self, rows: Tensor) -> "Source":
        """Return some of the pairs, named by their indices (n,)."""
        return replace(
            self,
            vis=self.vis[rows],
            tac=self.tac[rows],
            labels=self.labels[rows],
            objects=tuple(self.objects[row] for row in rows.tolist()),
            vis_flip=None if self.vis_flip is None else self.vis_flip[rows],
            tac_flip=None if self.tac_flip is None else self.tac_flip[rows],
        )

    def both_views(self) -> "Source":
        """Return every pair twice, as it is and mirrored, where mirrored images are at hand."""
        if self.vis_flip is None or self.tac_flip is None:
            return self
        return replace(
            self,
            vis=torch.cat((self.vis, self.vis_flip)),
            tac=torch.cat((self.tac, self.tac_flip)),
            labels=torch.cat((self.labels, self.labels)),
            objects=self.objects * 2,
            vis_flip=None,
            tac_flip=None,
        )

    def drawn(self, rows: Tensor) -> tuple[Tensor, Tensor]:
        """Return VIS and TAC of the rows, each mirrored with probability a half."""
        return (
            _drawn(self.vis, self.vis_flip, rows),
            _drawn(self.tac, self.tac_flip, rows),
        )


def _drawn(plain: Tensor, flipped: Tensor | None, rows: Tensor) -> Tensor:
    if flipped is None:
        return plain[rows]
    mirror = torch.rand(len(rows), 1) < 0.5
    return torch.where(mirror, flipped[rows], plain[rows])


Predict = Callable[[Tensor, Tensor], dict[str, Tensor]]
Features = Callable[[Tensor, Tensor], dict[str, Tensor]]


def embeddings_themselves(vis: Tensor, tac: Tensor) -> dict[str, Tensor]:
    """Return unit embeddings by modality and side by side: the features of a method that has none."""
    unit = {"vis": normalize(vis, dim=-1), "tac": normalize(tac, dim=-1)}
    return {**unit, "pair": torch.cat((unit["vis"], unit["tac"]), dim=-1)}


@dataclass(frozen=True, slots=True, kw_only=True)
class Fitted:
    """A fitted method.

    predict     (vis (B, D), tac (B, D)) -> class probabilities (B, K): "fused" from both images, "vis"
                and "tac" from one alone, on which the other image has no influence
    features    (vis, tac) -> what is classified last, (B, W) each: "vis", "tac" and "pair"
    chosen      what source-side evidence chose, by name
    parameters  how many numbers were fitted
    """

    predict: Predict
    features: Features = embeddings_themselves
    chosen: dict[str, float | str] = field(default_factory=dict)
    parameters: int = 0


def fused(by_modality: dict[str, Tensor]) -> dict[str, Tensor]:
    """Add the mean of the modalities' probabilities (N, K) as "fused": late fusion."""
    return {"fused": torch.stack(list(by_modality.values())).mean(0), **by_modality}


def joined(vis: Tensor, tac: Tensor) -> dict[str, Tensor]:
    """Return features (B, W) by modality, and side by side at unit length as "pair"."""
    pair = torch.cat((normalize(vis, dim=-1), normalize(tac, dim=-1)), dim=-1)
    return {"vis": vis, "tac": tac, "pair": pair}


@contextmanager
def seeded(seed: int) -> Iterator[None]:
    """Draw from a stream of its own inside the block; the global stream is left as it was."""
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(seed)
        yield
