"""The state of a training on disk. A resumed training gives identical weights."""

import json
from collections.abc import Mapping
from dataclasses import asdict
from hashlib import sha256
from pathlib import Path

from safetensors import SafetensorError, safe_open
from safetensors.torch import save
from torch import Tensor

from omnivat.data.store import Embeddings
from omnivat.encoders.lang.bank import LangBank
from omnivat.head.head import OmniVaT
from omnivat.head.settings import HeadSettings
from omnivat.kit.errors import DataError
from omnivat.kit.files import replacing
from omnivat.training.settings import TrainSettings
from omnivat.training.steps import Momentum, parameters_of

STATE = "training.safetensors"  # file name in the folder of an unfinished head
FORMAT = "omnivat-training-1"


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
    names = [asdict(head), asdict(settings), bank.hash if bank else None, seed]
    digest.update(json.dumps([names, list(source.rows["object"])]).encode())
    return digest.hexdigest()


def save_state(
    path: Path, run: str, model: OmniVaT, optimiser: Momentum, epochs: list[dict[str, float]]
) -> None:
    """Write the state after an epoch, completely or not at all."""
    tensors = {f"model.{name}": t for name, t in model.state_dict().items()}
    for index, parameter in enumerate(parameters_of(optimiser)):
        if parameter in optimiser.state:
            tensors[f"momentum.{index}"] = optimiser.state[parameter]
    metadata = {"format": FORMAT, "run": run, "epochs": json.dumps(epochs)}
    with replacing(path) as temporary:
        plain = {n: t.detach().contiguous() for n, t in tensors.items()}
        temporary.write_bytes(save(plain, metadata=metadata))


def load_state(path: Path, run: str, model: OmniVaT, optimiser: Momentum) -> list[dict[str, float]]:
    """Load a stopped training's state into model and optimiser; return its finished epochs.

    A missing file means that training has not begun.
    Raises DataError if the file cannot be read or belongs to another training.
    """
    if not path.is_file():
        return []
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
    epochs: list[dict[str, float]] = json.loads(metadata["epochs"])
    return epochs


def _under(prefix: str, tensors: Mapping[str, Tensor]) -> dict[str, Tensor]:
    return {n.removeprefix(prefix): t for n, t in tensors.items() if n.startswith(prefix)}
