"""The LANG bank: text embeddings of every class in many styles, made once for training."""

import json
from dataclasses import dataclass, replace
from hashlib import sha256
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from safetensors import SafetensorError
from safetensors.numpy import save

from omnivat.data.arrays import read_arrays
from omnivat.data.embeddings import Header
from omnivat.kit.errors import DataError
from omnivat.kit.files import path_of, replacing

FORMAT = "omnivat-lang-1"
Array = NDArray[np.float32]
PLAIN = "a photo of a {}."  # the prompt of CLIP's own zero-shot examples
DEFAULT_BANK = Path(__file__).parent / "minilm.safetensors"


@dataclass(frozen=True, slots=True, kw_only=True)
class LangBank:
    """Text embeddings (K, S, D): K classes in S styles.

    origin      encoder and method, as text
    plain       (K, D) embeddings of `PLAIN` prompts, for zero-shot prediction; or None
    encoder     the image encoder whose text tower made them, or ""
    text_hash   hash of the text tower; "" if unknown or not a CLIP
    logit_scale that model's factor of cosines, or None
    """

    embeddings: Array
    classes: tuple[str, ...]
    origin: str
    plain: Array | None = None
    encoder: str = ""
    text_hash: str = ""
    logit_scale: float | None = None

    @property
    def width(self) -> int:
        """D of the text encoder."""
        return int(self.embeddings.shape[2])

    @property
    def hash(self) -> str:
        """Short hash of the content, stored in every head trained with it."""
        tower = [self.text_hash] if self.text_hash else []
        names = json.dumps([self.classes, self.origin, *tower]).encode()
        return sha256(names + self.embeddings.tobytes()).hexdigest()[:16]

    def for_classes(self, classes: tuple[str, ...]) -> "LangBank":
        """Return the rows of `classes` in their order.

        Raises DataError with the missing classes.
        """
        missing = [name for name in classes if name not in self.classes]
        if missing:
            raise DataError(
                f"The LANG bank has no text for {', '.join(missing)}; it has"
                f" {', '.join(self.classes)}. Make one with `python -m omnivat prompts --classes"
                f" {','.join(classes)} --out FILE` and pass it as --lang FILE, or train with --set"
                " lang=false."
            )
        rows = [self.classes.index(name) for name in classes]
        plain = None if self.plain is None else self.plain[rows]
        return replace(self, embeddings=self.embeddings[rows], plain=plain, classes=classes)

    def is_of(self, header: Header) -> bool:
        """True if the text tower of the images' checkpoint made these texts.

        Raises DataError if the encoder is the same but the checkpoints differ.
        """
        if not self.text_hash or not header.text_hash:
            return False
        if self.encoder == header.encoder and self.text_hash != header.text_hash:
            raise DataError(
                f"The LANG bank was made by another checkpoint of {self.encoder} (text tower"
                f" {self.text_hash}) than the images' (text tower {header.text_hash}); make it"
                f" again with `python -m omnivat prompts --encoder {self.encoder} --weights FILE`,"
                " FILE being the checkpoint of the images."
            )
        return self.text_hash == header.text_hash


def save_bank(path: str | Path, bank: LangBank) -> None:
    """Write the bank, completely or not at all; float16 is enough for text embeddings."""
    metadata = {"format": FORMAT, "classes": json.dumps(bank.classes), "origin": bank.origin}
    if bank.text_hash:
        metadata |= {"encoder": bank.encoder, "text_hash": bank.text_hash}
    if bank.logit_scale is not None:
        metadata["logit_scale"] = repr(bank.logit_scale)
    arrays = {"embeddings": bank.embeddings.astype(np.float16)}
    if bank.plain is not None:
        arrays["plain"] = bank.plain.astype(np.float16)
    with replacing(path) as temporary:
        temporary.write_bytes(save(arrays, metadata=metadata))


def load_bank(path: str | Path = DEFAULT_BANK) -> LangBank:
    """Read a bank; by default the project's own.

    Raises DataError with the file name if it is missing or of another kind.
    """
    try:
        stored, metadata = read_arrays(path_of(path))
        arrays = {name: array.astype(np.float32) for name, array in stored.items()}
        embeddings, plain = arrays["embeddings"], arrays.get("plain")
        classes, scale = tuple(json.loads(metadata["classes"])), metadata.get("logit_scale")
        plain_shape = (len(classes), embeddings.shape[-1])
        if metadata["format"] != FORMAT or embeddings.shape[::2] != plain_shape:
            raise ValueError(f"{len(classes)} classes and {embeddings.shape}")
        if plain is not None and plain.shape != plain_shape:
            raise ValueError(f"plain texts of shape {plain.shape}")
        return LangBank(
            embeddings=embeddings,
            classes=classes,
            origin=metadata["origin"],
            plain=plain,
            encoder=metadata.get("encoder", ""),
            text_hash=metadata.get("text_hash", ""),
            logit_scale=None if scale is None else float(scale),
        )
    except (SafetensorError, OSError, KeyError, ValueError) as error:
        raise DataError(
            f"'{path}' is no LANG bank ({error}). Make one with `python -m omnivat prompts`."
        ) from error
