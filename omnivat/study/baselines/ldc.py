"""LDC: adapt and join features of four levels of the image tower, then de-confuse the logits.

Source: Li et al., Logits DeConfusion with CLIP for Few-Shot Learning, CVPR 2025; sizes, losses and
rates are those of its code. Its first part, the multi-level adapters, needs the live image tower.
Our changes: VIS and TAC count as images alike; each class has one plain prompt instead of a list;
images are mirrored, not cropped; a small source gets at least 200 steps; the learned gate mixes the
two kinds of logits, whereas the released code searches for the mix, on the test set if there is no
other.

LDC-ICD is the logit part only, over pooled embeddings, which lack inner tokens: the feature is the
embedding. Its network is ours besides: logits and feature are concatenated where the published one
adds two perceptrons, the estimate is subtracted, each class has a gate of its own, layers have
biases and no BatchNorm, and gradients are clipped at 5.
"""

import math
from dataclasses import replace

import torch
from torch import Tensor, nn
from torch.nn.functional import cross_entropy, l1_loss, normalize

from omnivat.encoders.clip_live import LiveClip
from omnivat.kit.stages import IMAGES
from omnivat.study.baselines.contract import Fitted, Rows, Source, joined, late, live_towers, sized
from omnivat.study.baselines.descent import Descent, learned, size
from omnivat.study.baselines.evidence import best
from omnivat.study.baselines.mmrl import PROMPT
from omnivat.study.baselines.nearest_mean import class_directions

WEIGHTS = (0.1, 0.2, 0.3, 0.4)  # of the levels
STEP, HIDDEN = 2, 2048  # layers between two levels; width of the head
# 32 pairs are the published batch of 64 images.
HOW = Descent(
    lr=1e-4, epochs=50, batch=32, weight_decay=1e-4, method="adam", warmup=0.0, eps=1e-4, clip=0.0
)
LEAST = 200  # steps
OF_ROWS = 512  # hidden width of LDC-ICD
CANDIDATES = {
    f"lr {lr:g}, scale {scale:g}": (lr, scale) for lr in (1e-4, 1e-3) for scale in (10.0, 30.0)
}


class TokenLevels(nn.Module):
    """Adapters over the output tokens of every second one of a ViT's last layers."""

    def __init__(self, clip: LiveClip) -> None:
        super().__init__()
        width = clip.image.visual_projection.in_features
        last = len(clip.image_layers) - 1
        self.after = [max(0, last - STEP * back) for back in (3, 2, 1, 0)]
        self.adapters = nn.ModuleList(
            nn.Sequential(nn.Linear(width, width, bias=False), nn.LayerNorm(width), nn.ReLU())
            for _ in WEIGHTS
        )

    def forward(self, clip: LiveClip, images: Tensor) -> tuple[Tensor, Tensor]:
        """Return CLIP's embeddings and the joined ones, (B, D) both."""
        with torch.no_grad():
            found = [clip.image_tokens(images)]
            for layer in clip.image_layers:
                found.append(layer(found[-1], None))
            plain = clip.image_end(found[-1][:, 0])
        levels = [
            weight * adapter(found[number + 1]).mean(1)
            for weight, adapter, number in zip(WEIGHTS, self.adapters, self.after, strict=True)
        ]
        return plain, clip.image.visual_projection(torch.stack(levels).sum(0))


class MapLevels(nn.Module):
    """Adapters over the output maps of a ResNet's four stages."""

    def __init__(self, clip: LiveClip) -> None:
        super().__init__()
        widths = [stage[-1].widen.weight.shape[0] for stage in clip.image.stages]
        self.adapters = nn.ModuleList(
            nn.Sequential(
                nn.Conv2d(width, widths[-1], 1, bias=False),
                nn.BatchNorm2d(widths[-1]),
                nn.ReLU(),
                nn.AvgPool2d(2**back),
            )
            for width, back in zip(widths, (3, 2, 1, 0), strict=True)
        )

    def forward(self, clip: LiveClip, images: Tensor) -> tuple[Tensor, Tensor]:
        """Return CLIP's embeddings and the joined ones, (B, D) both."""
        with torch.no_grad():
            found = clip.image.levels(images)
            plain = clip.image.pool(found[-1])
        levels = [
            weight * adapter(maps)
            for weight, adapter, maps in zip(WEIGHTS, self.adapters, found, strict=True)
        ]
        return plain, clip.image.pool(torch.stack(levels).sum(0))


class DeConfused(nn.Module):
    """The adapters of all levels, a head over them, and CLIP's de-confused logits."""

    def __init__(self, clip: LiveClip, texts: Tensor) -> None:
        super().__init__()
        self._towers = (clip,)  # in a tuple, so that it is not a submodule
        width, classes = clip.width, len(texts)
        self.texts: Tensor
        self.register_buffer("texts", texts)
        self.levels = TokenLevels(clip) if clip.is_vit else MapLevels(clip)
        self.head = _perceptron(width, HIDDEN if clip.is_vit else width, classes)
        self.of_logits = _perceptron(classes, width, width)
        self.of_image = _perceptron(width, width, width)
        self.confusion = _perceptron(width, width, classes)
        self.gate = _perceptron(width, width, 1)
        self.to(clip.device)

    def forward(self, images: Tensor) -> Rows:
        """Return "base", "own", "clear" and "mixed" logits (B, K), and "joined" features (B, D)."""
        (clip,) = self._towers
        plain, levels = self.levels(clip, images)
        base = clip.logit_scale * normalize(plain, dim=-1) @ self.texts.T
        own = self.head(levels)
        clear = base + self.confusion(self.of_logits(base) + self.of_image(levels))
        gate = self.gate(levels).sigmoid()
        mixed = gate * own + (1 - gate) * clear
        return {"base": base, "own": own, "clear": clear, "mixed": mixed, "joined": levels}


def _perceptron(width: int, hidden: int, out: int) -> nn.Sequential:
    return nn.Sequential(
        nn.Linear(width, hidden, bias=False),
        nn.BatchNorm1d(hidden),
        nn.ReLU(),
        nn.Linear(hidden, out, bias=False),
    )


def fit(source: Source) -> Fitted:
    """Learn adapters, head and de-confusion; rates and epochs as published.

    Raises DataError if the images or CLIP's live towers are not available.
    """
    live, clip = live_towers(source, "LDC")
    with torch.no_grad():
        texts = normalize(
            clip.embed_texts([PROMPT.format(name) for name in source.classes]), dim=-1
        )

    def loss(model: DeConfused, rows: Tensor) -> Tensor:
        outputs = model(live.drawn(rows).to(clip.device))
        labels = source.labels[rows].repeat(2).to(clip.device)
        right = [cross_entropy(outputs[name], labels) for name in ("own", "clear", "mixed")]
        near = [l1_loss(outputs[name], outputs["base"]) for name in ("own", "clear")]
        return torch.stack([*right, *near]).sum()

    epochs = max(HOW.epochs, math.ceil(LEAST / math.ceil(len(source) / HOW.batch)))
    model = learned(
        source, lambda: DeConfused(clip, texts), replace(HOW, epochs=epochs), loss, "ldc"
    )

    @torch.no_grad()
    def output(name: str, images: Tensor) -> Tensor:
        rows: Tensor = model(images.to(clip.device))[name]
        return rows

    return Fitted(
        predict=late(lambda _, images: output("mixed", images).softmax(-1).cpu()),
        features=lambda vis, tac: joined(output("joined", vis).cpu(), output("joined", tac).cpu()),
        parameters=size(model),
        images=True,
    )


class PooledDeConfusion(nn.Module):
    """An MLP's logits, base logits without estimated confusion, and a gated mix; one for VIS and
    TAC.
    """

    def __init__(self, source: Source, scale: float) -> None:
        super().__init__()
        self.scale, self.prototypes = scale, _prototypes(source)
        width, classes = source.width, len(source.classes)
        self.head = nn.Sequential(nn.Linear(width, OF_ROWS), nn.ReLU(), nn.Linear(OF_ROWS, classes))
        self.confusion = nn.Sequential(
            nn.Linear(width + classes, OF_ROWS), nn.ReLU(), nn.Linear(OF_ROWS, classes)
        )
        self.gate = nn.Linear(width, classes)

    def forward(self, name: str, rows: Tensor) -> tuple[Tensor, Tensor, Tensor, Tensor]:
        """Return the base, the MLP's, the corrected and the mixed logits (B, K) of a modality."""
        base = self.scale * normalize(rows, dim=-1) @ self.prototypes[name].T
        rows = sized(rows)
        own = self.head(rows)
        clear = base - self.confusion(torch.cat((rows, base), dim=-1))
        gate = self.gate(rows).sigmoid()
        return base, own, clear, gate * own + (1 - gate) * clear


def _prototypes(source: Source) -> Rows:
    if source.lang is not None and source.lang_of_images:
        texts = normalize(normalize(source.lang, dim=-1).mean(1), dim=-1)
        return {"vis": texts, "tac": texts}
    full = source.both_views()
    return {
        n: class_directions(rows, full.labels, len(full.classes)) for n, rows in full.images.items()
    }


def fit_icd(source: Source) -> Fitted:
    """Train with AdamW; held-out objects choose learning rate and scale of the base logits."""
    chosen = best(source, CANDIDATES, _fitted_icd, repeats=1)
    return replace(_fitted_icd(source, CANDIDATES[chosen]), chosen={"training": chosen})


def _fitted_icd(source: Source, choice: tuple[float, float]) -> Fitted:
    def loss(model: PooledDeConfusion, rows: Tensor) -> Tensor:
        """Return the sum of three cross-entropies and two distances to the base logits for each
        modality, each of weight 1.
        """
        labels, total = source.labels[rows], torch.zeros(())
        for name, images in zip(IMAGES, source.drawn(rows), strict=True):
            base, *found = model(name, images)
            right = [cross_entropy(logits, labels) for logits in found]
            total = (
                total
                + torch.stack([*right, *(l1_loss(logits, base) for logits in found[:2])]).sum()
            )
        return total

    how = Descent(lr=choice[0], epochs=30, batch=64, weight_decay=1e-4, method="adam")
    model = learned(source, lambda: PooledDeConfusion(source, choice[1]), how, loss, "ldc-icd")
    return Fitted(
        predict=late(lambda name, rows: model(name, rows)[3].softmax(-1)), parameters=size(model)
    )
