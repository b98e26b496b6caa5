"""CLIP's tokenizer: from files next to a checkpoint, or from an installed package."""

import gzip
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from omnivat.errors import DataError
from omnivat.files import cache_folder
from omnivat.packages import need

MERGES = "bpe_simple_vocab_16e6.txt.gz"  # the file that OpenAI and open_clip ship
CARRIERS = ("open_clip", "clip")  # packages with that file inside
MERGED = 49152 - 256 - 2  # merges in use: the vocabulary without bytes and the two special tokens
FILES = (("tokenizer.json",), ("vocab.json", "merges.txt"))


def load_tokenizer(place: Path, *, longest: int, vocabulary: int) -> Any:
    """Return the tokenizer of `transformers` for a checkpoint.

    place       the checkpoint: a folder or a file; its tokenizer is in that folder
    longest     longest text of the tower, in tokens
    vocabulary  number of token embeddings of the tower

    It searches next to the checkpoint, then in the folders of other CLIPs in the cache, then in the
    packages open_clip and clip. All CLIPs share one tokenizer.
    Raises DataError if there is none, or if it does not fit the tower.
    """
    transformers = need("transformers", purpose="CLIP's tokenizer")
    folder = place if place.is_dir() else place.parent
    found = None
    for candidate in (folder, *sorted(cache_folder().glob("clip*"))):
        if any(all((candidate / name).is_file() for name in names) for names in FILES):
            found = transformers.CLIPTokenizer.from_pretrained(candidate)
            break
        if (candidate / MERGES).is_file():
            found = _of_merges(transformers, candidate / MERGES)
            break
    if found is None and (carried := _carried()) is not None:
        found = _of_merges(transformers, carried)
    if found is None:
        raise DataError(
            f"'{folder}' has no tokenizer (tokenizer.json, vocab.json and merges.txt, or {MERGES}); "
            "put CLIP's there, or `pip install --no-deps open_clip_torch`, which carries it."
        )
    if len(found) > vocabulary:
        raise DataError(
            f"The tokenizer for '{place}' has {len(found)} tokens and the text tower {vocabulary}; "
            "put the tokenizer of this model beside it."
        )
    found.model_max_length = longest
    return found


def _carried() -> Path | None:
    """Return the merges file in an installed package, without importing the package."""
    for package in CARRIERS:
        spec = find_spec(package)
        for folder in (spec.submodule_search_locations or ()) if spec else ():
            if (file := Path(folder) / MERGES).is_file():
                return file
    return None


def _of_merges(transformers: Any, file: Path) -> Any:
    """Build the tokenizer from OpenAI's list of merges, most frequent first."""
    lines = gzip.decompress(file.read_bytes()).decode("utf-8").split("\n")
    merges = lines[1 : MERGED + 1]
    letters = list(_byte_letters())
    words = [*letters, *(letter + "</w>" for letter in letters)]
    words += [line.replace(" ", "") for line in merges]
    words += ["<|startoftext|>", "<|endoftext|>"]
    vocabulary = {word: index for index, word in enumerate(words)}
    return transformers.CLIPTokenizer(vocab=vocabulary, merges=[tuple(m.split()) for m in merges])


def _byte_letters() -> list[str]:
    """Return a printable letter for each of the 256 bytes, in the order of CLIP's vocabulary."""
    printable = [*range(33, 127), *range(161, 173), *range(174, 256)]
    return [chr(b) for b in printable] + [chr(256 + i) for i in range(256 - len(printable))]
