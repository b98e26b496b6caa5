"""Check the axes of tensors in public functions."""

from typing import Protocol

import torch
from torch import Tensor
from torch.nn.functional import normalize

from omnivat.kit.errors import ShapeError

AT_ONCE = 4096  # rows scaled at once, so that temporaries stay in the cache


class Shaped(Protocol):
    """Anything with a shape: a torch tensor or a numpy array."""

    @property
    def shape(self) -> tuple[int, ...]: ...


def require_shapes(**tensors: tuple[Shaped, str]) -> dict[str, int]:
    """Check named tensors against axes such as "B D"; return the size of each letter.

    The same letter means the same size. "..." means any leading axes.
    Raises ShapeError with the tensor's name, its shape and the expected shape.
    """
    sizes: dict[str, int] = {}
    for name, (tensor, axes) in tensors.items():
        letters = axes.split()
        shape = tuple(tensor.shape)
        tail = shape
        if letters and letters[0] == "...":
            letters = letters[1:]
            tail = shape[len(shape) - len(letters) :] if len(shape) >= len(letters) else ()
        fits = len(tail) == len(letters) and all(
            sizes.get(letter, size) == size for letter, size in zip(letters, tail, strict=True)
        )
        if not fits:
            known = ", ".join(f"{letter}={sizes[letter]}" for letter in letters if letter in sizes)
            known = f" with {known} from the tensors before it" if known else ""
            wanted = ", ".join(axes.split())
            raise ShapeError(f"{name} has shape {shape}, expected ({wanted}){known}.")
        sizes.update(zip(letters, tail, strict=True))
    return sizes


def unit(x: Tensor) -> Tensor:
    """Return x (..., D) scaled to unit length, denormal to the largest float: no overflow or
    underflow.

    Each row is first divided by its largest entry. A row of zeros stays zero and has no gradient.
    """
    # len(x) would fix an exported program's rows
    if x.ndim == 2 and x.shape[0] > AT_ONCE and not x.requires_grad:
        out = torch.empty_like(x)
        for rows, into in zip(x.split(AT_ONCE), out.split(AT_ONCE), strict=True):
            into.copy_(unit(rows))
        return out
    # 20 times as fast as torch's norm of order inf
    longest = x.detach().abs().amax(-1, keepdim=True)
    found = normalize(x / longest.where(longest > 0, 1), dim=-1)
    if not found.requires_grad:
        return found
    return torch.where(longest > torch.finfo(x.dtype).tiny, found, found.detach())
