"""CLIP's text tower with an inserted word vector, for PromptStyler."""

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
