"""CLIP's settings: from files next to the weights, and the network from the weights' shapes."""

import json
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import torch

from omnivat.encoders.clip_names import RESNET, VIT, ClipState, State
from omnivat.encoders.running import CLIP_MEAN, CLIP_STD, state_hash
from omnivat.encoders.weights import Weights
from omnivat.kit.errors import DataError

QUICK_GELU, GELU = "quick_gelu", "gelu"


@dataclass(frozen=True, slots=True, kw_only=True)
class ClipSettings:
    """The activation, pixel statistics, and numbers of heads if stated.

    image, text     numbers that `config.json` states: "heads", "width", "layers", "patch", "side",
                    "eos" (the token that ends a text)
    """

    activation: str = QUICK_GELU
    mean: tuple[float, ...] = CLIP_MEAN
    std: tuple[float, ...] = CLIP_STD
    eps: float = 1e-5
    image: Mapping[str, int] = field(default_factory=dict)
    text: Mapping[str, int] = field(default_factory=dict)


def clip_settings(weights: Weights, name: str) -> ClipSettings:
    """Return the settings for weights, from `config.json` or `open_clip_config.json` beside them.

    Without either: QuickGELU, as OpenAI trained; GELU for open_clip's own files and training
    checkpoints, unless the run's name contains "quickgelu".
    Raises DataError if such a file belongs to another kind of model.
    """
    folder = weights.file.parent
    if (folder / "config.json").is_file() and "open_clip" not in weights.file.name:
        return _of_transformers(folder / "config.json", name)
    if (folder / "open_clip_config.json").is_file():
        return _of_open_clip(folder / "open_clip_config.json", name)
    run, of_open_clip = weights.training, weights.file.name.startswith("open_clip")
    gelu = of_open_clip if run is None else "quickgelu" not in run.lower()
    return ClipSettings(activation=GELU if gelu else QUICK_GELU)


def _of_transformers(file: Path, name: str) -> ClipSettings:
    config = _json(file, name)
    if config.get("model_type", "clip") not in ("clip", "clip_vision_model", "clip_text_model"):
        raise DataError(
            f"'{file}' is not of a CLIP model but of '{config['model_type']}'; use --encoder"
            f" hf:{file.parent}."
        )
    image = config.get("vision_config") or config
    text = config.get("text_config") or config
    beside = file.with_name("preprocessor_config.json")
    pixels = _json(beside, "CLIP") if beside.is_file() else {}
    return ClipSettings(
        activation=str(image.get("hidden_act") or text.get("hidden_act") or QUICK_GELU),
        eps=float(image.get("layer_norm_eps", 1e-5)),
        image=_sizes(image, 12, {"patch": "patch_size", "side": "image_size"}),
        text=_sizes(text, 8, {"eos": "eos_token_id"}),
        **{
            name: tuple(map(float, pixels[f"image_{name}"]))
            for name in ("mean", "std")
            if f"image_{name}" in pixels
        },
    )


def _sizes(config: Mapping[str, Any], heads: int, more: Mapping[str, str]) -> dict[str, int]:
    names = {"width": "hidden_size", "layers": "num_hidden_layers", **more}
    found = {name: int(config[key]) for name, key in names.items() if key in config}
    return {"heads": int(config.get("num_attention_heads", heads)), **found}


def _of_open_clip(file: Path, name: str) -> ClipSettings:
    config = _json(file, name)
    model, pixels = config.get("model_cfg", config), config.get("preprocess_cfg", {})
    vision, text = model.get("vision_cfg"), model.get("text_cfg")
    if not isinstance(vision, dict) or not isinstance(text, dict):
        raise DataError(f"'{file}' is not of a CLIP model; fetch {name} again.")
    width = vision.get("head_width")
    return ClipSettings(
        activation=QUICK_GELU if model.get("quick_gelu") else GELU,
        image={"heads": int(vision["width"]) // int(width)} if width and "width" in vision else {},
        text={"heads": int(text["heads"])} if "heads" in text else {},
        mean=tuple(map(float, pixels.get("mean", CLIP_MEAN))),
        std=tuple(map(float, pixels.get("std", CLIP_STD))),
    )


def _json(file: Path, name: str) -> dict[str, Any]:
    with suppress(OSError, ValueError):
        if isinstance(found := json.loads(file.read_text(encoding="utf-8")), dict):
            return found
    raise DataError(f"'{file}' is not of a CLIP model; fetch {name} again.")


ANY = "clip"  # name for CLIP of any size
HEAD_WIDTH = 64  # channels of one attention head in every published CLIP


@dataclass(frozen=True, slots=True)
class ImageShape:
    """Sizes of an image tower.

    kind    "ViT" or "ResNet"
    patch   side of a patch in pixels; 32 for a ResNet, the stride of its last map
    width   channels: of a ViT's tokens, of a ResNet's first stage
    layers  of a ViT; blocks of each stage of a ResNet
    embed   D, the length of an embedding
    side    of the image, pixels
    """

    kind: str
    patch: int
    width: int
    layers: tuple[int, ...]
    embed: int
    side: int

    def __str__(self) -> str:
        layers = "+".join(map(str, self.layers))
        if self.kind == RESNET:
            return (
                f"a ResNet of {layers} blocks from width {self.width}, D {self.embed},"
                f" {self.side} px"
            )
        return (
            f"a ViT of patch {self.patch}, {layers} layers of width {self.width}, D {self.embed},"
            f" {self.side} px"
        )


PUBLISHED = {
    "clip-vit-b32": ImageShape(VIT, 32, 768, (12,), 512, 224),
    "clip-vit-b16": ImageShape(VIT, 16, 768, (12,), 512, 224),
    "clip-vit-l14": ImageShape(VIT, 14, 1024, (24,), 768, 224),
    "clip-vit-l14-336": ImageShape(VIT, 14, 1024, (24,), 768, 336),
    "clip-rn50": ImageShape(RESNET, 32, 64, (3, 4, 6, 3), 1024, 224),
    "clip-rn101": ImageShape(RESNET, 32, 64, (3, 4, 23, 3), 512, 224),
}


def image_shape(clip: ClipState) -> ImageShape:
    """Return the sizes of an image tower from its weights. Raises KeyError for a missing weight."""
    state = clip.image
    if clip.kind == RESNET:
        patch, width, places = (
            32,
            len(state["layer1.0.conv1.weight"]),
            state["attnpool.positional_embedding"],
        )
        layers, last = [f"layer{stage}." for stage in (1, 2, 3, 4)], state["attnpool.c_proj.weight"]
    else:
        width, _, patch, _ = state["vision_model.embeddings.patch_embedding.weight"].shape
        places = state["vision_model.embeddings.position_embedding.weight"]
        layers, last = ["vision_model.encoder.layers."], state["visual_projection.weight"]
    numbers, side = (
        tuple(count(state, name) for name in layers),
        round((len(places) - 1) ** 0.5) * patch,
    )
    return ImageShape(
        kind=clip.kind, patch=patch, width=width, layers=numbers, embed=len(last), side=side
    )


def count(state: State, prefix: str) -> int:
    """Return the number of numbered parts with this prefix."""
    return len({key.removeprefix(prefix).split(".")[0] for key in state if key.startswith(prefix)})


def require_name(name: str, shape: ImageShape, place: object) -> str:
    """Return the name to record; raises DataError if the weights are not of `name`."""
    found = next((known for known, published in PUBLISHED.items() if published == shape), ANY)
    if name in (ANY, found):
        return found
    raise DataError(
        f"'{place}' holds {shape}, and {name} is {PUBLISHED[name]}; use --encoder {found}"
        + (", which takes any size." if found == ANY else ".")
    )


def heads(width: int, stated: int | None, place: object) -> int:
    """Return the number of attention heads: as stated, else one for every 64 channels.

    Raises DataError if neither number divides the width.
    """
    number = stated or width // HEAD_WIDTH
    if number < 1 or width % number or (stated is None and width % HEAD_WIDTH):
        raise DataError(
            f"'{place}' has layers of width {width}, whose attention heads "
            + ("cannot be found from the weights" if stated is None else f"cannot be {stated}")
            + "; put the model's config.json beside the file."
        )
    return number


@dataclass(frozen=True, slots=True, kw_only=True)
class Clip:
    """A CLIP checkpoint in memory: the weights of its towers, and its settings.

    name    name of a published CLIP if its image tower has that shape, else "clip"
    place   the given folder or file
    file    the weights file in it
    """

    name: str
    place: Path
    file: Path
    weights: ClipState
    settings: ClipSettings
    shape: ImageShape | None

    def weight(self, state: State, key: str) -> torch.Tensor:
        """Return a weight of `state`; raises DataError without it."""
        if key not in state:
            raise DataError(f"'{self.file}' lacks the weight '{key}' of {self.name}.")
        return state[key]

    @property
    def image_hash(self) -> str:
        """A hash of the image tower, independent of the file layout."""
        return self._hash(self.weights.image, plain=self.weights.kind == RESNET)

    @property
    def text_hash(self) -> str:
        """A hash of the text tower; "" if the checkpoint has none."""
        return self._hash(self.weights.text) if self.weights.text else ""

    def _hash(self, state: State, *, plain: bool = False) -> str:
        """Return the hash of `state`; GELU in place of QuickGELU changes it unless `plain`."""
        if self.settings.activation == GELU and not plain:
            state = state | {"activation.gelu": torch.ones(1)}
        return state_hash(state)
