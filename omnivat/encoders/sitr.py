"""SITR's transformer from its published weights: `--tac-encoder sitr --tac-weights FILE`.

The input of the ViT is the difference of a press to the sensor at rest, with the differences of up
to 18 calibration presses: 9 of a ball, 9 of a cube's corner. `calibration/` next to the weights
has them: `0000.png` at rest, then `0001.png` to `0018.png`. The embedding is the class token after
the last norm. Source: Gupta et al., ICLR 2025; names of weights, order of presses and the pixels'
statistics are those of its code. The decoder of normal maps and the contrastive head are left out.
"""

from math import isqrt
from pathlib import Path

import torch
from PIL import Image
from torch import Tensor, nn

from omnivat.data.images import read_image
from omnivat.encoders.running import pixels
from omnivat.encoders.transformer import HEAD, empty, of_torch, patches_by, transformer
from omnivat.encoders.weights import Weights, read_weights
from omnivat.encoders.wrapping import TorchEncoder
from omnivat.kit.errors import DataError

NAME = "sitr"
MEAN, STD = (-1.2223, -1.8114, -1.7090), (11.7932, 12.7956, 13.6452)  # of differences, 0 to 255
# Number of presses in a checkpoint -> indices among the 18.
PRESSES = {
    0: (),
    4: (1, 3, 7, 9),
    8: (1, 3, 7, 9, 10, 12, 16, 18),
    9: tuple(range(1, 10)),
    18: tuple(range(1, 19)),
}


class Sitr(nn.Module):
    """Differences (B, 3, side, side) to the sensor at rest -> class tokens (B, W).

    state    the weights, which tell all sizes, under the authors' names
    side     of a picture, pixels
    rest     (3, side, side) the sensor at rest, 0 to 255; stored here, so that the hash depends on
             it
    presses  (1, 3 P, side, side) normalised differences of the sensor's calibration; P may be 0
    """

    def __init__(self, state: Weights, *, side: int, rest: Tensor, presses: Tensor) -> None:
        super().__init__()
        patches = state["patch_embed.proj.weight"]
        width, places = len(patches), (side // patches.shape[-1]) ** 2
        self.patch_embed = patches_by(patches)
        self.cls_token = empty(1, 1, width)
        self.pos_embed = empty(1, places + 1, width)
        self.calibrated = bool(presses.shape[1])
        if self.calibrated:
            self.c_patch_embed = patches_by(state["c_patch_embed.proj.weight"])
            self.c_pos_embed = empty(1, places, width)
        self.blocks = transformer(state)
        self.norm = nn.LayerNorm(width, device="meta")
        self.presses: Tensor
        self.register_buffer("rest", rest)
        self.register_buffer("presses", presses)

    def forward(self, images: Tensor) -> Tensor:
        """Return the class token after the last norm."""
        tokens = self.patch_embed["proj"](images).flatten(2).mT + self.pos_embed[:, 1:]
        parts = [(self.cls_token + self.pos_embed[:, :1]).expand(len(images), -1, -1), tokens]
        if self.calibrated:
            own = self.c_patch_embed["proj"](self.presses).flatten(2).mT + self.c_pos_embed
            parts.append(own.expand(len(images), -1, -1))
        found: Tensor = self.norm(self.blocks(torch.cat(parts, dim=1))[:, 0])
        return found


def load(
    weights: Path | None = None, device: torch.device | str = "cpu", precision: str = "fp32"
) -> TorchEncoder:
    """Load SITR from its weights, with the calibration next to them.

    weights  a PyTorch or safetensors file of the base model, or its folder

    Raises DataError if the file or a calibration picture is missing, or a shape differs.
    """
    if weights is None:
        raise DataError(
            "SITR needs its published weights; download them from the authors' data set on the hub,"
            " hgupt3/sitr_dataset, and pass --tac-weights FILE."
        )
    state = read_weights(weights, NAME, r"patch_embed\.proj\.weight")
    side, number = _side(state), _presses(state)
    rest, presses = _calibration(state.file.parent / "calibration", number, side)
    network = Sitr(state, side=side, rest=rest, presses=presses)
    of_torch(state).fill(network)

    def prepare(image: Image.Image) -> Tensor:
        return _normalised(_raw(image, side) - rest)

    about = (
        f"resize {side}x{side} bicubic, difference to the sensor at rest, class token, {number}"
        " presses of calibration"
    )
    return TorchEncoder(
        network, prepare=prepare, about=about, device=device, precision=precision, name=NAME
    )


def _side(state: Weights) -> int:
    """Return the side of the image in pixels."""
    first = state["patch_embed.proj.weight"]
    width, patch = len(first), int(first.shape[-1])
    places = state["pos_embed"].numel() // width - 1
    grid = isqrt(places)
    if width % HEAD or grid**2 != places:
        raise DataError(
            f"'{state.file}' has width {width} and {places} patches; SITR's width is a multiple of"
            f" {HEAD}, and its number of patches is a square. Name the file that SITR's authors"
            " published."
        )
    return grid * patch


def _presses(state: Weights) -> int:
    """Return the number of presses of the checkpoint."""
    weight = state.get("c_patch_embed.proj.weight")
    channels = 0 if weight is None else weight.shape[1]
    if channels % 3 or channels // 3 not in PRESSES:
        raise DataError(
            f"'{state.file}' takes {channels} channels of calibration; three for each of"
            " 0, 4, 8, 9 or 18 presses are known."
        )
    return channels // 3


def _calibration(folder: Path, number: int, side: int) -> tuple[Tensor, Tensor]:
    """Return the sensor at rest (3, side, side), 0 to 255, and the presses (1, 3 P, side, side)."""
    wanted = [folder / f"{index:04d}.png" for index in (0, *PRESSES[number])]
    missing = [file.name for file in wanted if not file.is_file()]
    if missing:
        raise DataError(
            f"SITR needs {len(wanted)} pictures of the sensor's calibration in '{folder}' and"
            f" {missing[0]} is missing ({len(missing)} are); 0000.png is the sensor at rest"
            " (docs/encoders.md)."
        )
    rest, *pressed = [_raw(read_image(file), side) for file in wanted]
    differences = [_normalised(press - rest) for press in pressed]
    return rest, torch.cat([*differences, torch.zeros(0, side, side)])[None]


def _raw(image: Image.Image, side: int) -> Tensor:
    return pixels(image, (0.0,) * 3, (1 / 255,) * 3, side)


def _normalised(difference: Tensor) -> Tensor:
    return (difference - torch.tensor(MEAN)[:, None, None]) / torch.tensor(STD)[:, None, None]
