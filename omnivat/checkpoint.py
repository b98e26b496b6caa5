"""A head on disk: a folder of `weights.safetensors`, `settings.json` and `metrics.json`."""

import json
import shutil
from collections.abc import Mapping
from dataclasses import dataclass, field
from hashlib import sha256
from pathlib import Path
from tempfile import mkdtemp
from typing import Any

import torch
from safetensors import SafetensorError
from safetensors.torch import load_file, save_file

from omnivat.config import settings_dict, settings_from
from omnivat.data.store import Embeddings
from omnivat.errors import DataError, SettingsError
from omnivat.files import write_json
from omnivat.model.head import OmniVaT
from omnivat.model.settings import HeadSettings

FORMAT = "omnivat-head-1"
WEIGHTS, SETTINGS, METRICS = "weights.safetensors", "settings.json", "metrics.json"


@dataclass(frozen=True, slots=True, kw_only=True)
class Head:
    """A trained head and where it comes from."""

    model: OmniVaT
    settings: HeadSettings
    encoder: dict[str, str]  # name, weights_hash, preprocessing
    provenance: dict[str, Any]  # source domain, training settings, seed, LANG bank, versions
    metrics: dict[str, Any] = field(default_factory=dict)
    path: Path | None = None

    @property
    def source(self) -> str:
        """The domain it was trained on."""
        return str(self.provenance.get("source", ""))

    def require(self, key: tuple[str, str, str], width: int, *, what: str) -> None:
        """Refuse embeddings of another encoder, other weights, preprocessing or width.

        Raises DataError naming both sides.
        """
        wanted = tuple(self.encoder[name] for name in ("name", "weights_hash", "preprocessing"))
        if key == wanted and width == self.settings.input_width:
            return
        raise DataError(
            f"{what} come from {_describe(key, width)}, and this head was trained with "
            f"{_describe(wanted, self.settings.input_width)}. Embed the pairs with the head's "
            "encoder, or choose a head that fits."
        )

    def require_embeddings(self, embeddings: Embeddings) -> None:
        """Refuse a set of embeddings that this head cannot read."""
        self.require(embeddings.header.key, embeddings.width, what="The embeddings")


def _describe(key: tuple[str, ...], width: int) -> str:
    name, weights, preprocessing = key
    return f"{name} (weights {weights[:12]}, {preprocessing}, width {width})"


def save_head(folder: str | Path, head: Head) -> Path:
    """Write a head folder whole or not at all; an older head there is replaced.

    Raises DataError when the folder exists and is something else.
    """
    target = Path(folder)
    if target.exists() and any(target.iterdir()) and not (target / SETTINGS).is_file():
        raise DataError(f"'{target}' exists and is not a head; name a new folder.")
    target.parent.mkdir(parents=True, exist_ok=True)
    temporary = Path(mkdtemp(dir=target.parent, prefix=f".{target.name}."))
    try:
        tensors = {name: t.detach().contiguous() for name, t in head.model.state_dict().items()}
        save_file(tensors, temporary / WEIGHTS, metadata={"format": FORMAT})
        record = {
            "format": FORMAT,
            "head": settings_dict(head.settings),
            "encoder": head.encoder,
            "provenance": head.provenance,
        }
        write_json(temporary / SETTINGS, record)
        write_json(temporary / METRICS, head.metrics)
        temporary.chmod(0o755)
        (temporary / WEIGHTS).chmod(0o644)
        _swap(temporary, target)
    finally:
        shutil.rmtree(temporary, ignore_errors=True)
    return target


def _swap(new: Path, target: Path) -> None:
    """Put `new` in the place of `target`."""
    old = new.with_name(new.name + ".old")
    if target.exists():
        target.rename(old)
    new.rename(target)
    shutil.rmtree(old, ignore_errors=True)


def load_head(folder: str | Path, *, dtype: torch.dtype | None = None) -> Head:
    """Read a head folder, ready to predict.

    dtype  precision to compute in; as saved (float32) where None

    Raises DataError, naming the file, when something is missing, cut short or does not fit.
    """
    path = Path(folder)
    if not path.is_dir():
        raise DataError(
            f"No head at '{path}'. Train one with `python -m omnivat train --out {path}`."
        )
    record = _read_json(path / SETTINGS)
    if record.get("format") != FORMAT:
        raise DataError(f"'{path / SETTINGS}' is not the settings of a head ('{FORMAT}').")
    try:
        settings = settings_from(HeadSettings, record["head"])
        encoder, provenance = dict(record["encoder"]), dict(record["provenance"])
    except (KeyError, TypeError, SettingsError) as error:
        raise DataError(f"'{path / SETTINGS}' does not describe a head: {error}") from error
    model = _load_weights(path / WEIGHTS, settings)
    if dtype is not None:
        model = model.to(dtype)
    metrics = _read_json(path / METRICS) if (path / METRICS).is_file() else {}
    return Head(
        model=model.eval().requires_grad_(False),
        settings=settings,
        encoder=encoder,
        provenance=provenance,
        metrics=metrics,
        path=path,
    )


def head_hash(folder: str | Path) -> str:
    """Return a short name of a head's content: weights and settings."""
    digest = sha256()
    for name in (WEIGHTS, SETTINGS):
        digest.update((Path(folder) / name).read_bytes())
    return digest.hexdigest()[:16]


def _load_weights(file: Path, settings: HeadSettings) -> OmniVaT:
    if not file.is_file():
        raise DataError(f"'{file}' is missing; copy the whole head folder.")
    try:
        tensors = load_file(file)
    except (SafetensorError, OSError) as error:
        raise DataError(
            f"'{file}' cannot be read ({error}); copy the head folder again."
        ) from error
    with torch.device("meta"):
        model = OmniVaT(settings)
    try:
        _check_tensors(tensors, model.state_dict())
    except ValueError as error:
        raise DataError(f"'{file}' does not fit its settings: {error}.") from error
    model.load_state_dict(tensors, assign=True)
    return model


def _check_tensors(given: Mapping[str, torch.Tensor], wanted: Mapping[str, torch.Tensor]) -> None:
    for name, tensor in wanted.items():
        if name not in given:
            raise ValueError(f"{name} is missing")
        if given[name].shape != tensor.shape:
            raise ValueError(
                f"{name} has shape {tuple(given[name].shape)}, wanted {tuple(tensor.shape)}"
            )
        if given[name].is_floating_point() and not given[name].isfinite().all():
            raise ValueError(f"{name} holds NaN or infinite values")
    if extra := sorted(set(given) - set(wanted)):
        raise ValueError(f"{extra[0]} is not part of such a head")


def _read_json(file: Path) -> dict[str, Any]:
    if not file.is_file():
        raise DataError(
            f"'{file}' is missing; a head folder holds {WEIGHTS}, {SETTINGS}, {METRICS}."
        )
    try:
        value = json.loads(file.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise DataError(f"'{file}' is not readable JSON ({error}).") from error
    if not isinstance(value, dict):
        raise DataError(f"'{file}' should hold a JSON object.")
    return value
