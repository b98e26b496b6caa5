"""Input and output of every baseline: one source domain in, a prediction function out."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from typing import Protocol

import torch
from torch import Tensor
from torch.nn.functional import normalize

from omnivat.baselines.live import ImageInput, Live
from omnivat.errors import DataError


class PromptTower(Protocol):
    """A text tower that accepts learned vectors instead of words."""

    @property
    def word_width(self) -> int:
        """W, the length of a word vector."""
        ...

    def words(self, text: str) -> Tensor:
        """Return the word vectors (T, W) of a text, without start and end tokens."""
        ...

    def embed_contexts(self, contexts: Tensor, classes: Sequence[str]) -> Tensor:
        """Return text embeddings (B, K, D) of "CONTEXT CLASS." for contexts (B, T, W)."""
        ...


@dataclass(frozen=True, slots=True, kw_only=True)
class Source:
    """Training pairs of one domain. It contains nothing of any other domain.

    vis, tac            (N, D) from the encoder
    vis_flip, tac_flip  (N, D) of the mirrored images, or None
    labels              (N,) indices into classes
    objects             N names of the touched objects; hold-outs never split an object
    lang                (K, S, W) text embeddings of each class in S styles, or None
    why_no_lang         the reason, if lang is None
    lang_of_images      True if the text tower of the image encoder made `lang`
    plain               (K, D) text embeddings of "a photo of a CLASS.", or None
    logit_scale         that encoder's factor of cosines, or None if unknown
    prompts             loads the live text tower, for methods that learn prompts; None without one
    live                images and live towers, for methods that learn inside them; or None
    why_not_live        the reason, if live is None

    Raises DataError if an embedding is not finite.
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
    live: Live | None = None
    why_not_live: str = ""
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
        """Return the pairs with these indices (n,)."""
        return replace(
            self,
            vis=self.vis[rows],
            tac=self.tac[rows],
            labels=self.labels[rows],
            objects=tuple(self.objects[row] for row in rows.tolist()),
            vis_flip=None if self.vis_flip is None else self.vis_flip[rows],
            tac_flip=None if self.tac_flip is None else self.tac_flip[rows],
            live=None if self.live is None else self.live.select(rows),
        )

    def both_views(self) -> "Source":
        """Return every pair, then its mirrored copy if mirrored images are available."""
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
            live=None,
        )

    def drawn(self, rows: Tensor) -> tuple[Tensor, Tensor]:
        """Return VIS and TAC of the rows, each mirrored with probability 1/2."""
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
    """Return unit embeddings by modality and concatenated, for methods without features."""
    unit = {"vis": normalize(vis, dim=-1), "tac": normalize(tac, dim=-1)}
    return {**unit, "pair": torch.cat((unit["vis"], unit["tac"]), dim=-1)}


@dataclass(frozen=True, slots=True, kw_only=True)
class Fitted:
    """A fitted method.

    predict     (vis (B, D), tac (B, D)) -> class probabilities (B, K): "fused" from both images,
                "vis" and "tac" from one alone, independent of the other image
    features    (vis, tac) -> the last features before classification, (B, W): "vis", "tac", "pair"
    chosen      settings chosen by source-side evidence, by name
    parameters  number of fitted parameters
    images      image preprocessing, for a method that learned inside the image tower: predict and
                features then take images (B, 3, side, side) instead of embeddings; else None
    """

    predict: Predict
    features: Features = embeddings_themselves
    chosen: dict[str, float | str] = field(default_factory=dict)
    parameters: int = 0
    images: ImageInput | None = None


def fused(by_modality: dict[str, Tensor]) -> dict[str, Tensor]:
    """Add the mean of the modalities' probabilities (N, K) as "fused": late fusion."""
    return {"fused": torch.stack(list(by_modality.values())).mean(0), **by_modality}


def joined(vis: Tensor, tac: Tensor) -> dict[str, Tensor]:
    """Return features (B, W) by modality, and concatenated at unit length as "pair"."""
    pair = torch.cat((normalize(vis, dim=-1), normalize(tac, dim=-1)), dim=-1)
    return {"vis": vis, "tac": tac, "pair": pair}


@contextmanager
def seeded(seed: int) -> Iterator[None]:
    """Use a separate random stream inside the block; the global stream does not change."""
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(seed)
        yield
