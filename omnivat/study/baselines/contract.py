"""Input and output of every baseline: one source domain in, a prediction function out."""

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import torch
from PIL import Image
from torch import Tensor
from torch.nn.functional import normalize

from omnivat.encoders.running import pixels
from omnivat.kit.errors import DataError
from omnivat.kit.stages import IMAGES

if TYPE_CHECKING:
    from omnivat.encoders.clip_live import LiveClip
    from omnivat.encoders.lang.clip_prompts import ClipPrompts


Rows = dict[str, Tensor]  # by modality or reading
Predict = Callable[[Tensor, Tensor], Rows]


@dataclass(frozen=True, slots=True, kw_only=True)
class Live:
    """The images of a source's embeddings, and the CLIP that made them."""

    read: Callable[[str, int], Image.Image]  # ("vis" or "tac", row among all pairs) -> an RGB image
    # returns the live towers; they are frozen and shared, and no method changes them
    load: "Callable[[], LiveClip]"
    rows: Tensor  # (N,) indices of these pairs among all pairs

    def images(self, name: str, rows: Tensor) -> Tensor:
        """Return the "vis" or "tac" images (B, 3, side, side) of the pairs `rows` (B,)."""
        clip = self.load()
        pictures = (self.read(name, row) for row in self.rows[rows].tolist())
        return torch.stack(
            [pixels(picture, clip.mean, clip.std, clip.side) for picture in pictures]
        )

    def drawn(self, rows: Tensor) -> Tensor:
        """Return VIS, then TAC of the pairs (2 B, 3, side, side), each mirrored at random."""
        images = torch.cat([self.images(name, rows) for name in IMAGES])
        mirror = torch.rand(len(images), 1, 1, 1) < 0.5
        return torch.where(mirror, images.flip(-1), images)


def live_towers(source: "Source", what: str) -> "tuple[Live, LiveClip]":
    """Return a source's images and live towers. Raises DataError without them."""
    if source.live is None:
        raise DataError(
            f"{what} learns inside CLIP and needs the images and the checkpoint behind these"
            f" embeddings, which are not at hand. {source.why_not_live}".strip()
        )
    return source.live, source.live.load()


COPIES = 4  # of each image with noise, for methods that are solved


@dataclass(frozen=True, slots=True, kw_only=True)
class Source:
    """Training pairs of one domain. It contains nothing of any other domain.

    Raises DataError if an embedding is not finite.
    """

    vis: Tensor  # (N, D) from the encoder, and so is tac
    tac: Tensor
    labels: Tensor  # (N,) indices into classes
    objects: tuple[str, ...]  # N names of the touched objects; hold-outs never split an object
    classes: tuple[str, ...]
    vis_flip: Tensor | None = None  # (N, D) of the mirrored images, if there are any
    tac_flip: Tensor | None = None
    lang: Tensor | None = None  # (K, S, W) text embeddings of each class in S styles
    lang_of_images: bool = False  # True if the text tower of the image encoder made `lang`
    why_no_lang: str = ""  # the reason, if lang is None
    plain: Tensor | None = None  # (K, D) text embeddings of "a photo of a CLASS."
    logit_scale: float | None = None  # that encoder's factor of cosines, if known
    # loads the live text tower, to learn prompts
    prompts: "Callable[[], ClipPrompts] | None" = None
    live: Live | None = None  # images and live towers, to learn inside them
    why_not_live: str = ""  # the reason, if live is None
    seed: int = 0
    noise: float = 0.0  # white noise in training, in standard deviations of each channel
    epochs: int = 0  # of a method trained by gradient steps; 0: its own
    settled: tuple[str, ...] = ()  # names of candidates that another seed chose on this source

    def __post_init__(self) -> None:
        for name in ("vis", "tac", "vis_flip", "tac_flip", "lang", "plain"):
            rows = getattr(self, name)
            if rows is not None and not rows.isfinite().all():
                raise DataError(
                    f"{name} has NaN or infinite values; a method can learn nothing from them."
                    " Embed the pairs again."
                )

    def __len__(self) -> int:
        return len(self.labels)

    @property
    def width(self) -> int:
        """D, the encoder's width."""
        return self.vis.shape[1]

    @property
    def images(self) -> Rows:
        """VIS and TAC (N, D) by name."""
        return {"vis": self.vis, "tac": self.tac}

    def select(self, rows: Tensor) -> "Source":
        """Return the pairs with these indices (n,)."""
        names = ("vis", "tac", "labels", "vis_flip", "tac_flip")
        own: dict[str, Any] = {
            name: values[rows] for name in names if (values := getattr(self, name)) is not None
        }
        if self.live is not None:
            own["live"] = replace(self.live, rows=self.live.rows[rows])
        return replace(self, objects=tuple(self.objects[row] for row in rows.tolist()), **own)

    def both_views(self) -> "Source":
        """Return every pair, then its mirrored copy if mirrored images are available.

        With noise: `COPIES` noisy copies of each in its place.
        """
        copies = COPIES if self.noise else 1
        with seeded(self.seed):
            vis, tac = (
                [self._noisy(rows, plain) for rows in (plain, flipped) * copies if rows is not None]
                for plain, flipped in ((self.vis, self.vis_flip), (self.tac, self.tac_flip))
            )
        return replace(
            self,
            vis=torch.cat(vis),
            tac=torch.cat(tac),
            labels=self.labels.repeat(len(vis)),
            objects=self.objects * len(vis),
            vis_flip=None,
            tac_flip=None,
            live=None,
            noise=0.0,
        )

    def drawn(self, rows: Tensor) -> tuple[Tensor, Tensor]:
        """Return VIS and TAC of the rows, each mirrored with probability 1/2, then with noise."""
        vis = self._drawn(self.vis, self.vis_flip, rows)
        return vis, self._drawn(self.tac, self.tac_flip, rows)

    def _drawn(self, plain: Tensor, flipped: Tensor | None, rows: Tensor) -> Tensor:
        if flipped is None:
            return self._noisy(plain[rows], plain)
        mirror = torch.rand(len(rows), 1) < 0.5
        return self._noisy(torch.where(mirror, flipped[rows], plain[rows]), plain)

    def _noisy(self, rows: Tensor, every: Tensor) -> Tensor:
        """Return rows (B, D) with noise in the standard deviations of all rows (N, D)."""
        if not self.noise:
            return rows
        return rows + self.noise * every.std(0, correction=0) * torch.randn_like(rows)


def embeddings_themselves(vis: Tensor, tac: Tensor) -> Rows:
    """Return unit embeddings by modality and concatenated, for methods without features."""
    seen, felt = normalize(vis, dim=-1), normalize(tac, dim=-1)
    return {"vis": seen, "tac": felt, "pair": torch.cat((seen, felt), dim=-1)}


@dataclass(frozen=True, slots=True, kw_only=True)
class Fitted:
    """A fitted method: functions of VIS and TAC, (B, D) each.

    predict  class probabilities (B, K): "fused" from both images, "vis" and "tac" from one alone,
             independent of the other image
    images   True for a method that learned inside the image tower: both functions then take images
             (B, 3, side, side)
    """

    predict: Predict
    # the last ones before classification, (B, W): "vis", "tac", "pair"
    features: Predict = embeddings_themselves
    # settings chosen by source-side evidence, by name
    chosen: dict[str, float | str] = field(default_factory=dict)
    parameters: int = 0  # how many were fitted
    images: bool = False


def late(alone: Callable[[str, Tensor], Tensor]) -> Predict:
    """Return the method that predicts one modality by `alone`, and both by the mean: late fusion.

    alone  ("vis" or "tac", rows (B, D)) -> probabilities (B, K)
    """

    def predict(vis: Tensor, tac: Tensor) -> Rows:
        seen, felt = alone("vis", vis), alone("tac", tac)
        return {"fused": torch.stack((seen, felt)).mean(0), "vis": seen, "tac": felt}

    return predict


def sized(rows: Tensor) -> Tensor:
    """Return rows (B, D) at length √D, so that an entry is about 1: the input of a network."""
    return normalize(rows, dim=-1) * math.sqrt(rows.shape[1])


def joined(vis: Tensor, tac: Tensor) -> Rows:
    """Return features (B, W) by modality, and concatenated at unit length as "pair"."""
    pair = torch.cat((normalize(vis, dim=-1), normalize(tac, dim=-1)), dim=-1)
    return {"vis": vis, "tac": tac, "pair": pair}


@contextmanager
def seeded(seed: int) -> Iterator[None]:
    """Use a separate random stream inside the block; the global stream does not change."""
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(seed)
        yield
