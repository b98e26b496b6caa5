"""Layers of a vision transformer, for weights under timm's names: SITR, Sparsh, T3, AnyTouch 2."""

import re
from functools import partial
from typing import Any

import torch
from torch import Tensor, nn

from omnivat.encoders.weights import Weights, count
from omnivat.kit.errors import DataError

HEAD = 64  # channels of an attention head
LAYER = {  # timm's names of a layer's parts -> those of torch
    "attn.qkv.": "self_attn.in_proj_",
    "attn.proj.": "self_attn.out_proj.",
    "mlp.fc1.": "linear1.",
    "mlp.fc2.": "linear2.",
}
SCALED = re.compile(r"\.(attn\.proj|mlp\.fc2)\.(?:weight|bias)$")  # what layer scales multiply


def transformer(state: Weights, prefix: str = "blocks.", *, eps: float = 1e-5) -> nn.Sequential:
    """Return layers without values, of the number and sizes of those in `state` below `prefix`.

    eps  of the layer norms

    Raises DataError if a weight is missing, or the width is no multiple of 64.
    """
    hidden, width = state[f"{prefix}0.mlp.fc1.weight"].shape
    if width % HEAD:
        raise DataError(
            f"'{state.file}' has layers of width {width}; those of {state.model} are a multiple of"
            f" {HEAD}. Name the file that its authors publish."
        )
    layer = partial(
        nn.TransformerEncoderLayer, width, width // HEAD, hidden, 0.0, "gelu",
        layer_norm_eps=eps, batch_first=True, norm_first=True, device="meta",
    )  # fmt: skip
    return nn.Sequential(*(layer() for _ in range(count(state, prefix))))


def of_torch(state: Weights) -> Weights:
    """Return the weights under the names of `transformer`; layer scales are multiplied in."""
    found: dict[str, Tensor] = {}
    for name, value in state.items():
        if scaled := SCALED.search(name):
            scale = "ls1" if scaled[1] == "attn.proj" else "ls2"
            gamma = state.get(f"{name[: scaled.start()]}.{scale}.gamma", torch.ones(1))
            value = value * gamma.reshape(-1, *[1] * (value.ndim - 1))
        for old, new in LAYER.items():
            name = name.replace(old, new)
        found[name] = value
    return state.renamed(found)


def patches_by(weight: Tensor, *, bias: bool = True) -> nn.ModuleDict:
    """Return a convolution without values, of the shape of `weight`, that cuts images (4-D) or
    films (5-D) into patches.
    """
    kind: Any = nn.Conv2d if weight.ndim == 4 else nn.Conv3d
    width, channels, *sides = weight.shape
    cut = kind(channels, width, sides, sides, bias=bias, device="meta")
    return nn.ModuleDict({"proj": cut})


def empty(*shape: int) -> nn.Parameter:
    """Return a parameter without values."""
    return nn.Parameter(torch.empty(*shape, device="meta"))
