"""Tactile encoders of others from their published weights: Sparsh, T3 and AnyTouch 2.

Names, shapes and inputs of the networks are those of the authors' code; the code here is our own.
Sources: Higuera et al., Sparsh, CoRL 2024 (weights CC BY-NC 4.0); Zhao et al., T3, CoRL 2024
(MIT); Feng et al., AnyTouch 2, ICLR 2026 (MIT)."""

from collections.abc import Mapping
from pathlib import Path

import torch
from PIL import Image
from torch import Tensor, nn

from omnivat.data.rest import minus_rest
from omnivat.encoders.running import CLIP_MEAN, CLIP_STD, SIDE, pixels
from omnivat.encoders.transformer import empty, of_torch, patches_by, transformer
from omnivat.encoders.weights import Weights, read_weights
from omnivat.encoders.wrapping import IMAGENET_MEAN, IMAGENET_STD, TorchEncoder
from omnivat.kit.errors import DataError
from omnivat.kit.tables import suggestion

FRAMES = 4  # of the video networks
PORTRAIT = (320, 240)  # pixels of Sparsh's input, height and width
OFFSET = 130  # grey that AnyTouch 2 gives a pixel that is as at rest
PLAIN = ((0.0, 0.0, 0.0), (1.0, 1.0, 1.0))
TEACHERS = ("target_encoder.", "teacher_encoder.backbone.", "teacher_encoder.", "encoder.")
T3_NAMES = {"gelsight": "gstag", "gelsightmini": "mini"}  # a sensor -> its encoder's file
OF_CLIP = {  # transformers' names of CLIP's parts -> those of timm
    "encoder.layers.": "blocks.",
    "layer_norm": "norm",
    "self_attn.out_proj": "attn.proj",
    "embeddings.patch_embedding": "patch_embed.proj",
    "embeddings.position_embedding.weight": "position_embedding",
    "embeddings.": "",
    "pre_layrnorm": "pre_norm",
    "post_layernorm": "norm",
    "touch_projection": "projection",
}
ANYTOUCH_KINDS = {"gelsight": 0, "digit": 1, "gelsightmini": 3, "duragel": 4}


class Sparsh(nn.Module):
    """Frames (B, 3 T, 320, 240), the newest first -> means of the patch tokens (B, W)."""

    def __init__(self, state: Weights) -> None:
        super().__init__()
        patches = state["patch_embed.proj.weight"]
        width, self.film = len(patches), patches.ndim == 5
        self.frames = FRAMES if self.film else patches.shape[1] // 3
        sides = (self.frames, *PORTRAIT) if self.film else PORTRAIT
        grid = [side // step for side, step in zip(sides, patches.shape[2:], strict=True)]
        self.patch_embed = patches_by(patches)
        self.pos_embed: Tensor
        if "pos_embed" in state:
            self.pos_embed = empty(1, torch.Size(grid).numel(), width)
        else:
            self.register_buffer(
                "pos_embed", waves(grid, state["pos_embed.frequency_bands"], width)
            )
        registers = state.get("register_tokens")
        self.register_tokens = None if registers is None else empty(*registers.shape)
        self.blocks = transformer(state, eps=1e-6)
        self.norm = nn.LayerNorm(width, 1e-6, device="meta")

    def forward(self, images: Tensor) -> Tensor:
        """Return the mean of the patch tokens after the last norm."""
        if self.film:
            images = images.unflatten(1, (self.frames, 3)).transpose(1, 2)
        tokens = self.patch_embed["proj"](images).flatten(2).mT + self.pos_embed
        places = tokens.shape[1]
        if self.register_tokens is not None:
            extra = self.register_tokens.expand(len(tokens), -1, -1)
            tokens = torch.cat((extra, tokens), dim=1)
        seen: Tensor = self.norm(self.blocks(tokens))
        return seen[:, -places:].mean(dim=1)


def waves(grid: list[int], bands: Tensor, width: int) -> Tensor:
    """Return sines and cosines (1, N, W) of the positions of a grid, at `bands` of each axis."""
    axes = torch.meshgrid(*(torch.arange(float(side)) for side in grid), indexing="ij")
    angles = torch.stack(axes, dim=-1).flatten(0, -2)[..., None] * bands
    return torch.cat((angles.sin(), angles.cos()), dim=-1).flatten(1)[None, :, :width]


def load_sparsh(
    weights: Path | None = None, device: torch.device | str = "cpu", precision: str = "fp32"
) -> TorchEncoder:
    """Load Sparsh, of any training (MAE, DINO, DINOv2, I-JEPA, V-JEPA) and size.

    weights  the file that the authors publish

    A picture without one before it stands for all frames. Raises DataError if the file does not
    fit.
    """
    state = read_weights(required(weights, "Sparsh", "facebook/sparsh on the hub"), "Sparsh")
    first = "patch_embed.proj.weight"
    ends = (key for end in TEACHERS for key in state if key.endswith(end + first))
    start = next(ends, first).removesuffix(first)
    state = state.renamed(
        {key.removeprefix(start): value for key, value in state.items() if key.startswith(start)}
    )
    network = Sparsh(state)
    of_torch(state).fill(network)

    def upright(frame: Image.Image) -> Image.Image:
        return frame.transpose(Image.Transpose.ROTATE_270) if frame.width > frame.height else frame

    def prepare(image: Image.Image, before: Image.Image | None = None) -> Tensor:
        newest, oldest = (
            pixels(upright(frame), *PLAIN, PORTRAIT) for frame in (image, before or image)
        )
        later = -(-network.frames // 2)
        return torch.cat([newest] * later + [oldest] * (network.frames - later))

    about = f"turned upright, resize 320x240 bicubic, {network.frames} frames, mean of patch tokens"
    return TorchEncoder(
        network, prepare=prepare, about=about, device=device, precision=precision, name="sparsh"
    )


class T3(nn.Module):
    """Images with the sensor's number as a fourth channel (B, 4, side, side) -> class tokens
    (B, W).
    """

    def __init__(self, sensors: Mapping[str, Weights], trunk: Weights) -> None:
        super().__init__()
        self.sensors = nn.ModuleDict(
            {str(number): T3Sensor(state) for number, state in enumerate(sensors.values())}
        )
        self.trunk = nn.ModuleDict({"blocks": transformer(trunk)})
        self.trunk["norm"] = nn.LayerNorm(len(trunk["norm.weight"]), device="meta")

    def forward(self, images: Tensor) -> Tensor:
        """Return the class token after the trunk's norm."""
        tokens = self.sensors[str(int(images[0, 3, 0, 0]))](images[:, :3])
        found: Tensor = self.trunk["norm"](self.trunk["blocks"](tokens)[:, 0])
        return found


class T3Sensor(nn.Module):
    """The encoder of one sensor: images (B, 3, side, side) -> tokens (B, N, W)."""

    def __init__(self, state: Weights) -> None:
        super().__init__()
        self.patch_embed = patches_by(state["patch_embed.proj.weight"])
        self.cls_token = empty(*state["cls_token"].shape)
        self.pos_embed = empty(*state["pos_embed"].shape)
        self.blocks = transformer(state, eps=1e-6)

    def forward(self, images: Tensor) -> Tensor:
        """Return the tokens, the class token first."""
        tokens = self.patch_embed["proj"](images).flatten(2).mT
        tokens = torch.cat((self.cls_token.expand(len(tokens), -1, -1), tokens), dim=1)
        found: Tensor = self.blocks(tokens + self.pos_embed)
        return found


def load_t3(
    weights: Path | None = None, device: torch.device | str = "cpu", precision: str = "fp32"
) -> TorchEncoder:
    """Load T3: the encoders of its sensors and the trunk that they share.

    weights  a folder with `trunk.pth` and `encoders/<sensor>.pth`

    Raises DataError if a file is missing or does not fit; so does a picture of a sensor that has
    no encoder in the folder.
    """
    place = required(weights, "T3", "alanz-mit/FoundationTactile, a data set on the hub")
    files = {file.stem: file for file in sorted(place.glob("encoders/*.pth"))}
    if not files or not (place / "trunk.pth").is_file():
        raise DataError(f"'{place}' is no folder of T3; name one with trunk.pth and encoders/.")
    parts = {name: read_weights(file, "T3") for name, file in files.items()}
    trunk = read_weights(place / "trunk.pth", "T3")
    network = T3(parts, trunk)
    for part, state in zip(
        (*network.sensors.values(), network.trunk), (*parts.values(), trunk), strict=True
    ):
        of_torch(state).fill(part)
    numbers = {plain(name): number for number, name in enumerate(parts)}
    numbers |= {ours: numbers[name] for ours, name in T3_NAMES.items() if name in numbers}

    def prepare(image: Image.Image, sensor: str) -> Tensor:
        return numbered(pixels(image, IMAGENET_MEAN, IMAGENET_STD), sensor, numbers, "T3")

    about = f"resize {SIDE}x{SIDE} bicubic, ImageNet's mean and std, class token"
    return TorchEncoder(
        network, prepare=prepare, about=about, device=device, precision=precision, name="t3",
        width=len(trunk["norm.weight"]),
    )  # fmt: skip


class AnyTouch2(nn.Module):
    """Frames (B, 3 T + 1, side, side), the oldest first, with the sensor's number as the last
    channel -> projected class tokens (B, D).
    """

    def __init__(self, state: Weights) -> None:
        super().__init__()
        patches = state["patch_embed.proj.weight"]
        width = len(patches)
        self.frames = FRAMES
        self.patch_embed = patches_by(patches, bias=False)
        self.class_embedding = empty(*state["class_embedding"].shape)
        self.position_embedding = empty(*state["position_embedding"].shape)
        self.sensor_token = empty(*state["sensor_token"].shape)
        self.pre_norm = nn.LayerNorm(width, device="meta")
        self.blocks = transformer(state)
        self.norm = nn.LayerNorm(width, device="meta")
        out = len(state["projection.weight"])
        self.projection = nn.Linear(width, out, bias=False, device="meta")

    def forward(self, images: Tensor) -> Tensor:
        """Return the class token after the last norm and the projection."""
        film = images[:, :-1].unflatten(1, (self.frames, 3)).transpose(1, 2)
        tokens = self.patch_embed["proj"](film).flatten(2).mT + self.position_embedding[1:]
        first = self.class_embedding + self.position_embedding[0]
        kind = self.sensor_token[int(images[0, -1, 0, 0])]
        row = torch.cat((first[None], kind, tokens[0]))[None]
        found: Tensor = self.projection(self.norm(self.blocks(self.pre_norm(row))[:, 0]))
        return found


def load_anytouch2(
    weights: Path | None = None, device: torch.device | str = "cpu", precision: str = "fp32"
) -> TorchEncoder:
    """Load the touch tower of AnyTouch 2.

    weights  the file that the authors publish, of the model of four frames

    Raises DataError if the file does not fit; so does a picture of a sensor without a number.
    """
    file = required(weights, "AnyTouch 2", "xxuan01/AnyTouch2-Model on the hub")
    state = of_timm(read_weights(file, "AnyTouch 2"))
    network = AnyTouch2(state)
    of_torch(state).fill(network)
    numbers = ANYTOUCH_KINDS | {str(number): number for number in range(len(state["sensor_token"]))}

    def prepare(
        image: Image.Image, rest: Image.Image, sensor: str, before: Image.Image | None = None
    ) -> Tensor:
        oldest, newest = (
            pixels(minus_rest(frame, rest, offset=OFFSET), CLIP_MEAN, CLIP_STD)
            for frame in (before or image, image)
        )
        film = torch.cat([oldest] * (FRAMES // 2) + [newest] * (FRAMES // 2))
        return numbered(film, sensor, numbers, "AnyTouch 2")

    about = (
        f"difference to the sensor at rest, resize {SIDE}x{SIDE} bicubic, CLIP mean and std,"
        f" {FRAMES} frames, projected class token"
    )
    return TorchEncoder(
        network, prepare=prepare, about=about, device=device, precision=precision,
        name="anytouch2", width=len(state["projection.weight"]),
    )  # fmt: skip


def of_timm(state: Weights) -> Weights:
    """Return the weights of AnyTouch 2's touch tower, a CLIP, under timm's names."""
    found: dict[str, Tensor] = {}
    for key, value in state.items():
        name = key.removeprefix("touch_mae_model.").removeprefix("touch_model.")
        for theirs, ours in OF_CLIP.items():
            name = name.replace(theirs, ours)
        if ".q_proj." in name:
            thirds = (state[key.replace(".q_proj.", f".{part}_proj.")] for part in "qkv")
            name, value = name.replace("self_attn.q_proj", "attn.qkv"), torch.cat([*thirds])
        found[name] = value
    return state.renamed(found)


def required(weights: Path | None, name: str, place: str) -> Path:
    """Return the place of the weights. Raises DataError where none is given."""
    if weights is None:
        raise DataError(
            f"{name} needs the weights that its authors publish ({place}); download them and pass"
            " --tac-weights FILE."
        )
    return weights


def plain(sensor: str) -> str:
    """Return a sensor's name in small letters and digits."""
    return "".join(letter for letter in sensor.lower() if letter.isalnum())


def numbered(image: Tensor, sensor: str, numbers: Mapping[str, int], name: str) -> Tensor:
    """Return an image with the number of its sensor as a further channel.

    sensor  a key of `numbers`, or a text with one, such as "left DIGIT"; the longest counts

    Raises DataError for a sensor without a number.
    """
    given, words = plain(sensor), [key for key in numbers if not key.isdigit()]
    found = [given] if given in numbers else sorted((w for w in words if w in given), key=len)
    if not found:
        raise DataError(
            f"{name} has no sensor '{sensor}', but {', '.join(words)}. Name the domain after its"
            f" sensor, or write ENCODER@SENSOR.{suggestion(given, words)}"
        )
    return torch.cat((image, torch.full_like(image[:1], float(numbers[found[-1]]))))
