"""Open a CLIP checkpoint: find it, read it, check its name."""

from dataclasses import dataclass
from pathlib import Path

import torch

from omnivat.encoders.clip_names import MARKS, ClipState, clip_state
from omnivat.encoders.clip_settings import GELU, ClipSettings, clip_settings
from omnivat.encoders.hub import Checkpoint, find
from omnivat.encoders.running import state_hash
from omnivat.encoders.weights import Weights, count, read_weights
from omnivat.kit.errors import DataError

ANY = "clip"  # name for CLIP of any size
_OPENAI = (
    "curl -L --create-dirs -o {folder}/%s.pt"
    " https://openaipublic.azureedge.net/clip/models/%s/%s.pt"
)
_ON_HUB = {  # name -> repository, megabytes
    "clip-vit-b32": ("openai/clip-vit-base-patch32", 605),
    "clip-vit-b16": ("openai/clip-vit-base-patch16", 599),
    "clip-vit-l14": ("openai/clip-vit-large-patch14", 1711),
    "clip-vit-l14-336": ("openai/clip-vit-large-patch14-336", 1712),
}
_AT_OPENAI = {  # name -> file, hash in its address
    "clip-rn50": ("RN50", "afeb0e10f9e5a86da6080e35cf09123aca3b358a0c3e3b6c78a7b63bc04b6762"),
    "clip-rn101": ("RN101", "8fa8567bab74a42d41c5915025a8e4538c3bdbe8804a470a72f30b0d94fab599"),
}
_FETCH = "hf download %s --local-dir {folder}"
CHECKPOINTS = {
    **{
        name: Checkpoint(name=name, hub=hub, fetch=_FETCH % hub, megabytes=size)
        for name, (hub, size) in _ON_HUB.items()
    },
    **{
        name: Checkpoint(name=name, fetch=_OPENAI % (file, digest, file))
        for name, (file, digest) in _AT_OPENAI.items()
    },
    ANY: Checkpoint(name=ANY, fetch=_FETCH % "OWNER/NAME"),
}


@dataclass(frozen=True, slots=True)
class ImageShape:
    """Sizes of an image tower.

    patch   side of a ViT's patch in pixels; 0 for a ResNet
    width   channels: of a ViT's tokens, of a ResNet's first stage
    layers  of a ViT; blocks of each stage of a ResNet
    embed   D, the length of an embedding
    side    of the image, pixels
    """

    patch: int
    width: int
    layers: tuple[int, ...]
    embed: int
    side: int


PUBLISHED = {
    "clip-vit-b32": ImageShape(32, 768, (12,), 512, 224),
    "clip-vit-b16": ImageShape(16, 768, (12,), 512, 224),
    "clip-vit-l14": ImageShape(14, 1024, (24,), 768, 224),
    "clip-vit-l14-336": ImageShape(14, 1024, (24,), 768, 336),
    "clip-rn50": ImageShape(0, 64, (3, 4, 6, 3), 1024, 224),
    "clip-rn101": ImageShape(0, 64, (3, 4, 23, 3), 512, 224),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Clip:
    """A CLIP checkpoint in memory: the weights of its towers, and its settings.

    name    name of a published CLIP if its image tower has that shape, else "clip"
    place   the given folder or file
    file    the weights file in it
    shape   of the image tower; None without one
    """

    name: str
    place: Path
    file: Path
    weights: ClipState
    settings: ClipSettings
    shape: ImageShape | None

    @property
    def image_hash(self) -> str:
        """A hash of the image tower, independent of the file layout."""
        return self._hash(self.weights.image, gelu=not self.weights.resnet)

    @property
    def text_hash(self) -> str:
        """A hash of the text tower; "" if the checkpoint has none."""
        return self._hash(self.weights.text, gelu=True) if self.weights.text else ""

    def _hash(self, state: Weights, *, gelu: bool) -> str:
        """Return the hash of `state`; GELU in place of QuickGELU changes it, if it has either."""
        if gelu and self.settings.activation == GELU:
            return state_hash(state | {"activation.gelu": torch.ones(1)})
        return state_hash(state)


def open_clip(name: str, weights: Path | None, *, download: str = "ask") -> Clip:
    """Find and read the checkpoint called `name`, or the one at `weights`.

    download  "ask", "yes" or "no": permission to fetch a missing one (see `hub.py`)

    Raises DataError if it is missing, not a CLIP, or of another size than its name states.
    """
    place = find(CHECKPOINTS[name], weights, download=download)
    checkpoint = read_weights(place, name, *MARKS)
    state = clip_state(checkpoint)
    if not state.image and not state.text:
        raise DataError(
            f"'{checkpoint.file}' holds no weights of CLIP (its first name is"
            f" '{min(checkpoint, default='none')}'); name a checkpoint of CLIP, or use --encoder"
            " hf:FOLDER for another model of transformers."
        )
    shape = image_shape(state) if state.image else None
    return Clip(
        name=name if shape is None else require_name(name, shape, checkpoint.file),
        place=place,
        file=checkpoint.file,
        weights=state,
        settings=clip_settings(checkpoint),
        shape=shape,
    )


def image_shape(clip: ClipState) -> ImageShape:
    """Return the sizes of an image tower. Raises DataError for a missing weight."""
    state = clip.image
    if clip.resnet:
        patch, width = 0, len(state["layer1.0.conv1.weight"])
        places, last = state["attnpool.positional_embedding"], state["attnpool.c_proj.weight"]
        layers = [f"layer{stage}." for stage in (1, 2, 3, 4)]
    else:
        width, _, patch, _ = state["vision_model.embeddings.patch_embedding.weight"].shape
        places = state["vision_model.embeddings.position_embedding.weight"]
        layers, last = ["vision_model.encoder.layers."], state["visual_projection.weight"]
    return ImageShape(
        patch=patch,
        width=width,
        layers=tuple(count(state, name) for name in layers),
        embed=len(last),
        # the last map of a ResNet has a stride of 32 pixels
        side=round((len(places) - 1) ** 0.5) * (patch or 32),
    )


def require_name(name: str, shape: ImageShape, place: object) -> str:
    """Return the name to record; raises DataError if the weights are not of `name`."""
    right = next((known for known, published in PUBLISHED.items() if published == shape), ANY)
    if name in (ANY, right):
        return right
    raise DataError(
        f"'{place}' does not hold the weights of {name} but {shape}; use --encoder {right}"
        + (", which takes any size." if right == ANY else ".")
    )
