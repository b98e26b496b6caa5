"""Map the weights of all CLIP layouts to one set of names.

Image tower of a ViT and text tower: the names of `transformers`. Image tower of a ResNet: the names
of OpenAI without `visual.`. open_clip uses OpenAI's names; some of its models put `text.` before
those of the text tower.
"""

from collections.abc import Mapping
from dataclasses import dataclass

from torch import Tensor

State = dict[str, Tensor]
VIT, RESNET = "ViT", "ResNet"

_LAYER = {
    "ln_1": "layer_norm1",
    "ln_2": "layer_norm2",
    "attn.out_proj": "self_attn.out_proj",
    "mlp.c_fc": "mlp.fc1",
    "mlp.c_proj": "mlp.fc2",
}
_IMAGE = {
    "visual.class_embedding": "vision_model.embeddings.class_embedding",
    "visual.positional_embedding": "vision_model.embeddings.position_embedding.weight",
    "visual.conv1.weight": "vision_model.embeddings.patch_embedding.weight",
    "visual.ln_pre.weight": "vision_model.pre_layrnorm.weight",
    "visual.ln_pre.bias": "vision_model.pre_layrnorm.bias",
    "visual.ln_post.weight": "vision_model.post_layernorm.weight",
    "visual.ln_post.bias": "vision_model.post_layernorm.bias",
}
_TEXT = {
    "token_embedding.weight": "text_model.embeddings.token_embedding.weight",
    "positional_embedding": "text_model.embeddings.position_embedding.weight",
    "ln_final.weight": "text_model.final_layer_norm.weight",
    "ln_final.bias": "text_model.final_layer_norm.bias",
}

# One weight of each kind of image tower.
_ANCHORS = (
    "vision_model.embeddings.class_embedding",
    "visual.class_embedding",
    "visual.attnpool.positional_embedding",
)


@dataclass(frozen=True, slots=True, kw_only=True)
class ClipState:
    """CLIP's weights under one set of names, from any layout.

    kind         "ViT", "ResNet", or "" without an image tower
    image, text  the towers' weights; empty if the file has none
    logit_scale  logarithm of the factor of cosines, or None
    """

    kind: str
    image: State
    text: State
    logit_scale: float | None


def clip_state(state: Mapping[str, Tensor]) -> ClipState | None:
    """Return CLIP's weights under the names used here, or None if this is not a CLIP."""
    state = _unwrapped(state)
    scale = state.get("logit_scale")
    if any(key.startswith(("vision_model.", "text_model.")) for key in state):
        kind, image = VIT, _pick(state, "vision_model.", "visual_projection.")
        text = _pick(state, "text_model.", "text_projection.")
    else:
        # as open_clip may have it
        state = {key.removeprefix("text."): value for key, value in state.items()}
        kind = RESNET if "visual.layer1.0.conv1.weight" in state else VIT
        image = _vit(state)
        if kind == RESNET:
            image = {k.removeprefix("visual."): v for k, v in _pick(state, "visual.").items()}
        text = _text(state)
    if not image and not text:
        return None
    return ClipState(
        kind=kind if image else "",
        image=image,
        text=text,
        logit_scale=None if scale is None or scale.numel() != 1 else float(scale),
    )


def _unwrapped(state: Mapping[str, Tensor]) -> Mapping[str, Tensor]:
    """Return the part of `state` that is CLIP, without what a model around it put before its
    names.
    """
    for anchor in _ANCHORS:
        found = next((key for key in state if key.endswith(f".{anchor}")), "")
        if prefix := found.removesuffix(anchor):
            return {k.removeprefix(prefix): v for k, v in state.items() if k.startswith(prefix)}
    if any(key.removeprefix("visual.") in state for key in _ANCHORS[1:]):  # an image tower alone
        return {f"visual.{key}": value for key, value in state.items()}
    return state


def _pick(state: Mapping[str, Tensor], *prefixes: str) -> State:
    return {key: value for key, value in state.items() if key.startswith(prefixes)}


def _vit(state: Mapping[str, Tensor]) -> State:
    found = {new: state[old] for old, new in _IMAGE.items() if old in state}
    found |= _layers(state, "visual.transformer.resblocks.", "vision_model.encoder.layers.")
    if "visual.proj" in state:
        found["visual_projection.weight"] = state["visual.proj"].T.contiguous()
    return found


def _text(state: Mapping[str, Tensor]) -> State:
    found = {new: state[old] for old, new in _TEXT.items() if old in state}
    found |= _layers(state, "transformer.resblocks.", "text_model.encoder.layers.")
    if found and "text_projection" in state:
        found["text_projection.weight"] = state["text_projection"].T.contiguous()
    if found and "text_projection.weight" in state:  # a linear layer, as open_clip may have it
        found["text_projection.weight"] = state["text_projection.weight"]
    return found


def _layers(state: Mapping[str, Tensor], old: str, new: str) -> State:
    found: State = {}
    for key, value in _pick(state, old).items():
        number, _, name = key.removeprefix(old).partition(".")
        if name.startswith("attn.in_proj_"):  # query, key and value are in one array
            kind = name.removeprefix("attn.in_proj_")
            for which, part in zip("qkv", value.chunk(3), strict=True):
                found[f"{new}{number}.self_attn.{which}_proj.{kind}"] = part.contiguous()
            continue
        layer, _, kind = name.rpartition(".")
        if layer in _LAYER:
            found[f"{new}{number}.{_LAYER[layer]}.{kind}"] = value
    return found
