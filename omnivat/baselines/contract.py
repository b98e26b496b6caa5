"""What every baseline gets and gives: one source domain in, a function that predicts out."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace

import torch
from torch import Tensor


@dataclass(frozen=True, slots=True, kw_only=True)
class Source:
    """Training pairs of one domain. Nothing of any other domain is ever in here.

    vis, tac            (N, D) as the encoder gave them
    vis_flip, tac_flip  (N, D) of the mirrored images, or None
    labels              (N,) indices into classes
    objects             N names of the things touched: hold-outs keep them whole
    lang                (K, S, W) text embeddings of each class in S styles, or None
    lang_of_images      whether the images' own encoder (its text tower) made `lang`
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
    seed: int = 0

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


@dataclass(frozen=True, slots=True, kw_only=True)
class Fitted:
    """A fitted method.

    predict     (vis (B, D), tac (B, D)) -> "fused" and, where the method has them, "vis" and
                "tac": class probabilities (B, K)
    chosen      what source-side evidence chose, by name
    parameters  how many numbers were fitted
    """

    predict: Predict
    chosen: dict[str, float | str] = field(default_factory=dict)
    parameters: int = 0


def fused(by_modality: dict[str, Tensor]) -> dict[str, Tensor]:
    """Add the mean of the modalities' probabilities (N, K) as "fused"."""
    return {"fused": torch.stack(list(by_modality.values())).mean(0), **by_modality}


@contextmanager
def seeded(seed: int) -> Iterator[None]:
    """Draw from a stream of its own inside the block; the global stream is left as it was."""
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(seed)
        yield
