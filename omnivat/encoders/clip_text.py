"""CLIP's text tower, through `transformers`: text embeddings in the space of the images."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import torch
from torch import Tensor

from omnivat.encoders.clip import CHECKPOINTS, Clip, open_clip
from omnivat.encoders.clip_shapes import count, heads
from omnivat.encoders.clip_tokenizer import load_tokenizer
from omnivat.encoders.clip_vit import PURPOSE, filled, mlp_width, require_stated
from omnivat.errors import DataError, MissingNameError
from omnivat.packages import need
from omnivat.tables import suggestion
from omnivat.threads import one_thread


class ClipText:
    """The text tower of a CLIP. Prompt learners may use `network` and `tokenizer`.

    weights_hash    a hash of the text tower; `text_hash` of the image tower in the same file
    logit_scale     the model's factor of cosines; None if the checkpoint has none
    """

    def __init__(self, clip: Clip, device: torch.device) -> None:
        self.network = _network(clip).to(device)
        self._longest = int(self.network.config.max_position_embeddings)
        self.tokenizer = load_tokenizer(
            clip.place, longest=self._longest, vocabulary=int(self.network.config.vocab_size)
        )
        self.name, self.place = clip.name, clip.place
        self.width = int(self.network.config.projection_dim)
        self.weights_hash = clip.text_hash
        scale = clip.weights.logit_scale
        self.logit_scale = None if scale is None else float(torch.tensor(scale).exp())
        self._device = device

    def embed_texts(self, texts: Sequence[str]) -> Tensor:
        """Return the projected embeddings (B, D), float32, of B texts; long texts are truncated."""
        with torch.inference_mode(), one_thread():
            return torch.cat([self._embed(text) for text in texts])

    def _embed(self, text: str) -> Tensor:
        tokens = self.tokenizer(
            [text], truncation=True, max_length=self._longest, return_tensors="pt"
        ).to(self._device)
        embeds: Tensor = self.network(**tokens).text_embeds
        return embeds.float()


def _network(clip: Clip) -> Any:
    """Return the tower of `transformers` with the checkpoint's weights."""
    transformers = need("transformers", purpose=PURPOSE)
    state, stated = clip.weights.text, clip.settings.text
    try:
        vocabulary, width = state["text_model.embeddings.token_embedding.weight"].shape
        longest = len(state["text_model.embeddings.position_embedding.weight"])
        embed = len(state["text_projection.weight"])
    except KeyError as error:
        raise DataError(f"'{clip.file}' lacks the weight {error} of {clip.name}.") from error
    layers = count(state, "text_model.encoder.layers.")
    require_stated(stated, {"width": width, "layers": layers}, clip)
    config = transformers.CLIPTextConfig(
        vocab_size=vocabulary,
        hidden_size=width,
        num_hidden_layers=layers,
        num_attention_heads=heads(width, stated.get("heads"), clip.file),
        intermediate_size=mlp_width(state, "text_model.encoder.layers.0.", clip),
        max_position_embeddings=longest,
        projection_dim=embed,
        hidden_act=clip.settings.activation,
        layer_norm_eps=clip.settings.eps,
        bos_token_id=vocabulary - 2,
        eos_token_id=stated.get("eos", vocabulary - 1),  # the last token in every published CLIP
    )
    with torch.device("meta"):
        network = transformers.CLIPTextModelWithProjection(config)
    return filled(network, state, clip)


def load_text_encoder(
    name: str, *, weights: Path | None = None, device: str = "cpu", download: str = "ask"
) -> ClipText:
    """Load the text tower of the image encoder called `name`.

    Raises MissingNameError for an encoder without one, DataError if a checkpoint is missing or
    has only an image tower.
    """
    if name not in CHECKPOINTS:
        raise MissingNameError(
            f"No text tower belongs to '{name}'; there are {', '.join(CHECKPOINTS)}."
            + suggestion(name, CHECKPOINTS)
        )
    from omnivat.devices import device_from

    clip = open_clip(name, weights, download=download)
    if not clip.weights.text:
        raise DataError(
            f"'{clip.file}' has an image tower and no text tower; name the whole model."
        )
    return ClipText(clip, device_from(device))
