"""CLIP's image towers: ViT through `transformers`, ResNet under the names that OpenAI published.

Radford et al., "Learning Transferable Visual Models From Natural Language Supervision", 2021;
section 2.4: a ResNet with a stem of three convolutions, average pooling before each convolution
that would have a stride, and attention instead of the last average. All sizes come from the
weights.
"""

from collections.abc import Mapping
from typing import Any

import torch
from PIL import Image
from torch import Tensor, nn
from torch.nn.functional import avg_pool2d, linear, relu, scaled_dot_product_attention

from omnivat.encoders.clip_names import RESNET, State
from omnivat.encoders.clip_settings import HEAD_WIDTH, Clip, count, heads
from omnivat.encoders.running import FoldedConv, one_by_one, pixels, placed, precision_type, resized
from omnivat.kit.errors import DataError
from omnivat.kit.tables import need


class ClipTower:
    """The image tower of CLIP, a ViT or a ResNet, as an `Encoder`."""

    def __init__(self, clip: Clip, device: torch.device, precision: str) -> None:
        shape = clip.shape
        if shape is None:
            raise DataError(
                f"'{clip.file}' has a text tower and no image tower; name the whole model."
            )
        self.name, self.is_vit = clip.name, shape.kind != RESNET
        if self.is_vit:
            sizes = {
                "width": shape.width,
                "layers": shape.layers[0],
                "patch": shape.patch,
                "side": shape.side,
            }
            network = transformer(
                clip,
                "vision",
                sizes,
                patch_size=shape.patch,
                image_size=shape.side,
                projection_dim=shape.embed,
            )
        else:
            try:
                network = Tower(clip.weights.image)
            except KeyError as error:
                raise DataError(
                    f"'{clip.file}' lacks the weight {error} of {clip.name}."
                ) from error
        self.width = shape.embed
        self.weights_hash, self.text_hash = clip.image_hash, clip.text_hash
        self.precision = precision
        self.side, self.mean, self.std = shape.side, clip.settings.mean, clip.settings.std
        self.preprocessing = resized(self.side, self.mean, self.std)
        self._type = precision_type(precision, device)
        self.network = placed(network, device, self._type)
        self._device = device

    def preprocess(self, image: Image.Image) -> Tensor:
        """Return an RGB image as (3, side, side)."""
        return pixels(image, self.mean, self.std, self.side)

    def embed(self, images: Tensor) -> Tensor:
        """Return the projected embeddings (B, D) of preprocessed images (B, 3, side, side)."""
        run = (
            (lambda some: self.network(pixel_values=some).image_embeds)
            if self.is_vit
            else self.network
        )
        return one_by_one(run, images.to(self._device, self._type))


def transformer(clip: Clip, part: str, sizes: Mapping[str, int], **more: int) -> Any:
    """Return a tower of `transformers` with the checkpoint's weights.

    part   "vision" or "text"
    sizes  "width", "layers" and others, from the weights, that the settings beside them must state,
           too
    more  settings of this tower alone

    Raises DataError for weights that are missing, or of other sizes.
    """
    transformers = need("transformers", purpose="CLIP's ViT encoders")
    of_text = part == "text"
    state, stated = (
        (clip.weights.text, clip.settings.text)
        if of_text
        else (clip.weights.image, clip.settings.image)
    )
    for name, size in sizes.items():
        if stated.get(name, size) != size:
            raise DataError(
                f"'{clip.file}' has {name} {size}, and the config.json beside it states "
                f"{stated[name]}; put the weights and the settings of one model there."
            )
    config = getattr(transformers, f"CLIP{part.title()}Config")(
        hidden_size=sizes["width"],
        num_hidden_layers=sizes["layers"],
        num_attention_heads=heads(sizes["width"], stated.get("heads"), clip.file),
        intermediate_size=len(clip.weight(state, f"{part}_model.encoder.layers.0.mlp.fc1.weight")),
        hidden_act=clip.settings.activation,
        layer_norm_eps=clip.settings.eps,
        **more,
    )
    with torch.device("meta"):
        network = getattr(transformers, f"CLIP{part.title()}ModelWithProjection")(config)
    return _filled(network, state, clip)


def _filled(network: Any, state: State, clip: Clip) -> Any:
    """Load weights into `network`, which was built on the meta device.

    Buffers that checkpoints lack (positions 0, 1, 2, ...) are made here.
    Raises DataError if weights are missing or have other shapes.
    """
    wanted = network.state_dict()
    if missing := sorted(set(wanted) - set(state)):
        raise DataError(
            f"'{clip.file}' lacks {len(missing)} weights of {clip.name}, such as {missing[0]};"
            " fetch it again."
        )
    for key, tensor in wanted.items():
        if state[key].shape != tensor.shape:
            raise DataError(
                f"'{clip.file}' has {key} of shape {tuple(state[key].shape)}, expected "
                f"{tuple(tensor.shape)}; fetch it again."
            )
    network.load_state_dict({key: state[key] for key in wanted}, assign=True)
    for module in network.modules():
        for name, buffer in list(module.named_buffers(recurse=False)):
            if buffer.is_meta and name == "position_ids":
                module.register_buffer(name, torch.arange(buffer.shape[-1])[None], persistent=False)
    return network.eval().requires_grad_(False)


STRIDES = (1, 2, 2, 2)  # of the four stages


class Tower(nn.Module):
    """(B, 3, side, side) -> (B, D)."""

    def __init__(self, state: State) -> None:
        super().__init__()
        self.stem = nn.ModuleList(
            FoldedConv(state, f"conv{i}", f"bn{i}", stride=2 if i == 1 else 1) for i in (1, 2, 3)
        )
        self.stages = nn.ModuleList()
        for stage, stride in enumerate(STRIDES, start=1):
            names = [f"layer{stage}.{block}" for block in range(count(state, f"layer{stage}."))]
            self.stages.append(
                nn.Sequential(
                    *(Bottleneck(state, n, stride=1 if k else stride) for k, n in enumerate(names))
                )
            )
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

    def __init__(self, state: State, name: str, *, stride: int) -> None:
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

    def __init__(self, state: State) -> None:
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
