"""A profile on disk: a small `.safetensors` with mean and variance of each modality."""

from pathlib import Path
from typing import Any

import numpy as np
from safetensors import SafetensorError

from omnivat.data.arrays import Column, column, read_arrays, write_arrays
from omnivat.data.profile import Channels, Profile
from omnivat.errors import DataError
from omnivat.files import replacing
from omnivat.schema import LONGEST_NAME
from omnivat.stages import IMAGES

FORMAT = "omnivat-profile-1"
MOST_BYTES = 4_000_000  # of a profile file: two modalities of 65,536 channels take 1 MB
KEY = ("encoder", "weights_hash", "preprocessing")


def save_profile(file: str | Path, profile: Profile) -> None:
    """Write a profile, completely or not at all."""
    columns: dict[str, Column] = {}
    counts: dict[str, str] = {}
    for name, one in profile.channels.items():
        columns |= {f"{name}_mean": column(one.mean), f"{name}_variance": column(one.variance)}
        counts[f"{name}_count"] = str(one.count)
    header = dict(zip(KEY, profile.key, strict=True)) | {"domain": profile.domain} | counts
    if profile.step != 1:
        header["step"] = repr(profile.step)
    with replacing(file) as temporary:
        write_arrays(temporary, columns, {"format": FORMAT, **header})


def load_profile(file: str | Path) -> Profile:
    """Read a profile.

    Raises DataError with the file name if it is missing, damaged, or of another kind.
    """
    path = Path(file)
    if not path.is_file():
        raise DataError(f"No profile at '{path}'. Make one with `python -m omnivat profile PICTURES --out {path}`.")
    if path.stat().st_size > MOST_BYTES:
        raise DataError(f"'{path}' is larger than {MOST_BYTES / 1e6:g} MB; it is no profile.")
    try:
        arrays, metadata = read_arrays(path)
        if metadata.get("format") != FORMAT:
            raise DataError(
                f"'{path}' is not a profile (format '{metadata.get('format', 'none'):.60}'). Make one "
                "with `python -m omnivat profile`."
            )
        return Profile(
            channels={n: _channels(arrays, metadata, n) for n in IMAGES if f"{n}_mean" in arrays},
            key=(metadata["encoder"], metadata["weights_hash"], metadata["preprocessing"]),
            domain=metadata.get("domain", "")[:LONGEST_NAME],
            step=_step(metadata),
        ).checked()
    except (SafetensorError, OSError, ValueError, KeyError) as error:
        raise DataError(f"'{path}' cannot be read as a profile ({error!s:.200}); make it again.") from error


def _step(metadata: dict[str, str]) -> float:
    step = float(metadata.get("step", "1"))
    if not 0 <= step <= 1:
        raise ValueError("its step is no share from 0 to 1")
    return step


def _channels(arrays: dict[str, Any], metadata: dict[str, str], name: str) -> Channels:
    mean, variance = (np.array(arrays[f"{name}_{what}"]) for what in ("mean", "variance"))
    good = (
        mean.dtype == variance.dtype == np.float32
        and mean.ndim == 1
        and mean.shape == variance.shape
        and len(mean) > 0
        and np.isfinite([mean, variance]).all()
        and (variance >= 0).all()
        and 0 < int(metadata[f"{name}_count"]) < 10**12
    )
    if not good:
        raise ValueError(f"its {name} statistics are no finite means and variances")
    return Channels(mean=mean, variance=variance, count=int(metadata[f"{name}_count"]))
