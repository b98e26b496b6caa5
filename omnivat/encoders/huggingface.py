"""Any vision model of `transformers` as an encoder: `hf:NAME_OR_FOLDER`.

Pooling is the first of these that the model has: projected image features (models with a text
tower: CLIP, SigLIP, SigLIP 2); the class token (DINOv2, DINOv3, ViT); the model's pooled output
(ConvNeXt, ResNet, vision towers of SigLIP); the mean of all tokens (I-JEPA). File headers state the
pooling.
"""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import torch
from torch import Tensor, nn

from omnivat.encoders import hub
from omnivat.encoders.running import SIDE
from omnivat.encoders.wrapping import IMAGENET_MEAN, IMAGENET_STD, TorchEncoder
from omnivat.kit.errors import DataError, first_line
from omnivat.kit.schema import read_object
from omnivat.kit.tables import need

FEATURES, CLASS_TOKEN = "projected image features", "class token"
POOLED, MEAN_TOKEN = "the model's pooled output", "mean of tokens"


def load(
    model: str,
    *,
    weights: Path | None = None,
    device: torch.device,
    precision: str = "fp32",
    download: str = "ask",
) -> TorchEncoder:
    """Load a vision model from a folder or from the hub.

    model    a folder written by `save_pretrained`, or "owner/name"
    weights  another folder to use instead

    Raises DataError if it does not exist, is not a vision model, or lacks weights.
    """
    folder = _folder(weights or Path(model), model, download)
    network = _network(folder)
    side, mean, std = _image_settings(folder, network.config)
    about = _pooling(network, side)
    return TorchEncoder(
        _Tower(network),
        side=side,
        mean=mean,
        std=std,
        pool=POOLINGS[about],
        about=about,
        device=device,
        precision=precision,
    )


class _Tower(nn.Module):
    """The image part of a model: its state without the text tower."""

    def __init__(self, network: nn.Module) -> None:
        super().__init__()
        if hasattr(network, "text_model"):
            del network.text_model
        self.network = network

    def forward(self, images: Tensor) -> Any:
        """Return the model's output for images (B, 3, side, side)."""
        return getattr(self.network, "get_image_features", self.network)(pixel_values=images)


def _folder(place: Path, model: str, download: str) -> Path:
    if place.is_dir():
        return place
    if place.suffix or model.count("/") != 1 or model.startswith((".", "/", "~")):
        raise DataError(
            f"'{place}' is not a folder with a model of transformers; name one, or OWNER/NAME on"
            " the hub."
        )
    found = hub.fetch(model, download=download)
    if isinstance(found, Path):
        return found
    raise DataError(f"There is no model '{model}' on this machine. {found}")


def _network(folder: Path) -> Any:
    """Load the model. Raises DataError if weights are missing."""
    transformers = need("transformers", purpose="hf: encoders")
    try:
        network, info = transformers.AutoModel.from_pretrained(
            folder, local_files_only=True, output_loading_info=True, dtype=torch.float32
        )
    except Exception as error:  # transformers has a different error for each kind of damaged folder
        raise DataError(
            f"'{folder}' cannot be loaded as a model of transformers: {first_line(error, 160)}"
        ) from error
    missing = sorted(key for key in info["missing_keys"] if not _unused(network, key))
    if missing or info.get("mismatched_keys"):
        wrong = missing or [str(key) for key in info["mismatched_keys"]]
        raise DataError(
            f"'{folder}' lacks {len(wrong)} weights of {type(network).__name__}, such as"
            f" {wrong[0]}; fetch it again."
        )
    return network.eval().requires_grad_(False)


def _unused(network: Any, key: str) -> bool:
    """True for a randomly initialized pooling layer that is not used here."""
    pooled = dict(network.named_children()).keys() & {"pooler", "head", "layernorm"}
    return key.startswith("pooler.") and (_has_class_token(network) or not pooled)


def _has_class_token(network: nn.Module) -> bool:
    return any(name.endswith("cls_token") for name, _ in network.named_parameters())


POOLINGS: Mapping[str, Callable[[Any], Tensor]] = {
    FEATURES: lambda output: getattr(output, "pooler_output", output),
    CLASS_TOKEN: lambda output: output.last_hidden_state[:, 0],
    POOLED: lambda output: output.pooler_output.flatten(1),
    MEAN_TOKEN: lambda output: (
        output.last_hidden_state.flatten(2).mT.mean(1)
        if output.last_hidden_state.ndim == 4
        else output.last_hidden_state.mean(1)
    ),
}


def _pooling(network: Any, side: int) -> str:
    if hasattr(network, "get_image_features"):
        return FEATURES
    if _has_class_token(network):
        return CLASS_TOKEN
    try:
        with torch.inference_mode():
            output = network(pixel_values=torch.zeros(1, 3, side, side))
    except Exception as error:
        raise DataError(
            f"{type(network).__name__} does not take images alone ({str(error)[:120]}); wrap it in "
            "a function of your own and pass --encoder module:function (docs/encoders.md)."
        ) from error
    return POOLED if getattr(output, "pooler_output", None) is not None else MEAN_TOKEN


def _image_settings(folder: Path, config: Any) -> tuple[int, tuple[float, ...], tuple[float, ...]]:
    """Return side, mean and std: of `preprocessor_config.json`, else of the model and ImageNet."""
    file = folder / "preprocessor_config.json"
    stated = read_object(file) if file.is_file() else {}
    vision = getattr(config, "vision_config", config)
    crop = stated.get("crop_size") if stated.get("do_center_crop", True) else None
    side = _side(crop) or _side(stated.get("size")) or _side(getattr(vision, "image_size", SIDE))
    mean, std = stated.get("image_mean") or IMAGENET_MEAN, stated.get("image_std") or IMAGENET_STD
    return side, tuple(mean), tuple(std)


def _side(size: Any) -> int:
    """Return the side of the square given by `size`, a number or edges by name; 0 for none."""
    if isinstance(size, Mapping):
        size = size.get("shortest_edge") or size.get("height")
    return int(size or 0)
