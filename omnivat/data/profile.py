"""Profiles: mean and variance of every embedding channel over pictures of one domain, without
labels.

A new sensor shifts and stretches the channels. Its profile, matched to the source's, undoes that:
no label, no gradient, no training. The idea is AdaBN's (Li et al., arXiv:1603.04779), applied to
the encoder's output; a no-contact picture subtracted from each tactile image does the same for
pixels.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from tempfile import TemporaryFile
from typing import Any

import numpy as np
from numpy.typing import NDArray

from omnivat.data.arrays import LARGE_BYTES, require_range, row_numbers, walked
from omnivat.data.embeddings import Embeddings
from omnivat.data.relief import Lamps
from omnivat.data.relief.files import touch_of, unmarked
from omnivat.kit.errors import DataError
from omnivat.kit.stages import IMAGES

Array = NDArray[np.float32]
MEAN_PRIOR, VARIANCE_PRIOR = 4, 10  # pictures that the source's mean and variance weigh
STEP_SHIFTED = 0.875  # of a head trained with imitated sensors (docs/decisions/0009)


@dataclass(frozen=True, slots=True, kw_only=True)
class Channels:
    """Statistics of one modality: mean and variance (W,) over `count` pictures."""

    mean: Array
    variance: Array
    count: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Profile:
    """Channel statistics of one domain, for each modality by itself, and its lamps.

    channels  "vis", "tac" or both
    key       the encoder of the pictures: name, hash of the weights, preprocessing
    domain    name of the domain; "" if it has none
    step      of a head's source: the share of the way that another sensor is moved onto it

    lamps     of the sensor; None if they are not known
    relief    statistics of the same touches drawn as their relief by these lamps, for heads that
              read it; None without, or where `channels` are by relief themselves
    way       how its touches were arranged before they were read (`omnivat.data.arranged`)

    Raises DataError without channels, or for two widths.
    """

    channels: dict[str, Channels]
    key: tuple[str, str, str]
    domain: str = ""
    step: float = 1.0
    lamps: Lamps | None = None
    relief: Channels | None = None
    way: str = ""

    def __post_init__(self) -> None:
        if len({len(channel.mean) for channel in self.channels.values()}) != 1:
            raise DataError("A profile needs one modality or two of equal width.")

    @property
    def width(self) -> int:
        """W, the encoder's width."""
        return len(next(iter(self.channels.values())).mean)

    def read_by(self, key: tuple[str, str, str]) -> "Profile":
        """Return the profile as a head of this encoder reads it: by relief, or by colours and
        relief side by side, where it holds them.
        """
        mine = *key[:2], unmarked(key[2])
        if self.relief is None or key == self.key or mine != self.key:
            return self
        channels = self.channels | {"tac": self.relief}
        if touch_of(key[2]) == "both":
            nothing = np.zeros_like(self.relief.mean)
            beside = {"vis": replace(self.relief, mean=nothing, variance=nothing)}
            beside["tac"] = self.relief
            channels = {
                name: wide(channel, beside[name]) for name, channel in self.channels.items()
            }
        return replace(self, channels=channels, key=key, relief=None)

    @property
    def counts(self) -> dict[str, int]:
        """Number of pictures by modality."""
        return {name: channel.count for name, channel in self.channels.items()}


def channels_of(rows: Array, index: NDArray[np.int64] | None = None) -> Channels:
    """Return the statistics of rows (N, W), in one walk in double precision.

    Raises DataError without rows.

    >>> import numpy as np
    >>> found = channels_of(np.array([[0.0, 5.0], [4.0, 5.0]], dtype=np.float32))
    >>> found.count, found.mean.tolist(), found.variance.tolist()
    (2, [2.0, 5.0], [4.0, 0.0])
    """
    count, total, squares, start = 0, 0.0, 0.0, None
    for block in require_range(walked(rows, index), "A profile's picture"):
        wide = block.astype(np.float64)
        start = wide[0].copy() if start is None else start  # near the mean: no cancellation
        with np.errstate(invalid="ignore"):  # the loss reports values that are not finite
            wide -= start
            squares = squares + np.square(wide).sum(0)
        count, total = count + len(wide), total + wide.sum(0)
    if start is None:
        raise DataError("A profile needs one picture or more; there are none.")
    offset = np.asarray(total) / count
    variance = np.maximum(np.asarray(squares) / count - offset**2, 0)
    return Channels(
        mean=(start + offset).astype(np.float32), variance=variance.astype(np.float32), count=count
    )


def wide(first: Channels, other: Channels) -> Channels:
    """Return the statistics of embeddings side by side, of the pictures of the first."""
    mean, variance = (
        np.concatenate([getattr(side, name) for side in (first, other)])
        for name in ("mean", "variance")
    )
    return replace(first, mean=mean, variance=variance)


def joined(first: Channels, other: Channels) -> Channels:
    """Return the statistics of two sets of pictures together, in double precision.

    >>> import numpy as np
    >>> rows = np.array([[0.0], [2.0], [7.0]], dtype=np.float32)
    >>> found = joined(channels_of(rows[:2]), channels_of(rows[2:]))
    >>> found.count, found.mean.tolist(), np.isclose(found.variance, rows.var()).tolist()
    (3, [3.0], [True])
    """
    count = first.count + other.count
    share = other.count / count
    (mean, other_mean), (variance, other_variance) = (
        [getattr(side, name).astype(np.float64) for side in (first, other)]
        for name in ("mean", "variance")
    )
    off = other_mean - mean
    spread = variance + share * (other_variance - variance) + share * (1 - share) * off**2
    return Channels(
        mean=(mean + share * off).astype(np.float32),
        variance=spread.astype(np.float32),
        count=count,
    )


def profile_of(
    embeddings: Embeddings,
    rows: NDArray[np.int64] | None = None,
    *,
    domain: str = "",
    modalities: Sequence[str] = IMAGES,
) -> Profile:
    """Return the profile of some pairs (None: all). Their labels are not read.

    Raises DataError without pairs, and for rows that are not there.

    >>> from omnivat import default_embeddings, load_embeddings
    >>> pairs = load_embeddings(default_embeddings())
    >>> rows = pairs.rows_of("TQ-DIGIT-sim")[:20]  # twenty pictures of a sensor are enough
    >>> profile = profile_of(pairs, rows, domain="TQ-DIGIT-sim")
    >>> profile.counts, profile.channels["tac"].mean.shape
    ({'vis': 20, 'tac': 20}, (1280,))
    """
    if rows is not None:
        rows = row_numbers(rows, len(embeddings))
    return Profile(
        channels={name: channels_of(getattr(embeddings, name), rows) for name in modalities},
        key=embeddings.header.key,
        domain=domain,
        lamps=None if isinstance(lit := embeddings.header.lamps.get(domain), str) else lit,
        way=embeddings.header.tac_way.get(domain, ""),
    )


def shrunk(target: Channels, source: Channels, step: float = 1.0) -> Channels:
    """Draw a target's statistics of n pictures towards the source's: by n / (n + 4) and n / (n +
    10).

    Without pictures it is the source's, so that nothing moves. Few pictures know a mean better than
    a variance. Both shares are times `step`.
    """
    n = target.count
    mean, variance = step * n / (n + MEAN_PRIOR), step * n / (n + VARIANCE_PRIOR)
    return replace(
        target,
        mean=source.mean + mean * (target.mean - source.mean),
        variance=source.variance + variance * (target.variance - source.variance),
    )


def floor_of(source: Channels) -> Any:
    """Return what is added to each channel's deviation, so that a still channel is not blown up:
    the mean deviation.
    """
    floor = (source.variance**0.5).mean()
    return floor + (floor == 0)


def scale_of(channels: Channels, floor: float) -> Array:
    """Return the divisor (W,) of each channel: its deviation and the floor."""
    scale: Array = channels.variance**0.5 + floor
    return scale


def moved(rows: Array, target: Channels, source: Channels, step: float = 1.0) -> Array:
    """Return rows (N, W) of a target domain with the source's mean and deviation.

    The target's statistics are shrunk first. A head's standardisation by the source's profile then
    equals one by the target's.

    >>> import numpy as np
    >>> rows = np.random.default_rng(0).normal(size=(500, 4)).astype(np.float32)
    >>> near = moved(2 * rows + 3, channels_of(2 * rows + 3), channels_of(rows))
    >>> bool(np.abs(near.mean(0)).max() < 0.1), bool(near.std(0).max() < 1.5)  # 3 and 2 before
    (True, True)
    """
    near, floor = shrunk(target, source, step), floor_of(source)
    ratio = scale_of(source, floor) / scale_of(near, floor)
    return (rows - near.mean) * ratio + source.mean


def standardised(rows: Array, source: Channels) -> Array:
    """Return tanh of rows (N, W) less the mean, by the deviation: what a head computes first.

    The bound keeps a channel that a new sensor shifts far from drowning the others.
    """
    return np.asarray(np.tanh((rows - source.mean) / scale_of(source, floor_of(source))))


def profiled(
    embeddings: Embeddings, profiles: Mapping[str, Profile], source: Profile
) -> Embeddings:
    """Return embeddings with the pairs of each profiled domain moved onto the source's statistics.

    profiles  domain -> its profile; other domains stay as they are
    source    the profile of the head's training pairs

    Raises DataError for a profile of another encoder.

    >>> from omnivat import EXAMPLES, load_embeddings
    >>> pairs = load_embeddings(EXAMPLES / "chirps" / "chirps.safetensors")
    >>> source, target = (
    ...     profile_of(pairs, pairs.rows_of(name)) for name in ("Chirps A-sim", "Chirps B-sim")
    ... )
    >>> near = profiled(pairs, {"Chirps B-sim": target}, source)
    >>> before, after = (one.in_domain("Chirps B-sim").tac.mean(0) for one in (pairs, near))
    >>> mean = source.channels["tac"].mean
    >>> bool(abs(after - mean).mean() < 0.1 * abs(before - mean).mean())
    True
    """
    owners = {}
    for name, profile in profiles.items():
        require_key(profile, embeddings.header.key, embeddings.width)
        owners[embeddings.header.domains.index(name)] = profile
    moves: dict[str, Any] = {
        name: _moved_array(array, embeddings.domain, owners, name[:3], source)
        for name, array in embeddings.vectors.items()
    }
    return replace(embeddings, **moves)


def domain_of(profile: Profile, domains: Sequence[str], source: str) -> str:
    """Return the domain of a set that a profile is of: by name, or the only one besides the source.

    Raises DataError if neither decides.
    """
    others = [name for name in domains if name != source]
    if profile.domain in domains:
        return profile.domain
    if len(others) == 1:
        return others[0]
    named = f"of '{profile.domain}'" if profile.domain else "without a domain's name"
    raise DataError(
        f"The profile is {named}, and the set has {', '.join(domains)}. Make the profile again with"
        " --domain and one of these names."
    )


def require_key(profile: Profile, key: tuple[str, str, str], width: int) -> None:
    """Raise DataError if a profile is of another encoder or width."""
    if profile.key != key or profile.width != width:
        raise DataError(
            f"The profile comes from {profile.key[0]} (width {profile.width}, weights "
            f"{profile.key[1][:12]}, {profile.key[2]}), and the embeddings from {key[0]} (width "
            f"{width}, weights {key[1][:12]}, {key[2]}). Make the profile with that encoder."
        )


def _moved_array(
    array: Array,
    domain: NDArray[np.int64],
    owners: Mapping[int, Profile],
    modality: str,
    source: Profile,
) -> Array:
    changed, start = _empty(array.shape), 0
    for block in walked(array):
        some = slice(start, start + len(block))
        for index, profile in owners.items():
            target = profile.channels.get(modality)
            rows = domain[some] == index
            if target is not None and modality in source.channels and rows.any():
                block[rows] = moved(block[rows], target, source.channels[modality], source.step)
        changed[some] = block
        start += len(block)
    return changed


def _empty(shape: tuple[int, ...]) -> Array:
    """Return an array to fill: in memory, or in a nameless temporary file if it is large."""
    if int(np.prod(shape)) * 4 <= LARGE_BYTES:
        return np.empty(shape, np.float32)
    with TemporaryFile() as file:
        return np.memmap(file, np.float32, "w+", shape=shape)
