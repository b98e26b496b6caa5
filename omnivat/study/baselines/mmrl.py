"""MMRL: learn shared tokens inside the upper layers of both towers.

For each upper layer of each tower, a linear map turns five vectors into tokens after the first
token. A copy of the image projection reads these tokens; the class token passes as in CLIP. The
towers are frozen, and gradients pass through them. Source: Guo and Gu, MMRL, CVPR 2025; sizes,
rates and losses are those of its few-shot code. Only the class token predicts, as in that code for
unseen domains. Our changes: VIS and TAC count as images alike; images are mirrored, not cropped, as
in the OmniVaT paper; in towers with other depths than twelve, the last seven layers are the upper
ones.
"""

from collections.abc import Callable, Sequence
from copy import deepcopy
from typing import Any

import torch
from torch import Tensor, nn
from torch.nn.functional import cosine_similarity, cross_entropy, normalize

from omnivat.encoders.clip_live import LiveClip
from omnivat.kit.errors import DataError
from omnivat.study.baselines.contract import Fitted, Source, joined, late, live_towers
from omnivat.study.baselines.descent import Descent, learned, size

TOKENS, WIDTH, UPPER = 5, 512, 7  # shared vectors, their length, layers that get them
SHARE, KEEP = 0.7, 0.5  # of the class token's loss; weight of staying near CLIP
SCALE = 100.0  # of cosines
PROMPT = "a photo of a {}."
# Sixteen pairs are the published batch of 32 images.
HOW = Descent(lr=1e-3, epochs=50, batch=16, weight_decay=5e-4, method="adam", warmup=0.02, clip=0.0)


class Representations(nn.Module):
    """The shared vectors, their maps into the upper layers, and the projection of image tokens.

    The frozen towers are not among its parameters.
    """

    def __init__(self, clip: LiveClip) -> None:
        super().__init__()
        self._towers = (clip,)  # in a tuple, so that it is not a submodule
        self.upper = min(UPPER, len(clip.image_layers), len(clip.text_layers))
        self.tokens = nn.Parameter(0.02 * torch.randn(TOKENS, WIDTH))
        projection = clip.image.visual_projection
        self.to_image = _maps(projection.in_features, self.upper)
        self.to_text = _maps(clip.text.text_projection.in_features, self.upper)
        self.projection = nn.Linear(projection.in_features, projection.out_features, bias=False)
        self.projection.weight.data.copy_(projection.weight)
        self.to(clip.device)

    def images(self, images: Tensor) -> tuple[Tensor, Tensor]:
        """Return unit embeddings (B, D) of images, of the class token and of the shared tokens."""
        (clip,) = self._towers
        tokens = self._upper(
            clip.image_tokens(images), clip.image_layers, self.to_image, lambda f, x: f(x, None)
        )
        last = clip.image.vision_model.post_layernorm(tokens[:, 1 : 1 + TOKENS]).mean(1)
        plain, shared = clip.image_end(tokens[:, 0]), self.projection(last)
        return normalize(plain, dim=-1), normalize(shared, dim=-1)

    def texts(self, tokens: Tensor, ends: Tensor) -> Tensor:
        """Return unit embeddings (K, D) of texts as they enter the first layer, read at `ends`."""
        (clip,) = self._towers
        tokens = self._upper(tokens, clip.text_layers, self.to_text, clip.text_layer)
        return normalize(clip.text_end(tokens, ends + TOKENS), dim=-1)

    def _upper(
        self,
        tokens: Tensor,
        layers: Sequence[Any],
        maps: nn.ModuleList,
        step: Callable[..., Tensor],
    ) -> Tensor:
        """Pass tokens (B, T, W) through a tower's layers; the upper ones get shared tokens after
        the first token.
        """
        first = len(layers) - self.upper
        for number, layer in enumerate(layers):
            if number >= first:
                own = maps[number - first](self.tokens).expand(len(tokens), -1, -1)
                rest = tokens[:, 1:] if number == first else tokens[:, 1 + TOKENS :]
                tokens = torch.cat((tokens[:, :1], own, rest), dim=1)
            tokens = step(layer, tokens)
        return tokens


def _maps(width: int, count: int) -> nn.ModuleList:
    """Return a map for each layer, all with equal initial weights."""
    first = nn.Linear(WIDTH, width)
    return nn.ModuleList(deepcopy(first) for _ in range(count))


def fit(source: Source) -> Fitted:
    """Learn the tokens through both towers; rates and epochs as published.

    Raises DataError if the images or CLIP's live towers are not available, or CLIP is a ResNet.
    """
    live, clip = live_towers(source, "MMRL")
    if not clip.is_vit:
        raise DataError(
            "MMRL puts tokens between the layers of a ViT, and these embeddings are of a ResNet;"
            " embed the pairs with a CLIP ViT."
        )
    named = [PROMPT.format(name) for name in source.classes]
    with torch.no_grad():
        prompts, own = clip.text_tokens(named), clip.embed_texts(named)

    def loss(model: Representations, rows: Tensor) -> Tensor:
        images = live.drawn(rows).to(clip.device)
        labels = source.labels[rows].repeat(2).to(clip.device)
        with torch.no_grad():
            before = clip.embed(images)
        plain, shared = model.images(images)
        texts = model.texts(*prompts)
        right = [cross_entropy(SCALE * seen @ texts.T, labels) for seen in (plain, shared)]
        moved = 2 - cosine_similarity(plain, before).mean() - cosine_similarity(texts, own).mean()
        return SHARE * right[0] + (1 - SHARE) * right[1] + KEEP * moved

    model = learned(source, lambda: Representations(clip), HOW, loss, "mmrl")

    @torch.no_grad()
    def features(images: Tensor) -> Tensor:
        return model.images(images.to(clip.device))[0].cpu()

    with torch.no_grad():
        texts = model.texts(*prompts).cpu()
    return Fitted(
        predict=late(lambda _, images: (SCALE * features(images) @ texts.T).softmax(-1)),
        features=lambda vis, tac: joined(features(vis), features(tac)),
        parameters=size(model),
        images=True,
    )
