"""CLIP's settings, from files next to the weights."""

import json
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from omnivat.encoders.running import CLIP_MEAN, CLIP_STD
from omnivat.encoders.weights import Weights
from omnivat.kit.errors import DataError

QUICK_GELU, GELU = "quick_gelu", "gelu"
# What is read of a configuration of transformers; the other sizes come from the weights.
READ = (
    "num_attention_heads",
    "hidden_size",
    "num_hidden_layers",
    "patch_size",
    "image_size",
    "eos_token_id",
    "layer_norm_eps",
)


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

    Without either: QuickGELU, as OpenAI trained; GELU for open_clip's own files and training
    checkpoints, unless the run's name contains "quickgelu".
    Raises DataError if such a file belongs to another kind of model.
    """
    folder = weights.file.parent
    if (folder / "config.json").is_file() and "open_clip" not in weights.file.name:
        return _of_transformers(folder / "config.json")
    if (folder / "open_clip_config.json").is_file():
        return _of_open_clip(folder / "open_clip_config.json")
    run, of_open_clip = weights.training, weights.file.name.startswith("open_clip")
    gelu = of_open_clip if run is None else "quickgelu" not in run.lower()
    return ClipSettings(image={}, text={}, activation=GELU if gelu else QUICK_GELU)


def _of_transformers(file: Path) -> ClipSettings:
    config = _json(file)
    if config.get("model_type", "clip") not in ("clip", "clip_vision_model", "clip_text_model"):
        raise DataError(
            f"'{file}' is not of a CLIP model but of '{config['model_type']}'; use --encoder"
            f" hf:{file.parent}."
        )
    beside = file.with_name("preprocessor_config.json")
    pixels = _json(beside) if beside.is_file() else {}
    image, text = (config.get(f"{part}_config") or config for part in ("vision", "text"))
    return ClipSettings(
        image={"num_attention_heads": 12} | {key: image[key] for key in READ if key in image},
        text={"num_attention_heads": 8} | {key: text[key] for key in READ if key in text},
        activation=image.get("hidden_act") or text.get("hidden_act") or QUICK_GELU,
        mean=_three(pixels.get("image_mean", CLIP_MEAN)),
        std=_three(pixels.get("image_std", CLIP_STD)),
    )


def _of_open_clip(file: Path) -> ClipSettings:
    config = _json(file)
    model, pixels = config.get("model_cfg", config), config.get("preprocess_cfg", {})
    vision, text = model.get("vision_cfg"), model.get("text_cfg")
    if not isinstance(vision, dict) or not isinstance(text, dict):
        raise DataError(f"'{file}' is not of a CLIP model; fetch it again.")
    image = {}
    if "head_width" in vision and "width" in vision:
        image["num_attention_heads"] = vision["width"] // vision["head_width"]
    return ClipSettings(
        image=image,
        text={"num_attention_heads": text["heads"]} if "heads" in text else {},
        activation=QUICK_GELU if model.get("quick_gelu") else GELU,
        mean=_three(pixels.get("mean", CLIP_MEAN)),
        std=_three(pixels.get("std", CLIP_STD)),
    )


def _three(values: Any) -> tuple[float, ...]:
    return tuple(map(float, values))


def _json(file: Path) -> dict[str, Any]:
    with suppress(OSError, ValueError):
        if isinstance(content := json.loads(file.read_text(encoding="utf-8")), dict):
            return content
    raise DataError(f"'{file}' is not of a CLIP model; fetch it again.")
