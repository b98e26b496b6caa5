"""The file `familiarity.safetensors` of a head folder."""

from pathlib import Path

from safetensors import SafetensorError
from safetensors.torch import load_file, save

from omnivat.calibration.familiarity import Familiarity
from omnivat.errors import DataError
from omnivat.modalities import IMAGES
from omnivat.schema import FLOATS, tensor_table


def save_familiarity(file: Path, found: Familiarity) -> None:
    """Write the rows in half precision, and the quantiles."""
    tensors = {name: rows.half().contiguous() for name, rows in found.rows.items()}
    tensors |= {f"{name}_quantiles": q.contiguous() for name, q in found.quantiles.items()}
    file.write_bytes(save(tensors, metadata={"format": "omnivat-familiarity-1"}))
    file.chmod(0o644)


def load_familiarity(file: Path, width: int) -> Familiarity | None:
    """Return the saved familiarity, or None if there is no file.

    Raises DataError for a file that cannot be read or does not fit the width.
    """
    if not file.is_file():
        return None
    try:
        tensor_table(file, types=FLOATS)
        tensors = load_file(file)
    except (SafetensorError, OSError) as error:
        raise DataError(
            f"'{file}' cannot be read ({error}); copy the head folder again."
        ) from error
    names = [name for name in IMAGES if name in tensors]
    fits = names and all(
        tensors[n].ndim == 2 and tensors[n].shape[1] == width and f"{n}_quantiles" in tensors
        for n in names
    )
    if not fits:
        raise DataError(f"'{file}' does not fit this head; copy the head folder again.")
    return Familiarity(
        rows={name: tensors[name].float() for name in names},
        quantiles={name: tensors[f"{name}_quantiles"].float() for name in names},
    )
