"""CLIP ViT-B/16 and ViT-L/14: the image tower through `transformers`.

Radford et al., "Learning Transferable Visual Models From Natural Language Supervision", 2021.
"""

from pathlib import Path
from typing import Any

import torch
from PIL import Image
from torch import Tensor

from omnivat.encoders.checkpoints import Checkpoint, find, pick, read_state
from omnivat.encoders.running import one_by_one, pixels, placed, precision_type, state_hash
from omnivat.errors import DataError
from omnivat.packages import need

MEAN = torch.tensor((0.48145466, 0.4578275, 0.40821073))
STD = torch.tensor((0.26862954, 0.26130258, 0.27577711))
PREPROCESSING = "resize 224x224 bicubic, RGB, CLIP mean and std"
PURPOSE = "CLIP's ViT encoders"

VIT_B16 = Checkpoint(
    name="clip-vit-b16",
    hub="openai/clip-vit-base-patch16",
    fetch="hf download openai/clip-vit-base-patch16 --local-dir {folder}",
)
VIT_L14 = Checkpoint(
    name="clip-vit-l14",
    hub="openai/clip-vit-large-patch14",
    fetch="hf download openai/clip-vit-large-patch14 --local-dir {folder}",
)


class ClipVit:
    """The image tower of a CLIP ViT as an `Encoder`."""

    preprocessing = PREPROCESSING

    def __init__(self, name: str, folder: Path, device: torch.device, precision: str) -> None:
        transformers = need("transformers", purpose=PURPOSE)
        config = read_config(folder, name)
        state = pick(read_state(folder, name), ("vision_model.", "visual_projection."))
        network = transformers.CLIPVisionModelWithProjection(config.vision_config)
        fill(network, state, folder, name)
        self.name = name
        self.width = int(config.projection_dim)
        self.weights_hash = state_hash(network.state_dict())
        self.precision = precision
        self._type = precision_type(precision, device)
        self._network = placed(network, device, self._type)
        self._device = device

    def preprocess(self, image: Image.Image) -> Tensor:
        """Return an RGB image as (3, 224, 224)."""
        return pixels(image, MEAN, STD)

    def embed(self, images: Tensor) -> Tensor:
        """Return the projected embeddings (B, D) of preprocessed images (B, 3, 224, 224)."""
        return one_by_one(self._tower, images.to(self._device, self._type))

    def _tower(self, images: Tensor) -> Tensor:
        embeds: Tensor = self._network(pixel_values=images).image_embeds
        return embeds


def load_vit_b16(*, weights: Path | None, device: torch.device, precision: str) -> ClipVit:
    """Load CLIP ViT-B/16 (D = 512)."""
    return ClipVit(VIT_B16.name, find(VIT_B16, weights), device, precision)


def load_vit_l14(*, weights: Path | None, device: torch.device, precision: str) -> ClipVit:
    """Load CLIP ViT-L/14 (D = 768)."""
    return ClipVit(VIT_L14.name, find(VIT_L14, weights), device, precision)


def read_config(folder: Path, name: str) -> Any:
    """Return the settings of a CLIP model; raises DataError when the folder has none."""
    transformers = need("transformers", purpose=PURPOSE)
    if not (folder / "config.json").is_file():
        raise DataError(
            f"'{folder}' has no config.json; name the folder of a {name} checkpoint as "
            "`transformers` saves it."
        )
    try:
        config = transformers.CLIPConfig.from_pretrained(folder)
    except Exception as error:  # a file that is not JSON, or of another model
        raise DataError(
            f"'{folder}/config.json' is not of a CLIP model; fetch {name} again."
        ) from error
    # The towers are built alone, and take the width of their projection from their own part.
    config.vision_config.projection_dim = config.projection_dim
    config.text_config.projection_dim = config.projection_dim
    return config


def fill(network: torch.nn.Module, state: dict[str, Tensor], folder: Path, name: str) -> None:
    """Give `network` its weights; raises DataError when some are missing or of another shape."""
    try:
        missing, _ = network.load_state_dict(state, strict=False)
    except RuntimeError as error:
        raise DataError(
            f"'{folder}' holds weights of other shapes than its config.json says; fetch {name} again."
        ) from error
    if missing:
        raise DataError(
            f"'{folder}' lacks {len(missing)} weights of {name}, such as {missing[0]}; fetch it again."
        )
