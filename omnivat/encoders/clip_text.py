"""CLIP's text tower, through `transformers`: text embeddings in the space of the images."""

import gzip
from collections.abc import Callable, Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch import Tensor

from omnivat.encoders.clip import CHECKPOINTS, Clip, open_clip
from omnivat.encoders.clip_towers import transformer
from omnivat.encoders.weights import count
from omnivat.kit.errors import DataError, MissingNameError
from omnivat.kit.tables import need, suggestion
from omnivat.kit.threads import one_thread


class ClipText:
    """The text tower of a CLIP. Prompt learners may use `network` and `tokenizer`.

    weights_hash    a hash of the text tower; `text_hash` of the image tower in the same file
    logit_scale     the model's factor of cosines; None if the checkpoint has none
    """

    def __init__(self, clip: Clip, device: torch.device) -> None:
        self.network = _network(clip).to(device)
        self._longest = int(self.network.config.max_position_embeddings)
        self.tokenizer = load_tokenizer(
            clip.place, longest=self._longest, vocabulary=int(self.network.config.vocab_size)
        )
        self.name, self.place = clip.name, clip.place
        self.width = int(self.network.config.projection_dim)
        self.weights_hash = clip.text_hash
        scale = clip.weights.logit_scale
        self.logit_scale = None if scale is None else float(torch.tensor(scale).exp())
        self._device = device

    def embed_texts(self, texts: Sequence[str]) -> Tensor:
        """Return the projected embeddings (B, D), float32, of B texts; long texts are truncated."""
        with torch.inference_mode(), one_thread():
            return torch.cat([self._embed(text) for text in texts])

    def _embed(self, text: str) -> Tensor:
        tokens = self.tokenizer(
            [text], truncation=True, max_length=self._longest, return_tensors="pt"
        ).to(self._device)
        embeds: Tensor = self.network(**tokens).text_embeds
        return embeds.float()


def _network(clip: Clip) -> Any:
    """Return the tower of `transformers` with the checkpoint's weights."""
    state = clip.weights.text
    words, places = (
        state[f"text_model.embeddings.{kind}_embedding.weight"] for kind in ("token", "position")
    )
    vocabulary, width = words.shape
    return transformer(
        clip,
        "text",
        hidden_size=width,
        num_hidden_layers=count(state, "text_model.encoder.layers."),
        vocab_size=vocabulary,
        max_position_embeddings=len(places),
        projection_dim=len(state["text_projection.weight"]),
        bos_token_id=vocabulary - 2,
        eos_token_id=vocabulary - 1,  # the last token in every published CLIP
    )


def load_text_encoder(
    name: str, *, weights: Path | None = None, device: str = "cpu", download: str = "ask"
) -> ClipText:
    """Load the text tower of the image encoder called `name`.

    Raises MissingNameError for an encoder without one, DataError if a checkpoint is missing or has
    only an image tower.
    """
    if name not in CHECKPOINTS:
        raise MissingNameError(
            f"No text tower belongs to '{name}'; there are {', '.join(CHECKPOINTS)}."
            + suggestion(name, CHECKPOINTS)
        )
    from omnivat.kit.devices import device_from

    clip = open_clip(name, weights, download=download)
    if not clip.weights.text:
        raise DataError(
            f"'{clip.file}' has an image tower and no text tower; name the whole model."
        )
    return ClipText(clip, device_from(device))


def text_encoder(
    name: str, *, weights: Path | None = None
) -> Callable[[Sequence[str]], np.ndarray[Any, Any]]:
    """Return a function that embeds texts (B) as float32 (B, D) in the space of encoder `name`.

    Raises MissingNameError for an encoder without a text tower, DataError if a checkpoint is
    missing.
    """
    tower = load_text_encoder(name, weights=weights)
    return lambda texts: tower.embed_texts(texts).cpu().numpy()


MERGES = "bpe_simple_vocab_16e6.txt.gz"  # the file that OpenAI and open_clip ship
CARRIERS = ("open_clip", "clip")  # packages with that file inside, which are not imported
MERGED = 49152 - 256 - 2  # merges in use: the vocabulary without bytes and the two special tokens
FILES = (("tokenizer.json",), ("vocab.json", "merges.txt"))


def load_tokenizer(place: Path, *, longest: int, vocabulary: int) -> Any:
    """Return the tokenizer of `transformers` for a checkpoint.

    place       the checkpoint: a folder or a file; its tokenizer is in that folder
    longest     longest text of the tower, in tokens
    vocabulary  number of token embeddings of the tower

    It searches next to the checkpoint, then in the packages open_clip and clip. All CLIPs share one
    tokenizer.
    Raises DataError if there is none, or if it does not fit the tower.
    """
    transformers = need("transformers", purpose="CLIP's tokenizer")
    folder = place if place.is_dir() else place.parent
    packages = [
        Path(path)
        for spec in map(find_spec, CARRIERS)
        if spec
        for path in spec.submodule_search_locations or ()
    ]
    for candidate in (folder, *packages):
        if any(all((candidate / name).is_file() for name in names) for names in FILES):
            found = transformers.CLIPTokenizer.from_pretrained(candidate)
            break
        if (candidate / MERGES).is_file():
            found = _of_merges(transformers, candidate / MERGES)
            break
    else:
        raise DataError(
            f"'{folder}' has no tokenizer (tokenizer.json, vocab.json and merges.txt, or {MERGES});"
            " put CLIP's there, or `pip install --no-deps open_clip_torch`, which carries it."
        )
    if len(found) > vocabulary:
        raise DataError(
            f"The tokenizer for '{place}' has {len(found)} tokens and the text tower {vocabulary}; "
            "put the tokenizer of this model beside it."
        )
    found.model_max_length = longest
    return found


def _of_merges(transformers: Any, file: Path) -> Any:
    """Build the tokenizer from OpenAI's list of merges, most frequent first."""
    merges = gzip.decompress(file.read_bytes()).decode("utf-8").split("\n")[1 : MERGED + 1]
    # A printable letter for each of the 256 bytes, in the order of CLIP's vocabulary.
    letters = list(transformers.convert_slow_tokenizer.bytes_to_unicode().values())
    words = [
        *letters,
        *(letter + "</w>" for letter in letters),
        *(line.replace(" ", "") for line in merges),
        "<|startoftext|>",
        "<|endoftext|>",
    ]
    vocabulary = {word: index for index, word in enumerate(words)}
    return transformers.CLIPTokenizer(vocab=vocabulary, merges=[tuple(m.split()) for m in merges])
