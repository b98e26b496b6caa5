"""CLIP's text tower with learned vectors instead of words, for SPG."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import torch
from torch import Tensor

from omnivat.errors import DataError
from omnivat.lang.promptstyler import WORD


class ClipWords:
    """A `CLIPTextModelWithProjection` of transformers and its tokenizer, as a `WordTower`.

    The word vector replaces the token embedding at its position. Position embeddings, layers and
    projection are CLIP's and frozen.
    """

    def __init__(self, network: Any, tokenizer: Any, *, origin: str) -> None:
        self.origin = origin
        self._network = network.eval().requires_grad_(False)
        self._tokenizer = tokenizer
        self._embedding = network.get_input_embeddings()
        self.word_width = int(self._embedding.weight.shape[1])
        ids = tokenizer([WORD], return_tensors="pt")["input_ids"][0]
        if len(ids) != 3:
            raise DataError(
                f"The tokenizer makes {len(ids) - 2} tokens of '{WORD}', and one is needed; "
                "use the tokenizer that belongs to CLIP."
            )
        self._word_id = int(ids[1])

    def embed_with_word(self, texts: Sequence[str], word: Tensor | None = None) -> Tensor:
        """Return embeddings (N, D); see `WordTower`."""
        tokens = self._tokenizer(list(texts), padding=True, return_tensors="pt")
        device = self._embedding.weight.device
        ids, mask = tokens["input_ids"].to(device), tokens["attention_mask"].to(device)
        if word is None:
            embedded: Tensor = self._network(input_ids=ids, attention_mask=mask).text_embeds
            return embedded
        places = ids == self._word_id
        if not bool(places.any(1).all()):
            raise DataError(f"A prompt has no '{WORD}' for a word vector to replace.")
        first = places & (places.cumsum(1) == 1)
        with _replaced(self._embedding, first[..., None], word):
            embedded = self._network(input_ids=ids, attention_mask=mask).text_embeds
        return embedded


@contextmanager
def _replaced(embedding: torch.nn.Module, where: Tensor, word: Tensor) -> Iterator[None]:
    """Make `embedding` return `word` (W,) at the positions `where` (N, T, 1)."""

    def put_in(module: torch.nn.Module, arguments: Any, output: Tensor) -> Tensor:
        return torch.where(where, word.to(output.dtype), output)

    handle = embedding.register_forward_hook(put_in)
    try:
        yield
    finally:
        handle.remove()


FILLER = "x"  # a token whose vector is replaced


class ClipPrompts:
    """A `CLIPTextModelWithProjection` of transformers and its tokenizer, as a `PromptTower`.

    A prompt is CONTEXT CLASS and a full stop. The context vectors are given; everything else is
    CLIP's and frozen.
    """

    def __init__(self, network: Any, tokenizer: Any) -> None:
        self._network = network.eval().requires_grad_(False)
        self._tokenizer = tokenizer
        self._embedding = network.get_input_embeddings()
        self.word_width = int(self._embedding.weight.shape[1])

    def words(self, text: str) -> Tensor:
        """Return the word vectors (T, W) of a text, without start and end tokens."""
        ids = torch.as_tensor(self._tokenizer([text])["input_ids"][0])[1:-1]
        vectors: Tensor = self._embedding.weight[ids.to(self._embedding.weight.device)]
        return vectors

    def embed_contexts(self, contexts: Tensor, classes: Sequence[str]) -> Tensor:
        """Return text embeddings (B, K, D) of contexts (B, T, W) with each class."""
        batch, length, _ = contexts.shape
        texts = [f"{' '.join([FILLER] * length)} {name}." for name in classes]
        tokens = self._tokenizer(texts, padding=True, return_tensors="pt")
        device = self._embedding.weight.device
        ids = tokens["input_ids"].to(device).repeat(batch, 1)  # (B K, T')
        mask = tokens["attention_mask"].to(device).repeat(batch, 1)
        vectors = contexts.to(device).repeat_interleave(len(classes), dim=0)
        with _in_place_of_words(self._embedding, vectors):
            embedded: Tensor = self._network(input_ids=ids, attention_mask=mask).text_embeds
        return embedded.reshape(batch, len(classes), -1)


@contextmanager
def _in_place_of_words(embedding: torch.nn.Module, vectors: Tensor) -> Iterator[None]:
    """Make `embedding` return `vectors` (N, T, W) for the tokens after the first of each text."""

    def put_in(module: torch.nn.Module, arguments: Any, output: Tensor) -> Tensor:
        length = vectors.shape[1]
        return torch.cat((output[:, :1], vectors.to(output.dtype), output[:, 1 + length :]), dim=1)

    handle = embedding.register_forward_hook(put_in)
    try:
        yield
    finally:
        handle.remove()


def load_prompts(encoder: str, text_hash: str) -> ClipPrompts:
    """Load the text tower of a LANG bank from its last known location.

    Raises DataError if it is missing or has changed.
    """
    from omnivat.encoders.clip_text import load_text_encoder
    from omnivat.encoders.hub import recall
    from omnivat.errors import DataError

    clip = load_text_encoder(encoder, weights=recall(text_hash), download="no")
    if clip.weights_hash != text_hash:
        raise DataError(
            f"The text tower of {encoder} found on this machine ({clip.weights_hash}) is not that of "
            f"the LANG bank ({text_hash}); make the bank again with the images' checkpoint."
        )
    return ClipPrompts(clip.network, clip.tokenizer)
