"""CLIP's image towers: ViT through `transformers`, ResNet under the names that OpenAI published.

Radford et al., "Learning Transferable Visual Models From Natural Language Supervision", 2021;
section 2.4: a ResNet with a stem of three convolutions, average pooling before each convolution
that would have a stride, and attention instead of the last average. All sizes come from the
weights.
"""

from pathlib import Path
from typing import Any

import torch
from torch import Tensor, nn
from torch.nn.functional import avg_pool2d, linear, relu, scaled_dot_product_attention

from omnivat.encoders.clip import Clip, open_clip
from omnivat.encoders.running import FoldedConv
from omnivat.encoders.weights import Weights, count
from omnivat.encoders.wrapping import TorchEncoder
from omnivat.kit.errors import DataError
from omnivat.kit.tables import need

HEAD_WIDTH = 64  # channels of one attention head in every published CLIP


def load(
    name: str, *, weights: Path | None, device: torch.device, precision: str, download: str = "ask"
) -> TorchEncoder:
    """Load the image tower of a CLIP checkpoint as an encoder. Raises DataError if it has none."""
    return image_encoder(open_clip(name, weights, download=download), device, precision)


def image_encoder(clip: Clip, device: torch.device, precision: str) -> TorchEncoder:
    """Return the image tower of CLIP, a ViT or a ResNet, as an encoder."""
    shape, resnet = clip.shape, clip.weights.resnet
    if shape is None:
        raise DataError(f"'{clip.file}' has a text tower and no image tower; name the whole model.")
    sizes = {
        "hidden_size": shape.width,
        "num_hidden_layers": shape.layers[0],
        "patch_size": shape.patch,
        "image_size": shape.side,
        "projection_dim": shape.embed,
    }
    return TorchEncoder(
        Tower(clip.weights.image) if resnet else transformer(clip, "vision", **sizes),
        side=shape.side,
        mean=clip.settings.mean,
        std=clip.settings.std,
        pool=None if resnet else lambda output: output.image_embeds,
        device=device,
        precision=precision,
        width=shape.embed,
        name=clip.name,
        weights_hash=clip.image_hash,
        text_hash=clip.text_hash,
    )


def transformer(clip: Clip, part: str, *, hidden_size: int, **sizes: int) -> Any:
    """Return a tower of `transformers` with the checkpoint's weights.

    part   "vision" or "text"
    sizes  settings that the weights tell

    Raises DataError for weights that are missing, or of other sizes.
    """
    transformers = need("transformers", purpose="CLIP's ViT encoders")
    state, stated = (
        (clip.weights.text, clip.settings.text)
        if part == "text"
        else (clip.weights.image, clip.settings.image)
    )
    heads = stated.get("num_attention_heads", hidden_size / HEAD_WIDTH)
    if hidden_size % heads or heads % 1:
        raise DataError(
            f"'{clip.file}' has layers of width {hidden_size}, which {heads:g} attention heads"
            " cannot divide; put the model's config.json beside the file."
        )
    settings: dict[str, Any] = {
        **stated,
        **sizes,
        "hidden_size": hidden_size,
        "num_attention_heads": int(heads),
        "intermediate_size": len(state[f"{part}_model.encoder.layers.0.mlp.fc1.weight"]),
        "hidden_act": clip.settings.activation,
    }
    config = getattr(transformers, f"CLIP{part.title()}Config")(**settings)
    with torch.device("meta"):
        network = getattr(transformers, f"CLIP{part.title()}ModelWithProjection")(config)
    state.fill(network)
    places = getattr(network, f"{part}_model").embeddings  # 0, 1, 2, ... which no file holds
    numbers = torch.arange(places.position_ids.shape[-1])[None]
    places.register_buffer("position_ids", numbers, persistent=False)
    return network


STRIDES = (1, 2, 2, 2)  # of the four stages


class Tower(nn.Module):
    """(B, 3, side, side) -> (B, D)."""

    def __init__(self, state: Weights) -> None:
        super().__init__()
        self.stem = nn.ModuleList(
            FoldedConv(state, f"conv{i}", f"bn{i}", stride=2 if i == 1 else 1) for i in (1, 2, 3)
        )
        self.stages = nn.ModuleList()
        for stage, stride in enumerate(STRIDES, start=1):
            names = [f"layer{stage}.{block}" for block in range(count(state, f"layer{stage}."))]
            blocks = [Bottleneck(state, n, stride=1 if k else stride) for k, n in enumerate(names)]
            self.stages.append(nn.Sequential(*blocks))
        self.pool = AttentionPool(state)

    def levels(self, x: Tensor) -> list[Tensor]:
        """Return the output maps (B, C, H, W) of the four stages, for images (B, 3, side, side)."""
        for conv in self.stem:
            x = relu(conv(x))
        x = avg_pool2d(x, 2)
        found = []
        for stage in self.stages:
            x = stage(x)
            found.append(x)
        return found

    def forward(self, x: Tensor) -> Tensor:
        pooled: Tensor = self.pool(self.levels(x)[-1])
        return pooled


class Bottleneck(nn.Module):
    """Narrow, filter, pool, widen; add the input, pooled and widened to fit."""

    def __init__(self, state: Weights, name: str, *, stride: int) -> None:
        super().__init__()
        self.narrow = FoldedConv(state, f"{name}.conv1", f"{name}.bn1")
        self.filter = FoldedConv(state, f"{name}.conv2", f"{name}.bn2")
        self.widen = FoldedConv(state, f"{name}.conv3", f"{name}.bn3")
        fits = f"{name}.downsample.0.weight" not in state
        self.fit = (
            None if fits else FoldedConv(state, f"{name}.downsample.0", f"{name}.downsample.1")
        )
        self.stride = stride

    def forward(self, x: Tensor) -> Tensor:
        out = relu(self.filter(relu(self.narrow(x))))
        out = self.widen(self._pooled(out))
        return relu(out + (x if self.fit is None else self.fit(self._pooled(x))))

    def _pooled(self, x: Tensor) -> Tensor:
        return avg_pool2d(x, self.stride) if self.stride > 1 else x


class AttentionPool(nn.Module):
    """Attention pooling: the query is the mean over all positions."""

    def __init__(self, state: Weights) -> None:
        super().__init__()
        for name in ("q_proj", "k_proj", "v_proj", "c_proj"):
            self.register_buffer(f"{name}_weight", state[f"attnpool.{name}.weight"])
            self.register_buffer(f"{name}_bias", state[f"attnpool.{name}.bias"])
        self.places: Tensor
        self.register_buffer("places", state["attnpool.positional_embedding"])

    def forward(self, x: Tensor) -> Tensor:
        x = x.flatten(2).mT  # (B, H * W, C)
        x = torch.cat([x.mean(dim=1, keepdim=True), x], dim=1) + self.places
        query = self._heads(self._project("q_proj", x[:, :1]))
        key, value = (self._heads(self._project(name, x)) for name in ("k_proj", "v_proj"))
        seen = scaled_dot_product_attention(query, key, value)  # (B, heads, 1, HEAD_WIDTH)
        return self._project("c_proj", seen.flatten(1))

    def _project(self, name: str, x: Tensor) -> Tensor:
        return linear(x, self.get_buffer(f"{name}_weight"), self.get_buffer(f"{name}_bias"))

    def _heads(self, x: Tensor) -> Tensor:
        return x.reshape(*x.shape[:2], -1, HEAD_WIDTH).transpose(1, 2)
