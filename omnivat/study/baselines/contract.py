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

if TYPE_CHECKING:
    from omnivat.encoders.clip_live import LiveClip
    from omnivat.encoders.lang.clip_prompts import ClipPrompts


@dataclass(frozen=True, slots=True, kw_only=True)
class ImageInput:
    """Image preprocessing: resize to `side` pixels, scale to 0..1, then (x - mean) / std."""

    side: int
    mean: tuple[float, ...]
    std: tuple[float, ...]

    def __call__(self, image: Image.Image) -> Tensor:
        """Return the image as (3, side, side)."""
        return pixels(image, self.mean, self.std, self.side)


@dataclass(frozen=True, slots=True, kw_only=True)
class Live:
    """The images of a source's embeddings, and the CLIP that made them."""

    read: Callable[[str, int], Image.Image]  # ("vis" or "tac", row among all pairs) -> an RGB image
    # returns the live towers; they are frozen and shared, and no method changes them
    load: "Callable[[], LiveClip]"
    rows: Tensor  # (N,) indices of these pairs among all pairs

    def images(self, name: str, rows: Tensor, image_input: ImageInput) -> Tensor:
        """Return the "vis" or "tac" images (B, 3, side, side) of the pairs `rows` (B,)."""
        return torch.stack([image_input(self.read(name, int(row))) for row in self.rows[rows]])

    def drawn(self, rows: Tensor, image_input: ImageInput) -> Tensor:
        """Return VIS, then TAC of the pairs (2 B, 3, side, side), each mirrored at random."""
        found = torch.cat([self.images(name, rows, image_input) for name in ("vis", "tac")])
        mirror = torch.rand(len(found), 1, 1, 1) < 0.5
        return torch.where(mirror, found.flip(-1), found)


def live_towers(source: "Source", what: str) -> "tuple[Live, LiveClip, ImageInput]":
    """Return a source's images, live towers and preprocessing. Raises DataError without them."""
    if source.live is None:
        raise DataError(
            f"{what} learns inside CLIP and needs the images and the checkpoint behind these"
            f" embeddings, which are not at hand. {source.why_not_live}".strip()
        )
    clip = source.live.load()
    return source.live, clip, input_of(clip)


def input_of(clip: "LiveClip") -> ImageInput:
    """Return the preprocessing of a live CLIP."""
    return ImageInput(side=clip.side, mean=clip.mean, std=clip.std)


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
    def images(self) -> dict[str, Tensor]:
        """VIS and TAC (N, D) by name."""
        return {"vis": self.vis, "tac": self.tac}

    def select(self, rows: Tensor) -> "Source":
        """Return the pairs with these indices (n,)."""
        names = ("vis", "tac", "labels", "vis_flip", "tac_flip")
        own: dict[str, Any] = {
            n: found[rows] for n in names if (found := getattr(self, n)) is not None
        }
        if self.live is not None:
            own["live"] = replace(self.live, rows=self.live.rows[rows])
        return replace(self, objects=tuple(self.objects[row] for row in rows.tolist()), **own)

    def both_views(self) -> "Source":
        """Return every pair, then its mirrored copy if mirrored images are available.

        With noise: `COPIES` noisy copies of each in its place.
        """
        vis, tac = [self.vis], [self.tac]
        if self.vis_flip is not None and self.tac_flip is not None:
            vis, tac = [self.vis, self.vis_flip], [self.tac, self.tac_flip]
        if self.noise:
            with seeded(self.seed):
                vis = [self._noisy(rows, self.vis) for rows in vis * COPIES]
                tac = [self._noisy(rows, self.tac) for rows in tac * COPIES]
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
        return self._drawn(self.vis, self.vis_flip, rows), self._drawn(
            self.tac, self.tac_flip, rows
        )

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


Predict = Callable[[Tensor, Tensor], dict[str, Tensor]]


def embeddings_themselves(vis: Tensor, tac: Tensor) -> dict[str, Tensor]:
    """Return unit embeddings by modality and concatenated, for methods without features."""
    seen, felt = normalize(vis, dim=-1), normalize(tac, dim=-1)
    return {"vis": seen, "tac": felt, "pair": torch.cat((seen, felt), dim=-1)}


@dataclass(frozen=True, slots=True, kw_only=True)
class Fitted:
    """A fitted method: functions of VIS and TAC, (B, D) each.

    predict  class probabilities (B, K): "fused" from both images, "vis" and "tac" from one alone,
             independent of the other image
    images   preprocessing, for a method that learned inside the image tower: both functions then
             take images (B, 3, side, side)
    """

    predict: Predict
    # the last ones before classification, (B, W): "vis", "tac", "pair"
    features: Predict = embeddings_themselves
    # settings chosen by source-side evidence, by name
    chosen: dict[str, float | str] = field(default_factory=dict)
    parameters: int = 0  # how many were fitted
    images: ImageInput | None = None


def late(alone: Callable[[str, Tensor], Tensor]) -> Predict:
    """Return the method that predicts one modality by `alone`, and both by the mean: late fusion.

    alone  ("vis" or "tac", rows (B, D)) -> probabilities (B, K)
    """

    def predict(vis: Tensor, tac: Tensor) -> dict[str, Tensor]:
        seen, felt = alone("vis", vis), alone("tac", tac)
        return {"fused": torch.stack((seen, felt)).mean(0), "vis": seen, "tac": felt}

    return predict


def sized(rows: Tensor) -> Tensor:
    """Return rows (B, D) at length √D, so that an entry is about 1: the input of a network."""
    return normalize(rows, dim=-1) * math.sqrt(rows.shape[1])


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
