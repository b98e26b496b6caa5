"""CLIP's settings that weight shapes do not determine, read from the files next to them."""

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from omnivat.encoders.running import CLIP_MEAN, CLIP_STD
from omnivat.encoders.weights import Weights
from omnivat.errors import DataError

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
    run = weights.training
    plain = run is not None and "quickgelu" not in run.lower()
    if plain or (run is None and weights.file.name.startswith("open_clip")):
        return ClipSettings(activation=GELU)
    return ClipSettings()


def _of_transformers(file: Path, name: str) -> ClipSettings:
    config = _json(file, name)
    kinds = ("clip", "clip_vision_model", "clip_text_model")
    if config.get("model_type", "clip") not in kinds:
        raise DataError(
            f"'{file}' is not of a CLIP model but of '{config['model_type']}'; "
            f"use --encoder hf:{file.parent}."
        )
    image = config.get("vision_config") or config
    text = config.get("text_config") or config
    return ClipSettings(
        activation=str(image.get("hidden_act") or text.get("hidden_act") or QUICK_GELU),
        eps=float(image.get("layer_norm_eps", 1e-5)),
        image=_sizes(image, 12, {"patch": "patch_size", "side": "image_size"}),
        text=_sizes(text, 8, {"eos": "eos_token_id"}),
        **_pixels_of_transformers(file.parent),
    )


def _sizes(config: Mapping[str, Any], heads: int, more: Mapping[str, str]) -> dict[str, int]:
    names = {"width": "hidden_size", "layers": "num_hidden_layers", **more}
    found = {name: int(config[key]) for name, key in names.items() if key in config}
    return {"heads": int(config.get("num_attention_heads", heads)), **found}


def _pixels_of_transformers(folder: Path) -> dict[str, tuple[float, ...]]:
    file = folder / "preprocessor_config.json"
    if not file.is_file():
        return {}
    config = _json(file, "CLIP")
    return {
        name: tuple(map(float, config[key]))
        for name, key in (("mean", "image_mean"), ("std", "image_std"))
        if key in config
    }


def _of_open_clip(file: Path, name: str) -> ClipSettings:
    config = _json(file, name)
    model, pixels = config.get("model_cfg", config), config.get("preprocess_cfg", {})
    vision, text = model.get("vision_cfg"), model.get("text_cfg")
    if not isinstance(vision, dict) or not isinstance(text, dict):
        raise DataError(f"'{file}' is not of a CLIP model; fetch {name} again.")
    stated = {"heads": int(text["heads"])} if "heads" in text else {}
    width = vision.get("head_width")
    of_image = {"heads": int(vision["width"]) // int(width)} if width and "width" in vision else {}
    return ClipSettings(
        activation=QUICK_GELU if model.get("quick_gelu") else GELU,
        mean=tuple(map(float, pixels.get("mean", CLIP_MEAN))),
        std=tuple(map(float, pixels.get("std", CLIP_STD))),
        image=of_image,
        text=stated,
    )


def _json(file: Path, name: str) -> dict[str, Any]:
    try:
        found = json.loads(file.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise DataError(f"'{file}' is not of a CLIP model; fetch {name} again.") from error
    if not isinstance(found, dict):
        raise DataError(f"'{file}' is not of a CLIP model; fetch {name} again.")
    return found
