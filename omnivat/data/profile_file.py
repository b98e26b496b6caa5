"""Profiles as files: one `.safetensors` of the channels' statistics, with a checked header."""

from pathlib import Path
from typing import Any

import numpy as np
from safetensors import SafetensorError

from omnivat.data.arranged import known_way
from omnivat.data.arrays import MOST, Column, column, read_arrays, write_arrays
from omnivat.data.embeddings import KEY
from omnivat.data.profile import Channels, Profile
from omnivat.data.relief.files import MOST_PICTURES, packed, unpacked
from omnivat.kit.errors import DataError
from omnivat.kit.files import path_of, replacing, require_regular
from omnivat.kit.schema import LONGEST_NAME
from omnivat.kit.stages import IMAGES

FORMAT = "omnivat-profile-1"


def save_profile(file: str | Path, profile: Profile) -> None:
    """Write a profile, completely or not at all.

    >>> from tempfile import TemporaryDirectory
    >>> from omnivat import EXAMPLES, load_profile
    >>> profile = load_profile(EXAMPLES / "head" / "profile.safetensors")
    >>> with TemporaryDirectory() as folder:
    ...     save_profile(Path(folder) / "copy.safetensors", profile)
    ...     load_profile(Path(folder) / "copy.safetensors").counts == profile.counts
    True
    """
    header = dict(zip(KEY, profile.key, strict=True)) | {"domain": profile.domain}
    columns: dict[str, Column] = {}
    relief = {"relief": profile.relief} if profile.relief else {}
    for name, channel in (profile.channels | relief).items():
        columns |= {
            f"{name}_mean": column(channel.mean),
            f"{name}_variance": column(channel.variance),
        }
        header[f"{name}_count"] = str(channel.count)
    header |= {"step": repr(profile.step)} if profile.step != 1 else {}
    header |= {"lamps": packed(profile.lamps)} if profile.lamps else {}
    header |= {"way": profile.way} if profile.way else {}
    with replacing(file) as temporary:
        write_arrays(temporary, columns, {"format": FORMAT, **header})


def load_profile(file: str | Path) -> Profile:
    """Read a profile.

    Raises DataError with the file name if it is missing, damaged, or of another kind.

    >>> from tempfile import TemporaryDirectory
    >>> from omnivat import EXAMPLES, load_embeddings, profile_of
    >>> pairs = load_embeddings(EXAMPLES / "chirps" / "chirps.safetensors")
    >>> with TemporaryDirectory() as folder:
    ...     file = Path(folder) / "mine.safetensors"
    ...     save_profile(file, profile_of(pairs, domain="mine"))
    ...     load_profile(file).domain
    'mine'
    """
    path = path_of(file)
    require_regular(path)
    try:
        arrays, metadata = read_arrays(path)
        if metadata.get("format") != FORMAT:
            raise ValueError(f"format '{metadata.get('format', 'none'):.60}'")
        kinds = (*IMAGES, "relief")
        channels = {n: _channels(arrays, metadata, n) for n in kinds if f"{n}_mean" in arrays}
        relief = channels.pop("relief", None)
        if relief and {len(channel.mean) for channel in channels.values()} - {len(relief.mean)}:
            raise ValueError("its relief has another width")
        if not 0 <= (step := float(metadata.get("step", "1"))) <= 1:
            raise ValueError("its step is no share from 0 to 1")
        return Profile(
            channels=channels,
            key=(metadata["encoder"], metadata["weights_hash"], metadata["preprocessing"]),
            domain=metadata.get("domain", "")[:LONGEST_NAME],
            step=step,
            lamps=unpacked(metadata["lamps"]) if "lamps" in metadata else None,
            relief=relief,
            way=known_way(metadata.get("way", "")),
        )
    except (SafetensorError, OSError, ValueError, KeyError) as error:
        raise DataError(
            f"'{path}' is no profile ({error!s:.200}). Make one with `python -m omnivat profile"
            f" PICTURES --out {path.name}`."
        ) from error


def _channels(arrays: dict[str, Any], metadata: dict[str, str], name: str) -> Channels:
    mean, variance = (np.array(arrays[f"{name}_{what}"]) for what in ("mean", "variance"))
    count, sound = int(metadata[f"{name}_count"]), mean.dtype == variance.dtype == np.float32
    shaped = mean.ndim == 1 and mean.shape == variance.shape and 0 < count < MOST_PICTURES
    held = sound and shaped and mean.size and np.abs(mean).max() <= MOST
    if not (held and variance.min() >= 0 and variance.max() <= MOST**2):  # false of NaN
        raise ValueError(f"its {name} statistics are not those of numbers up to {MOST:g}")
    return Channels(mean=mean, variance=variance, count=count)
