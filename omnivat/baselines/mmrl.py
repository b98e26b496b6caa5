"""MMRL: learn shared tokens inside the upper layers of both towers.

For each upper layer of each tower, a linear map turns five vectors into tokens after the first
token. A copy of the image projection reads these tokens; the class token passes as in CLIP. The
towers are frozen, and gradients pass through them. Source: Guo and Gu, MMRL, CVPR 2025; sizes,
rates and losses are those of its few-shot code. Only the class token predicts, as in that code for
unseen domains. Our changes: VIS and TAC count as images alike; images are mirrored, not cropped,
as in the OmniVaT paper; in towers with other depths than twelve, the last seven layers are the
upper ones.
"""

from copy import deepcopy

import torch
from torch import Tensor, nn
from torch.nn.functional import cosine_similarity, cross_entropy, normalize

from omnivat.baselines.contract import Fitted, ImageInput, Live, Source, fused, joined, live_towers, seeded
from omnivat.baselines.descent import Descent, descend
from omnivat.encoders.clip_live import LiveClip
from omnivat.errors import DataError
from omnivat.seeding import derive_seed

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
        tokens = clip.image_tokens(images)
        first = len(clip.image_layers) - self.upper
        for number, layer in enumerate(clip.image_layers):
            if number >= first:
                own = self.to_image[number - first](self.tokens)
                tokens = _inserted(tokens, own, anew=number == first)
            tokens = layer(tokens, None)
        last = clip.image.vision_model.post_layernorm(tokens[:, 1 : 1 + TOKENS]).mean(1)
        plain, shared = clip.image_end(tokens[:, 0]), self.projection(last)
        return normalize(plain, dim=-1), normalize(shared, dim=-1)

    def texts(self, tokens: Tensor, ends: Tensor) -> Tensor:
        """Return unit embeddings (K, D) of texts as they enter the first layer, read at `ends`."""
        (clip,) = self._towers
        first = len(clip.text_layers) - self.upper
        for number, layer in enumerate(clip.text_layers):
            if number >= first:
                own = self.to_text[number - first](self.tokens)
                tokens = _inserted(tokens, own, anew=number == first)
            tokens = clip.text_layer(layer, tokens)
        return normalize(clip.text_end(tokens, ends + TOKENS), dim=-1)


def _maps(width: int, count: int) -> nn.ModuleList:
    """Return a map for each layer, all with equal initial weights."""
    first = nn.Linear(WIDTH, width)
    return nn.ModuleList(deepcopy(first) for _ in range(count))


def _inserted(tokens: Tensor, own: Tensor, *, anew: bool) -> Tensor:
    """Insert `own` (5, W) after the first of tokens (B, T, W), or replace earlier ones."""
    rest = tokens[:, 1:] if anew else tokens[:, 1 + TOKENS :]
    return torch.cat((tokens[:, :1], own.expand(len(tokens), -1, -1), rest), dim=1)


def fit(source: Source) -> Fitted:
    """Learn the tokens through both towers; rates and epochs as published.

    Raises DataError if the images or CLIP's live towers are not available, or CLIP is a ResNet.
    """
    live, clip, given = live_towers(source, "MMRL")
    if not clip.is_vit:
        raise DataError(
            "MMRL puts tokens between the layers of a ViT, and these embeddings are of a ResNet; embed "
            "the pairs with a CLIP ViT."
        )
    with seeded(derive_seed(source.seed, "mmrl")):
        model = Representations(clip)
        _train(model, clip, source, live, given)
    model.requires_grad_(False)
    with torch.no_grad():
        texts = model.texts(*_prompts(clip, source.classes))

    @torch.no_grad()
    def predict(vis: Tensor, tac: Tensor) -> dict[str, Tensor]:
        found = features(vis, tac)
        alone = {name: (SCALE * found[name] @ texts.cpu().T).softmax(-1) for name in ("vis", "tac")}
        return fused(alone)

    @torch.no_grad()
    def features(vis: Tensor, tac: Tensor) -> dict[str, Tensor]:
        rows = [model.images(images.to(clip.device))[0].cpu() for images in (vis, tac)]
        return joined(*rows)

    return Fitted(
        predict=predict,
        features=features,
        parameters=sum(weight.numel() for weight in model.parameters()),
        images=given,
    )


def _prompts(clip: LiveClip, classes: tuple[str, ...]) -> tuple[Tensor, Tensor]:
    return clip.text_tokens([PROMPT.format(name) for name in classes])


def _train(model: Representations, clip: LiveClip, source: Source, live: Live, given: ImageInput) -> None:
    with torch.no_grad():
        prompts = _prompts(clip, source.classes)
        own = clip.embed_texts([PROMPT.format(name) for name in source.classes])

    def loss(rows: Tensor) -> Tensor:
        images = live.drawn(rows, given).to(clip.device)
        labels = source.labels[rows].repeat(2).to(clip.device)
        with torch.no_grad():
            before = clip.embed(images)
        plain, shared = model.images(images)
        texts = model.texts(*prompts)
        right = [cross_entropy(SCALE * seen @ texts.T, labels) for seen in (plain, shared)]
        moved = 2 - cosine_similarity(plain, before).mean() - cosine_similarity(texts, own).mean()
        return SHARE * right[0] + (1 - SHARE) * right[1] + KEEP * moved

    descend(model, len(source), HOW, loss)
