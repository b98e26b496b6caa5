"""CLIP's settings, from files next to the weights."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from omnivat.encoders.running import CLIP_MEAN, CLIP_STD
from omnivat.encoders.weights import Weights
from omnivat.kit.errors import DataError
from omnivat.kit.schema import read_object

QUICK_GELU, GELU = "quick_gelu", "gelu"
READ = ("num_attention_heads", "layer_norm_eps")  # the weights tell everything else


@dataclass(frozen=True, slots=True, kw_only=True)
class ClipSettings:
    """The activation, pixel statistics, and what a file states of the towers.

    image, text     settings of transformers' `CLIPVisionConfig` and `CLIPTextConfig`
    """

    image: Mapping[str, Any]
    text: Mapping[str, Any]
    activation: str
    mean: tuple[float, ...] = CLIP_MEAN
    std: tuple[float, ...] = CLIP_STD


def clip_settings(weights: Weights) -> ClipSettings:
    """Return the settings for weights, from `config.json` or `open_clip_config.json` beside them.

    Without either: QuickGELU, as OpenAI trained; GELU for open_clip's own files.
    Raises DataError if such a file belongs to another kind of model.
    """
    folder, of_open_clip = weights.file.parent, weights.file.name.startswith("open_clip")
    if (folder / "config.json").is_file() and not of_open_clip:
        return _of_transformers(folder / "config.json")
    if (folder / "open_clip_config.json").is_file():
        return _of_open_clip(folder / "open_clip_config.json")
    return ClipSettings(image={}, text={}, activation=GELU if of_open_clip else QUICK_GELU)


def _of_transformers(file: Path) -> ClipSettings:
    config = read_object(file)
    if config.get("model_type", "clip") not in ("clip", "clip_vision_model", "clip_text_model"):
        raise DataError(
            f"'{file}' is not of a CLIP model but of '{config['model_type']}'; use --encoder"
            f" hf:{file.parent}."
        )
    beside = file.with_name("preprocessor_config.json")
    pixels = read_object(beside) if beside.is_file() else {}
    image, text = (config.get(f"{part}_config") or config for part in ("vision", "text"))
    return ClipSettings(
        image={"num_attention_heads": 12} | {key: image[key] for key in READ if key in image},
        text={"num_attention_heads": 8} | {key: text[key] for key in READ if key in text},
        activation=image.get("hidden_act") or QUICK_GELU,
        mean=tuple(pixels.get("image_mean", CLIP_MEAN)),
        std=tuple(pixels.get("image_std", CLIP_STD)),
    )


def _of_open_clip(file: Path) -> ClipSettings:
    config = read_object(file)
    model, pixels = config.get("model_cfg", {}), config.get("preprocess_cfg", {})
    vision, text = model.get("vision_cfg", {}), model.get("text_cfg", {})
    image = {}
    if "head_width" in vision:
        image["num_attention_heads"] = vision["width"] // vision["head_width"]
    return ClipSettings(
        image=image,
        text={"num_attention_heads": text["heads"]} if "heads" in text else {},
        activation=QUICK_GELU if model.get("quick_gelu") else GELU,
        mean=tuple(pixels.get("mean", CLIP_MEAN)),
        std=tuple(pixels.get("std", CLIP_STD)),
    )
