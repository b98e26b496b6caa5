"""Check the axes of tensors in public functions."""

from typing import Any

import numpy as np
import torch
from torch import Tensor
from torch.nn.functional import normalize

from omnivat.kit.errors import DataError, ShapeError, first_line

KEPT = (torch.float32, torch.float64, torch.complex64, torch.complex128)
SUMMED = 1e15  # the largest value whose square can be summed in single precision


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


def features(least: int = 1, *, most: float = float("inf"), **sets: Any) -> list[Tensor]:
    """Return sets of features (N, D) of one width, tensors or arrays, as floating-point tensors.

    least  rows of each set
    most   the largest magnitude; SUMMED where squares are summed without scaling first

    Whole numbers and half precision become single precision. Raises ShapeError for other axes or
    too few rows; DataError, with its row and column, for a value that is not finite or above
    `most`.

    >>> import torch
    >>> features(a=torch.tensor([[1, 2]]))
    [tensor([[1., 2.]])]
    >>> features(a=torch.tensor([[1.0, 2.0], [3.0, float("nan")]]))
    Traceback (most recent call last):
        ...
    omnivat.kit.errors.DataError: a has nan in row 1, column 1, expected finite numbers; leave ...
    """
    found = {name: floating(name, values) for name, values in sets.items()}
    letters = zip("NMQ", found.items(), strict=False)
    require_shapes(**{name: (values, f"{letter} D") for letter, (name, values) in letters})
    dtypes = {values.dtype for values in found.values()}
    for name, values in found.items():
        if len(values) < least:
            raise ShapeError(
                f"{name} has {len(values)} rows; this needs {least} or more. Choose a larger set."
            )
        require_finite(name, values, most)
    wide = torch.float64 if torch.float64 in dtypes else torch.float32
    return [values.to(wide) for values in found.values()]


def floating(name: str, numbers: Any) -> Tensor:
    """Return real numbers of any kind as a tensor in single or double precision. Raises DataError
    for anything else.
    """
    values = tensor_of(name, numbers)
    if values.is_complex():
        raise DataError(f"{name} has complex numbers; give their real part or their modulus.")
    if values.is_meta:
        raise DataError(f"{name} has no values; give a dense tensor.")
    return values


def tensor_of(name: str, values: Any) -> Tensor:
    """Return numbers of any kind, a tensor, an array or a list, as a dense tensor in single or
    double precision, real or complex. Raises DataError for anything else.
    """
    if not isinstance(values, Tensor):
        try:
            array = np.asarray(values)
        except Exception as error:  # of rows of several lengths, and any of an object of others
            raise DataError(
                f"{name} has rows of several lengths, or is no array ({first_line(error)}); give an"
                " array of numbers."
            ) from error
        if array.dtype.kind not in "fcbiu":
            raise DataError(f"{name} holds values of type {array.dtype}; give numbers.")
        kind, parts = ("c", 2) if array.dtype.kind == "c" else ("f", 1)
        wide = array.dtype.itemsize > 4 * parts
        return torch.from_numpy(array.astype(f"{kind}{(8 if wide else 4) * parts}"))
    single = torch.complex64 if values.is_complex() else torch.float32
    return dense(name, values, values.dtype if values.dtype in KEPT else single)


def dense(name: str, values: Tensor, dtype: torch.dtype) -> Tensor:
    """Return a tensor of numbers in a precision. Raises DataError for a sparse, nested or quantised
    one.
    """
    if values.layout != torch.strided or values.is_nested:
        raise DataError(f"{name} is sparse or nested; give a dense tensor.")
    try:
        return values.to(dtype)
    except (RuntimeError, NotImplementedError) as error:  # of quantised numbers and bits
        raise DataError(f"{name} holds values of type {values.dtype}; give numbers.") from error


def require_finite(name: str, rows: Tensor, most: float = float("inf")) -> None:
    """Raise DataError, with row and column, for a value of rows (N, D) that is not finite or above
    `most`. In a program being exported nothing is read.
    """
    if torch.compiler.is_exporting() or not rows.numel():
        return
    limit = min(most, torch.finfo(rows.dtype).max) if rows.is_floating_point() else most
    size = rows.detach().abs()
    if size.max() <= limit:  # false of NaN
        return
    row, column = (~(size <= limit)).nonzero()[0].tolist()
    wanted = f"at most {most:g}" if most < float("inf") else "finite numbers"
    raise DataError(
        f"{name} has {float(rows[row, column]):g} in row {row}, column {column}, expected {wanted};"
        " leave that row out, or scale all rows."
    )


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
