"""The LANG bank: text embeddings of every class in many styles, made once and read in training."""

import json
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from safetensors import SafetensorError, safe_open
from safetensors.numpy import save_file

from omnivat.errors import DataError
from omnivat.files import replacing

FORMAT = "omnivat-lang-1"
DEFAULT_BANK = Path(__file__).parent / "minilm.safetensors"


@dataclass(frozen=True, slots=True, kw_only=True)
class LangBank:
    """Text embeddings (K, S, D): K classes in S styles. `origin` says who made them, and how."""

    embeddings: NDArray[np.float32]
    classes: tuple[str, ...]
    origin: str

    @property
    def width(self) -> int:
        """D of the text encoder."""
        return int(self.embeddings.shape[2])

    @property
    def hash(self) -> str:
        """Short name of the content, kept in every checkpoint trained with it."""
        names = json.dumps([self.classes, self.origin]).encode()
        return sha256(names + self.embeddings.tobytes()).hexdigest()[:16]

    def for_classes(self, classes: tuple[str, ...]) -> "LangBank":
        """Return the rows of `classes` in their order.

        Raises DataError naming the classes that the bank lacks.
        """
        missing = [name for name in classes if name not in self.classes]
        if missing:
            raise DataError(
                f"The LANG bank has no text for {', '.join(missing)}; it knows "
                f"{', '.join(self.classes)}. Make one with `python -m omnivat prompts --classes "
                f"{','.join(classes)} --out FILE` and pass it as --lang FILE, or train with "
                "--set lang=false."
            )
        rows = [self.classes.index(name) for name in classes]
        return LangBank(embeddings=self.embeddings[rows], classes=classes, origin=self.origin)


def save_bank(path: str | Path, bank: LangBank) -> None:
    """Write the bank whole or not at all; float16 is enough for a text embedding."""
    metadata = {
        "format": FORMAT,
        "classes": json.dumps(bank.classes),
        "origin": bank.origin,
    }
    with replacing(path) as temporary:
        save_file({"embeddings": bank.embeddings.astype(np.float16)}, temporary, metadata=metadata)


def load_bank(path: str | Path = DEFAULT_BANK) -> LangBank:
    """Read a bank; the default one comes with the project.

    Raises DataError, naming the file, when it is missing or of another kind.
    """
    file = Path(path)
    if not file.is_file():
        raise DataError(f"No LANG bank at '{file}'. Make one with `python -m omnivat prompts`.")
    try:
        with safe_open(file, framework="numpy") as handle:
            metadata = handle.metadata() or {}
            if metadata.get("format") != FORMAT:
                raise DataError(
                    f"'{file}' is not a LANG bank. Make one with `python -m omnivat prompts`."
                )
            embeddings = handle.get_tensor("embeddings").astype(np.float32)
    except (SafetensorError, OSError) as error:
        raise DataError(
            f"'{file}' cannot be read as a LANG bank ({error}); make it again."
        ) from error
    classes = tuple(json.loads(metadata["classes"]))
    if embeddings.ndim != 3 or len(embeddings) != len(classes):
        raise DataError(f"'{file}' names {len(classes)} classes and holds {embeddings.shape}.")
    return LangBank(embeddings=embeddings, classes=classes, origin=metadata["origin"])
