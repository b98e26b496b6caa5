"""CLIP's ViTs: the image tower through `transformers`, with sizes from the weights.

Radford et al., "Learning Transferable Visual Models From Natural Language Supervision", 2021.
"""

from typing import TYPE_CHECKING, Any

import torch
from PIL import Image
from torch import Tensor

from omnivat.encoders.clip_names import State
from omnivat.encoders.clip_shapes import ImageShape, heads
from omnivat.encoders.running import one_by_one, pixels, placed, precision_type, resized
from omnivat.errors import DataError
from omnivat.packages import need

if TYPE_CHECKING:
    from omnivat.encoders.clip import Clip

PURPOSE = "CLIP's ViT encoders"


class ClipVit:
    """The image tower of a CLIP ViT as an `Encoder`."""

    def __init__(
        self, clip: "Clip", shape: ImageShape, device: torch.device, precision: str
    ) -> None:
        network = _network(clip, shape)
        self.name = clip.name
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
        embeds: Tensor = self.network(pixel_values=images).image_embeds
        return embeds


def _network(clip: "Clip", shape: ImageShape) -> Any:
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


def mlp_width(state: State, layer: str, clip: "Clip") -> int:
    """Return the hidden width of the perceptron in `layer`; raises DataError without one."""
    weight = state.get(f"{layer}mlp.fc1.weight")
    if weight is None:
        raise DataError(f"'{clip.file}' lacks the weight {layer}mlp.fc1.weight of {clip.name}.")
    return len(weight)


def require_stated(stated: Any, found: dict[str, int], clip: "Clip") -> None:
    """Raise DataError for weights whose sizes differ from the settings next to them."""
    for name, size in found.items():
        if stated.get(name, size) != size:
            raise DataError(
                f"'{clip.file}' has {name} {size}, and the config.json beside it states "
                f"{stated[name]}; put the weights and the settings of one model there."
            )


def filled(network: Any, state: State, clip: "Clip") -> Any:
    """Load weights into `network`, which was built on the meta device.

    Buffers that checkpoints lack (positions 0, 1, 2, ...) are made here.
    Raises DataError if weights are missing or have other shapes.
    """
    wanted = network.state_dict()
    if missing := sorted(set(wanted) - set(state)):
        raise DataError(
            f"'{clip.file}' lacks {len(missing)} weights of {clip.name}, such as {missing[0]}; "
            "fetch it again."
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
