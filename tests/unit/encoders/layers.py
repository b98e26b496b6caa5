"""Layers of vision transformers under timm's names: their shapes, and their values by hand."""

import torch
from torch import nn

HEAD = 64


def shapes(width, depth, prefix="blocks.", scales=False):
    """Return name -> shape of the weights of `depth` layers."""
    inner = {
        "attn.qkv": (3 * width, width),
        "attn.proj": (width, width),
        "mlp.fc1": (4 * width, width),
        "mlp.fc2": (width, 4 * width),
        "norm1": (width,),
        "norm2": (width,),
    }
    found = {}
    for block in (f"{prefix}{index}" for index in range(depth)):
        for name, shape in inner.items():
            found |= {f"{block}.{name}.weight": shape, f"{block}.{name}.bias": shape[:1]}
        found |= {f"{block}.{one}.gamma": (width,) for one in ("ls1", "ls2") if scales}
    return found


def filled(sizes, seed=0):
    """Return random weights of these shapes."""
    random = torch.Generator().manual_seed(seed)
    return {n: torch.randn(s, generator=random) / s[-1] ** 0.5 for n, s in sizes.items()}


def part(state, name, function, x, *more):
    """Return a function of `x` with a part's weight and bias."""
    return function(x, *more, state[f"{name}.weight"], state[f"{name}.bias"])


def by_hand(state, tokens, depth, prefix="blocks.", eps=1e-5):
    """Return tokens (B, N, W) after `depth` layers."""
    norm, linear, width = nn.functional.layer_norm, nn.functional.linear, tokens.shape[-1]

    def normed(name, x):
        return norm(x, (width,), state[f"{name}.weight"], state[f"{name}.bias"], eps)

    for block in (f"{prefix}{index}" for index in range(depth)):
        query, key, value = (
            one.unflatten(2, (-1, HEAD)).transpose(1, 2)
            for one in part(
                state, f"{block}.attn.qkv", linear, normed(f"{block}.norm1", tokens)
            ).chunk(3, dim=2)
        )
        seen = ((query @ key.mT / 8).softmax(-1) @ value).transpose(1, 2).flatten(2)
        scales = [state.get(f"{block}.{one}.gamma", 1.0) for one in ("ls1", "ls2")]
        tokens = tokens + scales[0] * part(state, f"{block}.attn.proj", linear, seen)
        hidden = part(state, f"{block}.mlp.fc1", linear, normed(f"{block}.norm2", tokens))
        hidden = nn.functional.gelu(hidden)
        tokens = tokens + scales[1] * part(state, f"{block}.mlp.fc2", linear, hidden)
    return tokens
