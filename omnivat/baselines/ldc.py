"""LDC: adapt and join features of four levels of the image tower, then de-confuse the logits.

Source: Li et al., Logits DeConfusion with CLIP for Few-Shot Learning, CVPR 2025; sizes, losses and rates
are those of its code. Its first part, the multi-level adapters, needs the live image tower. Its
second part, over pooled embeddings, is `ldc_icd`. Our changes: VIS and TAC count as images alike;
each class has one plain prompt instead of a list; images are mirrored, not cropped; a small source
gets at least 200 steps; the learned gate mixes the two kinds of logits, whereas the released code
searches for the mix, on the test set if there is no other.
"""

import math
from dataclasses import replace

import torch
from torch import Tensor, nn
from torch.nn.functional import cross_entropy, l1_loss, normalize

from omnivat.baselines.contract import Fitted, ImageInput, Live, Source, fused, joined, live_towers, seeded
from omnivat.baselines.descent import Descent, descend
from omnivat.baselines.mmrl import PROMPT
from omnivat.encoders.clip_live import LiveClip
from omnivat.seeding import derive_seed

WEIGHTS = (0.1, 0.2, 0.3, 0.4)  # of the levels
STEP, HIDDEN = 2, 2048  # layers between two levels; width of the head
# 32 pairs are the published batch of 64 images.
HOW = Descent(lr=1e-4, epochs=50, batch=32, weight_decay=1e-4, method="adam", warmup=0.0, eps=1e-4, clip=0.0)
LEAST = 200  # steps


class TokenLevels(nn.Module):
    """Adapters over the output tokens of every second one of a ViT's last layers."""

    def __init__(self, clip: LiveClip) -> None:
        super().__init__()
        width = clip.image.visual_projection.in_features
        last = len(clip.image_layers) - 1
        self.after = [max(0, last - STEP * back) for back in (3, 2, 1, 0)]
        self.adapters = nn.ModuleList(
            nn.Sequential(nn.Linear(width, width, bias=False), nn.LayerNorm(width), nn.ReLU()) for _ in WEIGHTS
        )

    def forward(self, clip: LiveClip, images: Tensor) -> tuple[Tensor, Tensor]:
        """Return CLIP's embeddings and the joined ones, (B, D) both."""
        with torch.no_grad():
            tokens, found = clip.image_tokens(images), []
            for layer in clip.image_layers:
                tokens = layer(tokens, None)
                found.append(tokens)
            plain = clip.image_end(tokens[:, 0])
        levels = [
            weight * adapter(found[number]).mean(1)
            for weight, adapter, number in zip(WEIGHTS, self.adapters, self.after, strict=True)
        ]
        joined_levels: Tensor = clip.image.visual_projection(torch.stack(levels).sum(0))
        return plain, joined_levels


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
        levels = [weight * adapter(maps) for weight, adapter, maps in zip(WEIGHTS, self.adapters, found, strict=True)]
        joined_levels: Tensor = clip.image.pool(torch.stack(levels).sum(0))
        return plain, joined_levels


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

    def forward(self, images: Tensor) -> dict[str, Tensor]:
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
        nn.Linear(width, hidden, bias=False), nn.BatchNorm1d(hidden), nn.ReLU(), nn.Linear(hidden, out, bias=False)
    )


def fit(source: Source) -> Fitted:
    """Learn adapters, head and de-confusion; rates and epochs as published.

    Raises DataError if the images or CLIP's live towers are not available.
    """
    live, clip, given = live_towers(source, "LDC")
    with seeded(derive_seed(source.seed, "ldc")):
        with torch.no_grad():
            texts = clip.embed_texts([PROMPT.format(name) for name in source.classes])
        model = DeConfused(clip, normalize(texts, dim=-1))
        _train(model, clip, source, live, given)
    model.requires_grad_(False)

    @torch.no_grad()
    def predict(vis: Tensor, tac: Tensor) -> dict[str, Tensor]:
        found = [model(images.to(clip.device))["mixed"].softmax(-1).cpu() for images in (vis, tac)]
        return fused({"vis": found[0], "tac": found[1]})

    @torch.no_grad()
    def features(vis: Tensor, tac: Tensor) -> dict[str, Tensor]:
        return joined(*(model(images.to(clip.device))["joined"].cpu() for images in (vis, tac)))

    return Fitted(
        predict=predict,
        features=features,
        parameters=sum(weight.numel() for weight in model.parameters()),
        images=given,
    )


def _train(model: DeConfused, clip: LiveClip, source: Source, live: Live, given: ImageInput) -> None:
    def loss(rows: Tensor) -> Tensor:
        found = model(live.drawn(rows, given).to(clip.device))
        labels = source.labels[rows].repeat(2).to(clip.device)
        right = [cross_entropy(found[name], labels) for name in ("own", "clear", "mixed")]
        near = [l1_loss(found[name], found["base"]) for name in ("own", "clear")]
        return torch.stack([*right, *near]).sum()

    epochs = max(HOW.epochs, math.ceil(LEAST / math.ceil(len(source) / HOW.batch)))
    descend(model, len(source), replace(HOW, epochs=epochs), loss)
