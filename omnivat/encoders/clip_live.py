"""A live CLIP: both towers layer by layer, for methods that learn inside them.

The towers stay frozen. Gradients pass through them to modules that a method inserts between layers.
"""

from collections.abc import Sequence
from functools import lru_cache
from typing import Any, cast

import torch
from torch import Tensor, nn

from omnivat.encoders.base import JOINED
from omnivat.encoders.clip import CHECKPOINTS, Clip, open_clip
from omnivat.encoders.clip_text import ClipText
from omnivat.encoders.clip_towers import image_encoder
from omnivat.encoders.hub import recall
from omnivat.kit.devices import current
from omnivat.kit.errors import DataError


class LiveClip:
    """Both towers of a CLIP, on one device, in float32, frozen.

    image        a `CLIPVisionModelWithProjection` of transformers, or a ResNet `Tower`
    text         a `CLIPTextModelWithProjection` of transformers
    is_vit       True if the image tower is a transformer
    width        D of both towers' embeddings
    side, mean, std   of input images: pixels, and statistics of red, green and blue
    logit_scale  the model's factor of cosines
    """

    def __init__(self, clip: Clip, device: torch.device) -> None:
        encoder = image_encoder(clip, device, "fp32")
        texts = ClipText(clip, device)
        self.image: Any = encoder.network
        self.text: Any = texts.network
        self.is_vit = not clip.weights.resnet
        self.width = encoder.width
        self.side, self.mean, self.std = encoder.side, encoder.mean, encoder.std
        self.logit_scale = texts.logit_scale or 100.0
        self.device = device
        self._tokenizer = texts.tokenizer

    @property
    def image_layers(self) -> Sequence[nn.Module]:
        """The layers of the image tower, a ViT's."""
        return cast("Sequence[nn.Module]", self.image.vision_model.encoder.layers)

    @property
    def text_layers(self) -> Sequence[nn.Module]:
        """The layers of the text tower."""
        return cast("Sequence[nn.Module]", self.text.text_model.encoder.layers)

    def image_tokens(self, images: Tensor) -> Tensor:
        """Return the first layer's input: tokens (B, 1 + N, W) of images (B, 3, side, side)."""
        tower = self.image.vision_model
        return cast("Tensor", tower.pre_layrnorm(tower.embeddings(images)))

    def image_end(self, tokens: Tensor) -> Tensor:
        """Return embeddings (B, D) of class tokens (B, W) from the last layer."""
        return cast(
            "Tensor", self.image.visual_projection(self.image.vision_model.post_layernorm(tokens))
        )

    def embed(self, images: Tensor) -> Tensor:
        """Return the model's own embeddings (B, D) of images (B, 3, side, side)."""
        found = self.image(images)
        return cast("Tensor", found.image_embeds if self.is_vit else found)

    def text_tokens(self, texts: Sequence[str]) -> tuple[Tensor, Tensor]:
        """Return the input of the first layer, (K, T, W), and the index (K,) of each text's end."""
        found = self._tokenizer(
            list(texts),
            padding=True,
            truncation=True,
            max_length=self.text.config.max_position_embeddings,
            return_tensors="pt",
        ).to(self.device)
        tokens = self.text.text_model.embeddings(input_ids=found["input_ids"])
        return tokens, found["attention_mask"].sum(1) - 1

    def text_layer(self, layer: nn.Module, tokens: Tensor) -> Tensor:
        """Run one layer of the text tower, with causal attention."""
        return cast("Tensor", layer(tokens, None, is_causal=True))

    def text_end(self, tokens: Tensor, ends: Tensor) -> Tensor:
        """Return embeddings (K, D) of tokens (K, T, W) from the last layer, read at `ends`."""
        last = self.text.text_model.final_layer_norm(tokens)
        return cast("Tensor", self.text.text_projection(last[torch.arange(len(last)), ends]))

    def embed_texts(self, texts: Sequence[str]) -> Tensor:
        """Return the model's own embeddings (K, D) of texts."""
        tokens, ends = self.text_tokens(texts)
        for layer in self.text_layers:
            tokens = self.text_layer(layer, tokens)
        return self.text_end(tokens, ends)


@lru_cache(maxsize=1)
def load_live(encoder: str, weights_hash: str) -> LiveClip:
    """Load the CLIP that made these embeddings, from the last known location of its weights.

    Raises DataError if the encoder is not a CLIP, if its weights are missing or have changed, or if
    it has no text tower.
    """
    if JOINED in encoder or encoder not in CHECKPOINTS:
        raise DataError(
            f"Methods that learn inside CLIP need one CLIP for both images, and '{encoder}' made"
            " these embeddings; embed the pairs with --encoder clip --weights FILE."
        )
    clip = open_clip(encoder, recall(weights_hash), download="no")
    if clip.image_hash != weights_hash:
        raise DataError(
            f"The weights of {encoder} found on this machine ({clip.image_hash}) are not those of"
            f" the embeddings ({weights_hash}); embed the pairs again with --weights FILE."
        )
    if not clip.weights.text:
        raise DataError(
            f"'{clip.file}' has an image tower and no text tower, which methods that learn inside"
            " CLIP need; embed the pairs with the whole model."
        )
    return LiveClip(clip, current())
