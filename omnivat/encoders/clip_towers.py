"""CLIP's image towers: ViT through `transformers`, ResNet under the names that OpenAI published.

Radford et al., "Learning Transferable Visual Models From Natural Language Supervision", 2021; section
2.4: a ResNet with a stem of three convolutions, average pooling before each convolution that would
have a stride, and attention instead of the last average. All sizes come from the weights.
"""

from typing import Any

import torch
from PIL import Image
from torch import Tensor, nn
from torch.nn.functional import avg_pool2d, conv2d, linear, relu, scaled_dot_product_attention

from omnivat.encoders.clip_names import State
from omnivat.encoders.clip_settings import Clip, ImageShape, heads
from omnivat.encoders.running import one_by_one, pixels, placed, precision_type, resized
from omnivat.errors import DataError
from omnivat.tables import need

PURPOSE = "CLIP's ViT encoders"


class ClipTower:
    """The image tower of CLIP, a ViT or a ResNet, as an `Encoder`."""

    def __init__(self, clip: Clip, shape: ImageShape, device: torch.device, precision: str, *, vit: bool) -> None:
        try:
            network = _network(clip, shape) if vit else Tower(clip.weights.image)
        except KeyError as error:
            raise DataError(f"'{clip.file}' lacks the weight {error} of {clip.name}.") from error
        self.name, self.is_vit = clip.name, vit
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
        return one_by_one(self._tower, images.to(self._device, self._type))

    def _tower(self, images: Tensor) -> Tensor:
        given = self.network(pixel_values=images).image_embeds if self.is_vit else self.network(images)
        embeds: Tensor = given
        return embeds


def _network(clip: Clip, shape: ImageShape) -> Any:
    """Return the tower of `transformers` with the checkpoint's weights."""
    transformers = need("transformers", purpose=PURPOSE)
    state, stated = clip.weights.image, clip.settings.image
    sizes = {"width": shape.width, "layers": shape.layers[0], "patch": shape.patch}
    require_stated(stated, sizes | {"side": shape.side}, clip)
    config = transformers.CLIPVisionConfig(
        hidden_size=shape.width,
        num_hidden_layers=shape.layers[0],
        num_attention_heads=heads(shape.width, stated.get("heads"), clip.file),
        intermediate_size=mlp_width(state, "vision_model.encoder.layers.0.", clip),
        patch_size=shape.patch,
        image_size=shape.side,
        projection_dim=shape.embed,
        hidden_act=clip.settings.activation,
        layer_norm_eps=clip.settings.eps,
    )
    with torch.device("meta"):
        network = transformers.CLIPVisionModelWithProjection(config)
    return filled(network, state, clip)


def mlp_width(state: State, layer: str, clip: Clip) -> int:
    """Return the hidden width of the perceptron in `layer`; raises DataError without one."""
    weight = state.get(f"{layer}mlp.fc1.weight")
    if weight is None:
        raise DataError(f"'{clip.file}' lacks the weight {layer}mlp.fc1.weight of {clip.name}.")
    return len(weight)


def require_stated(stated: Any, found: dict[str, int], clip: Clip) -> None:
    """Raise DataError for weights whose sizes differ from the settings next to them."""
    for name, size in found.items():
        if stated.get(name, size) != size:
            raise DataError(
                f"'{clip.file}' has {name} {size}, and the config.json beside it states "
                f"{stated[name]}; put the weights and the settings of one model there."
            )


def filled(network: Any, state: State, clip: Clip) -> Any:
    """Load weights into `network`, which was built on the meta device.

    Buffers that checkpoints lack (positions 0, 1, 2, ...) are made here.
    Raises DataError if weights are missing or have other shapes.
    """
    wanted = network.state_dict()
    if missing := sorted(set(wanted) - set(state)):
        raise DataError(
            f"'{clip.file}' lacks {len(missing)} weights of {clip.name}, such as {missing[0]}; fetch it again."
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


HEAD_WIDTH = 64  # channels of one attention head
NORM_EPS = 1e-5
STRIDES = (1, 2, 2, 2)  # of the four stages


class Tower(nn.Module):
    """(B, 3, side, side) -> (B, D)."""

    def __init__(self, state: State) -> None:
        super().__init__()
        self.stem = nn.ModuleList(Conv(state, f"conv{i}", f"bn{i}", stride=2 if i == 1 else 1) for i in (1, 2, 3))
        self.stages = nn.ModuleList(
            nn.Sequential(
                *(
                    Bottleneck(state, f"layer{stage}.{block}", stride=stride if block == 0 else 1)
                    for block in range(_count(state, f"layer{stage}."))
                )
            )
            for stage, stride in enumerate(STRIDES, start=1)
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


class Conv(nn.Module):
    """A convolution with its batch normalisation folded in."""

    def __init__(self, state: State, conv: str, norm: str, *, stride: int = 1) -> None:
        super().__init__()
        scale = state[f"{norm}.weight"] / torch.sqrt(state[f"{norm}.running_var"] + NORM_EPS)
        self.weight: Tensor
        self.bias: Tensor
        self.register_buffer("weight", state[f"{conv}.weight"] * scale[:, None, None, None])
        self.register_buffer("bias", state[f"{norm}.bias"] - state[f"{norm}.running_mean"] * scale)
        self.stride = stride

    def forward(self, x: Tensor) -> Tensor:
        return conv2d(x, self.weight, self.bias, self.stride, padding=self.weight.shape[-1] // 2)


class Bottleneck(nn.Module):
    """Narrow, filter, pool, widen; add the input, pooled and widened to fit."""

    def __init__(self, state: State, name: str, *, stride: int) -> None:
        super().__init__()
        self.narrow = Conv(state, f"{name}.conv1", f"{name}.bn1")
        self.filter = Conv(state, f"{name}.conv2", f"{name}.bn2")
        self.widen = Conv(state, f"{name}.conv3", f"{name}.bn3")
        fits = f"{name}.downsample.0.weight" not in state
        self.fit = None if fits else Conv(state, f"{name}.downsample.0", f"{name}.downsample.1")
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


def _count(state: State, prefix: str) -> int:
    return len({key.split(".")[1] for key in state if key.startswith(prefix)})
