"""A head on disk: a folder of `weights.safetensors`, `settings.json` and `metrics.json`.

`settings.json` has the calibration; `familiarity.safetensors` has the training embeddings, and
`profile.safetensors` their channel statistics. A head may lack either file.
"""

from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import torch
from safetensors.torch import save
from torch import Tensor

from omnivat.data.arranged import require_ways
from omnivat.data.dots import FILLED
from omnivat.data.profile import Profile, domain_of, moved, profiled, require_key
from omnivat.data.profile_file import load_profile, save_profile
from omnivat.data.relief.files import touch_of, unmarked
from omnivat.data.rest import RESTED
from omnivat.data.store import Embeddings
from omnivat.head.calibration import Familiarity, load_familiarity, save_familiarity, tensors_in
from omnivat.head.fusion import UNFITTED, Temperatures
from omnivat.head.head import OmniVaT
from omnivat.head.settings import HeadSettings
from omnivat.kit.config import settings_from
from omnivat.kit.devices import current
from omnivat.kit.errors import DataError, SettingsError
from omnivat.kit.files import (
    hash_of,
    path_of,
    replacing,
    replacing_folder,
    require_writable,
    write_json,
)
from omnivat.kit.schema import read_object, texts

FORMAT = "omnivat-head-1"
WEIGHTS, SETTINGS, METRICS = "weights.safetensors", "settings.json", "metrics.json"
FAMILIARITY, PROFILE = "familiarity.safetensors", "profile.safetensors"
ENCODER = ("name", "weights_hash", "preprocessing")
# ways to make embeddings: mark in a set's preprocessing, in words, how to embed so, and how not so
MADE = (
    (FILLED, "the dots of touch filled", "with --dots fill", "with --dots keep"),
    (RESTED, "a no-contact picture subtracted from touch", "with --tac-rest", "without --tac-rest"),
)
TOUCHED = {
    "colours": "in its colours",
    "relief": "drawn as its relief",
    "both": "in its colours and drawn as its relief, side by side",
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Head:
    """A trained head and its provenance."""

    model: OmniVaT
    encoder: dict[str, str]  # name, weights_hash, preprocessing
    provenance: dict[str, Any]  # source domain, training settings, seed, LANG bank, versions
    metrics: dict[str, Any] = field(default_factory=dict)
    path: Path | None = None
    familiarity: Familiarity | None = None
    profile: Profile | None = None  # of the training pairs

    @property
    def settings(self) -> HeadSettings:
        """The settings of the model."""
        return self.model.settings

    @property
    def source(self) -> str:
        """The domain it was trained on."""
        return str(self.provenance.get("source", ""))

    def require(self, key: tuple[str, str, str], width: int, *, what: str) -> None:
        """Raise DataError for embeddings of another encoder, weights, preprocessing or width.

        The message names both sides.
        """
        wanted = tuple(self.encoder[name] for name in ENCODER)
        if key == wanted and width == self.settings.input_width:
            return
        came, reads = (touch_of(parts[2]) for parts in (key, wanted))
        if came != reads and unmarked(key[2]) == unmarked(wanted[2]) and key[:2] == wanted[:2]:
            raise DataError(
                f"{what} are made with touch {TOUCHED[came]}, and this head was trained with touch"
                f" {TOUCHED[reads]}. Embed the pairs with --touch {reads}, or choose a head that"
                " fits."
            )
        for marker, made, *how in MADE:
            bare, learned = ("".join(parts).replace(marker, "") for parts in (key, wanted))
            if key != wanted and bare == learned:
                mine = marker in wanted[2]
                others, own = ("without", "with") if mine else ("with", "without")
                raise DataError(
                    f"{what} are made {others} {made}, and this head was trained {own}. Embed the"
                    f" pairs {how[not mine]}, or choose a head that fits."
                )
        raise DataError(
            f"{what} come from {_describe(key, width)}, and this head was trained with "
            f"{_describe(wanted, self.settings.input_width)}. Embed the pairs with the head's "
            "encoder, or choose a head that fits."
        )

    def profiled(self, embeddings: Embeddings, profiles: Sequence[Profile]) -> Embeddings:
        """Return embeddings with the pairs of profiled domains moved onto the source's statistics.

        Raises DataError if the head lacks its source's profile, or a profile does not fit the set.
        """
        domains = embeddings.header.domains
        read = [profile.read_by(embeddings.header.key) for profile in profiles]
        owners = {domain_of(profile, domains, self.source): profile for profile in read}
        return profiled(embeddings, owners, self.source_profile) if owners else embeddings

    @property
    def source_profile(self) -> Profile:
        """The profile of the training pairs; raises DataError for a head without one."""
        if self.profile is None:
            raise DataError(
                "This head has no profile of its source, so no sensor's profile can be matched to"
                " it. Train it again, or copy profile.safetensors into its folder."
            )
        return self.profile

    def moved(self, name: str, rows: Tensor, profile: Profile) -> Tensor:
        """Return rows (B, input_width) of a modality, moved from a profiled sensor to the source's.

        A modality that either profile lacks stays as it is. Raises DataError as `profiled` does.
        """
        source = self.source_profile
        profile = profile.read_by(source.key)
        require_key(profile, source.key, source.width)
        target = profile.channels.get(name)
        if target is None or name not in source.channels:
            return rows
        near = moved(rows.detach().cpu().numpy(), target, source.channels[name], source.step)
        return torch.from_numpy(near).to(rows)

    def require_embeddings(self, embeddings: Embeddings) -> None:
        """Raise DataError for a set of embeddings that does not fit this head."""
        header = embeddings.header
        self.require(header.key, embeddings.width, what="The embeddings")
        learned = self.provenance.get("tac_way", {})
        require_ways(
            {name: way for name, way in learned.items() if name in header.domains}, header.tac_way
        )


def _describe(key: tuple[str, ...], width: int) -> str:
    name, weights, preprocessing = key
    return f"{name} (weights {weights[:12]}, {preprocessing}, width {width})"


def save_head(folder: str | Path, head: Head) -> Path:
    """Write a head folder, completely or not at all; it replaces an older head.

    Raises DataError if the folder contains anything else.

    >>> from tempfile import TemporaryDirectory
    >>> from omnivat import default_head
    >>> with TemporaryDirectory() as folder:
    ...     place = save_head(Path(folder) / "copy", load_head(default_head()))
    ...     load_head(place).settings.classes
    ('wood', 'steel', 'plastic', 'ceramic', 'glass')
    """
    target = path_of(folder)
    require_head_folder(target)
    record = {
        "format": FORMAT,
        "head": asdict(head.settings),
        "encoder": head.encoder,
        "provenance": head.provenance,
        "calibration": {"temperature": dict(head.model.temperatures)},
    }
    with replacing_folder(target) as folder:
        tensors = {name: t.detach().contiguous() for name, t in head.model.state_dict().items()}
        with replacing(folder / WEIGHTS) as file:
            file.write_bytes(save(tensors, metadata={"format": FORMAT}))
        write_json(folder / SETTINGS, record)
        write_json(folder / METRICS, head.metrics)
        if head.familiarity is not None:
            save_familiarity(folder / FAMILIARITY, head.familiarity)
        if head.profile is not None:
            save_profile(folder / PROFILE, head.profile)
    return target


def require_head_folder(folder: str | Path, *, also: Sequence[str] = ()) -> None:
    """Check, before training, that a head can be written to `folder` without loss.

    folder  may be missing; an older head in it may be replaced
    also    names of further allowed files
    Raises DataError naming a file that is not part of a head, WriteError if the folder is not
    writable.
    """
    target = path_of(folder)
    if target.exists() and not target.is_dir():
        raise DataError(f"'{target}' is a file; name a folder for the head.")
    allowed = {WEIGHTS, SETTINGS, METRICS, FAMILIARITY, PROFILE, *also}
    foreign = {path.name for path in target.iterdir()} - allowed if target.is_dir() else set()
    foreign = {n for n in foreign if not (n[0] == "." and n.endswith(".tmp"))}  # a killed writer's
    if foreign:
        raise DataError(
            f"'{target}' holds '{min(foreign)}', which is not part of a head and would be lost; "
            "name a new folder, or move that file away."
        )
    require_writable(target / SETTINGS)


def load_head(folder: str | Path, *, dtype: torch.dtype | None = None) -> Head:
    """Read a head folder, ready to predict.

    dtype  precision for computation; None: as saved (float32)

    The model is on the current device (`omnivat.kit.devices`).
    Raises DataError with the file name if something is missing, truncated or does not fit.

    >>> from omnivat import default_head
    >>> head = load_head(default_head())
    >>> head.source, head.settings.classes
    ('TAG-sim', ('wood', 'steel', 'plastic', 'ceramic', 'glass'))
    """
    path = path_of(folder)
    if not path.is_dir():
        raise DataError(
            f"No head at '{path}'. Train one with `python -m omnivat train --out {path}`."
        )
    file = path / SETTINGS
    _require(file)
    record = read_object(file)
    if record.get("format") != FORMAT:
        raise DataError(f"'{file}' is not the settings of a head ('{FORMAT}').")
    try:
        settings = settings_from(HeadSettings, record["head"])
        encoder = texts(record["encoder"], f"{file} (encoder)")
        if missing := [name for name in ENCODER if name not in encoder]:
            raise DataError(f"'{file}' lacks the encoder's {missing[0]}.")
        provenance = record["provenance"]
        train = provenance.get("train", {})
        if not isinstance(train.get("modalities", ""), str):
            raise TypeError(f"it was trained with modalities {train['modalities']!r:.40}")
    except (KeyError, TypeError, AttributeError, SettingsError) as error:
        why = f"{error!s:.300}"
        raise DataError(f"'{file}' does not describe a head: {why.rstrip('.')}.") from error
    model = _load_weights(path / WEIGHTS, settings)
    model.temperatures = _temperatures(file, record.get("calibration"))
    model = model.to(device=current(), dtype=dtype)
    profile = load_profile(path / PROFILE) if (path / PROFILE).is_file() else None
    if profile and (profile.width != settings.input_width or not profile.channels):
        raise DataError(f"'{path / PROFILE}' does not fit this head; copy the head folder again.")
    return Head(
        model=model.eval().requires_grad_(False),
        encoder=encoder,
        provenance=provenance,
        metrics=read_object(path / METRICS) if (path / METRICS).is_file() else {},
        path=path,
        familiarity=load_familiarity(path / FAMILIARITY, settings.input_width),
        profile=profile,
    )


def head_hash(folder: str | Path) -> str:
    """Return a short hash of a head's weights and settings."""
    return hash_of(*(Path(folder) / name for name in (WEIGHTS, SETTINGS)))[:16]


def _temperatures(file: Path, stored: Any) -> Temperatures:
    """Return the calibration in a head's settings."""
    try:
        temperature = {n: float(stored["temperature"][n]) for n in UNFITTED}
    except (KeyError, TypeError, ValueError) as error:
        raise DataError(f"'{file}' holds a calibration that cannot be read: {error!r}.") from error
    if all(0 < t < 1e6 for t in temperature.values()):
        return temperature
    raise DataError(
        f"'{file}' holds temperatures {temperature}; they are above 0. Copy the head folder again."
    )


def _load_weights(file: Path, settings: HeadSettings) -> OmniVaT:
    _require(file)
    tensors = tensors_in(file)
    with torch.device("meta"):
        model = OmniVaT(settings)
    floating = {name: tensor.is_floating_point() for name, tensor in model.state_dict().items()}
    try:
        model.load_state_dict(tensors, assign=True)
    except RuntimeError as error:
        why = str(error).splitlines()[-1].strip()
        raise DataError(f"'{file}' does not fit its settings: {why:.300}") from error
    for name, tensor in tensors.items():
        if tensor.is_floating_point() != floating[name] or not tensor.isfinite().all():
            raise DataError(f"'{file}' holds no finite numbers as {name}; copy the head again.")
    return model


def _require(file: Path) -> None:
    if not file.is_file():
        raise DataError(
            f"'{file}' is missing; a head folder holds {WEIGHTS}, {SETTINGS}, {METRICS}."
        )
