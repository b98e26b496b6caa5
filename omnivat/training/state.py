"""The state of a training on disk. A resumed training gives identical weights."""

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from hashlib import sha256
from pathlib import Path

from safetensors import SafetensorError, safe_open
from safetensors.torch import save
from torch import Tensor

from omnivat.data.store import Embeddings
from omnivat.encoders.lang.bank import LangBank
from omnivat.head.head import OmniVaT
from omnivat.head.settings import HeadSettings
from omnivat.kit.config import settings_dict
from omnivat.kit.errors import DataError
from omnivat.kit.files import replacing
from omnivat.training.settings import TrainSettings
from omnivat.training.steps import Momentum, parameters_of

STATE = "training.safetensors"  # file name in the folder of an unfinished head
FORMAT = "omnivat-training-1"


@dataclass(slots=True)
class Progress:
    """The state of training after an epoch, apart from the weights."""

    epochs: list[dict[str, float]] = field(default_factory=list)  # one for each finished epoch
    best_score: float = -1.0  # on the held-out part of the source
    best_epoch: int | None = None  # without a held-out part
    best: dict[str, Tensor] = field(default_factory=dict)  # weights of that epoch

    def keep_best(self, score: float, epoch: int, model: OmniVaT) -> None:
        """Keep the weights of `model` if its score is the best so far."""
        if score > self.best_score:
            self.best_score, self.best_epoch = score, epoch
            self.best = {name: tensor.clone() for name, tensor in model.state_dict().items()}


def run_name(
    source: Embeddings,
    head: HeadSettings,
    settings: TrainSettings,
    bank: LangBank | None,
    seed: int,
) -> str:
    """Return an identifier of the training: data, settings, LANG and seed."""
    digest = sha256()
    for array in (source.vis, source.tac, source.vis_flip, source.tac_flip, source.label):
        digest.update(b"none" if array is None else array.tobytes())
    names = [settings_dict(head), settings_dict(settings), bank.hash if bank else None, seed]
    digest.update(json.dumps([names, list(source.rows["object"])]).encode())
    return digest.hexdigest()[:16]


def save_state(
    path: Path, run: str, model: OmniVaT, optimiser: Momentum, progress: Progress
) -> None:
    """Write the state after an epoch, completely or not at all."""
    tensors = {f"model.{name}": t for name, t in model.state_dict().items()}
    tensors |= {f"best.{name}": t for name, t in progress.best.items()}
    for index, parameter in enumerate(parameters_of(optimiser)):
        if parameter in optimiser.state:
            tensors[f"momentum.{index}"] = optimiser.state[parameter]
    metadata = {
        "format": FORMAT,
        "run": run,
        "epochs": json.dumps(progress.epochs),
        "best": json.dumps([progress.best_score, progress.best_epoch]),
    }
    with replacing(path) as temporary:
        plain = {n: t.detach().contiguous() for n, t in tensors.items()}
        temporary.write_bytes(save(plain, metadata=metadata))


def load_state(path: Path, run: str, model: OmniVaT, optimiser: Momentum) -> Progress:
    """Load a stopped training's state into model and optimiser; return its progress.

    A missing file means that training has not begun.
    Raises DataError if the file cannot be read or belongs to another training.
    """
    if not path.is_file():
        return Progress()
    try:
        with safe_open(path, framework="pt") as handle:
            metadata = handle.metadata() or {}
            tensors = {name: handle.get_tensor(name) for name in handle.keys()}  # noqa: SIM118
    except (SafetensorError, OSError) as error:
        raise DataError(f"'{path}' cannot be read ({error}); remove it to start again.") from error
    if metadata.get("format") != FORMAT or metadata.get("run") != run:
        raise DataError(
            f"'{path}' is the state of another training: data, settings, LANG or seed differ. "
            "Train with the same ones, or remove it to start again."
        )
    model.load_state_dict(_under("model.", tensors))
    momenta = _under("momentum.", tensors)
    for index, parameter in enumerate(parameters_of(optimiser)):
        if str(index) in momenta:
            optimiser.state[parameter] = momenta[str(index)]
    score, epoch = json.loads(metadata["best"])
    return Progress(
        epochs=json.loads(metadata["epochs"]),
        best_score=score,
        best_epoch=epoch,
        best=_under("best.", tensors),
    )


def _under(prefix: str, tensors: Mapping[str, Tensor]) -> dict[str, Tensor]:
    return {n.removeprefix(prefix): t for n, t in tensors.items() if n.startswith(prefix)}
