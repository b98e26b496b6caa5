"""Map the weights of CLIP's layouts to one set of names.

Image tower of a ViT and text tower: the names of `transformers`. Image tower of a ResNet: the names
of OpenAI without `visual.`. open_clip uses OpenAI's names.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass

from torch import Tensor

from omnivat.encoders.weights import Weights

IMAGE, TEXT = ("vision_model.", "visual_projection."), ("text_model.", "text_projection.")
MARKS = (  # a name of every image tower, and of every text tower
    r"(?:visual\.(?:layer1\.0\.)?conv1\.weight|vision_model\.embeddings\.class_embedding)",
    r"(?:text\.|text_model\.embeddings\.)?token_embedding\.weight",
)

# OpenAI's names -> those of transformers
_NAMES = {
    r"^visual\.transformer\.resblocks": "vision_model.encoder.layers",
    r"^visual\.class_embedding": "vision_model.embeddings.class_embedding",
    r"^visual\.positional_embedding": "vision_model.embeddings.position_embedding.weight",
    r"^visual\.conv1": "vision_model.embeddings.patch_embedding",
    r"^visual\.ln_pre": "vision_model.pre_layrnorm",
    r"^visual\.ln_post": "vision_model.post_layernorm",
    r"^visual\.proj$": "visual_projection.weight",
    r"^transformer\.resblocks": "text_model.encoder.layers",
    r"^token_embedding": "text_model.embeddings.token_embedding",
    r"^positional_embedding": "text_model.embeddings.position_embedding.weight",
    r"^ln_final": "text_model.final_layer_norm",
    r"^text_projection$": "text_projection.weight",
    r"\.ln_([12])\.": r".layer_norm\1.",
    r"\.attn\.": ".self_attn.",
    r"\.mlp\.c_fc\.": ".mlp.fc1.",
    r"\.mlp\.c_proj\.": ".mlp.fc2.",
}
_TRANSPOSED = ("visual.proj", "text_projection")


@dataclass(frozen=True, slots=True, kw_only=True)
class ClipState:
    """CLIP's weights under one set of names, from any layout.

    resnet       True if the image tower is a ResNet
    image, text  the towers' weights; empty if the file has none
    logit_scale  logarithm of the factor of cosines, or None
    """

    resnet: bool
    image: Weights
    text: Weights
    logit_scale: float | None


def clip_state(weights: Weights) -> ClipState:
    """Return CLIP's weights under the names used here; no tower has any if this is not a CLIP."""
    # a text tower that is a module of its own
    weights = weights.renamed(
        {key.removeprefix("text."): tensor for key, tensor in weights.items()}
    )
    resnet, scale = "visual.layer1.0.conv1.weight" in weights, weights.get("logit_scale")
    state = weights if _pick(weights, (*IMAGE, *TEXT)) else _renamed(weights)
    image = _pick(state, IMAGE)
    if resnet:
        image = {k.removeprefix("visual."): v for k, v in _pick(weights, ("visual.",)).items()}
    return ClipState(
        resnet=resnet,
        image=weights.renamed(image),
        text=weights.renamed(_pick(state, TEXT)),
        logit_scale=None if scale is None else float(scale),
    )


def _pick(state: Mapping[str, Tensor], prefixes: tuple[str, ...]) -> dict[str, Tensor]:
    return {key: value for key, value in state.items() if key.startswith(prefixes)}


def _renamed(state: Mapping[str, Tensor]) -> dict[str, Tensor]:
    """Return OpenAI's weights under the names, and in the shapes, of transformers."""
    renamed: dict[str, Tensor] = {}
    for key, value in state.items():
        name = key
        if key in _TRANSPOSED:
            value = value.T.contiguous()
        for old, new in _NAMES.items():
            name = re.sub(old, new, name)
        layer, joined, kind = name.partition("in_proj_")
        if joined:  # query, key and value are in one array
            parts = zip("qkv", value.chunk(3), strict=True)
            renamed |= {f"{layer}{part}_proj.{kind}": v.contiguous() for part, v in parts}
        else:
            renamed[name] = value
    return renamed
