"""Determine the network from the shapes of CLIP's weights, and check its name."""

from dataclasses import dataclass

from omnivat.encoders.clip_names import RESNET, VIT, ClipState, State
from omnivat.errors import DataError

ANY = "clip"  # name for CLIP of any size
HEAD = 64  # channels of one attention head in every published CLIP


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
            return f"a ResNet of {layers} blocks from width {self.width}, D {self.embed}, {self.side} px"
        return (
            f"a ViT of patch {self.patch}, {layers} layers of width {self.width}, D {self.embed}, "
            f"{self.side} px"
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
    return _resnet_shape(clip.image) if clip.kind == RESNET else _vit_shape(clip.image)


def _vit_shape(state: State) -> ImageShape:
    width, _, patch, _ = state["vision_model.embeddings.patch_embedding.weight"].shape
    places = len(state["vision_model.embeddings.position_embedding.weight"]) - 1
    return ImageShape(
        kind=VIT,
        patch=patch,
        width=width,
        layers=(count(state, "vision_model.encoder.layers."),),
        embed=len(state["visual_projection.weight"]),
        side=round(places**0.5) * patch,
    )


def _resnet_shape(state: State) -> ImageShape:
    places = len(state["attnpool.positional_embedding"]) - 1
    return ImageShape(
        kind=RESNET,
        patch=32,
        width=len(state["layer1.0.conv1.weight"]),
        layers=tuple(count(state, f"layer{stage}.") for stage in (1, 2, 3, 4)),
        embed=len(state["attnpool.c_proj.weight"]),
        side=round(places**0.5) * 32,
    )


def count(state: State, prefix: str) -> int:
    """Return the number of numbered parts with this prefix."""
    return len({key.removeprefix(prefix).split(".")[0] for key in state if key.startswith(prefix)})


def name_of(shape: ImageShape) -> str:
    """Return the name of a published CLIP of that shape, or "clip"."""
    return next((name for name, known in PUBLISHED.items() if known == shape), ANY)


def require_name(name: str, shape: ImageShape, place: object) -> str:
    """Return the name to record; raises DataError if the weights are not of `name`."""
    found = name_of(shape)
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
    number = stated or width // HEAD
    if number < 1 or width % number or (stated is None and width % HEAD):
        raise DataError(
            f"'{place}' has layers of width {width}, whose attention heads "
            + ("cannot be found from the weights" if stated is None else f"cannot be {stated}")
            + "; put the model's config.json beside the file."
        )
    return number
