"""CLIP's text tower with vectors instead of words: styles of PromptStyler, contexts of SPG."""

from collections.abc import Callable, Sequence
from contextlib import nullcontext
from typing import Any

import torch
from torch import Tensor

from omnivat.kit.errors import DataError

WORD = "x"  # a token whose vector is replaced


class ClipPrompts:
    """A `CLIPTextModelWithProjection` of transformers and its tokenizer, frozen.

    In a text, a word vector replaces a word; in a prompt, which is CONTEXT CLASS and a full stop,
    the context's vectors are given.
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
        ids, mask = self._tokens([f"{' '.join([WORD] * length)} {name}." for name in classes])
        vectors = contexts.to(ids.device).repeat_interleave(len(classes), dim=0)

        def put_in(words: Tensor) -> Tensor:  # behind the first token of each text
            return torch.cat((words[:, :1], vectors.to(words.dtype), words[:, 1 + length :]), dim=1)

        embedded = self._embedded(ids.repeat(batch, 1), mask.repeat(batch, 1), put_in)  # (B K, D)
        return embedded.reshape(batch, len(classes), -1)

    def _tokens(self, texts: Sequence[str]) -> tuple[Tensor, Tensor]:
        """Return tokens (N, T) and their mask."""
        tokens = self._tokenizer(list(texts), padding=True, return_tensors="pt")
        device = self._embedding.weight.device
        return tokens["input_ids"].to(device), tokens["attention_mask"].to(device)

    def _embedded(
        self, ids: Tensor, mask: Tensor, change: Callable[[Tensor], Tensor] | None = None
    ) -> Tensor:
        """Return embeddings (N, D) of tokens; `change` alters their word vectors (N, T, W)."""
        with (
            self._embedding.register_forward_hook(lambda *call: change(call[-1]))
            if change
            else nullcontext()
        ):
            found: Tensor = self._network(input_ids=ids, attention_mask=mask).text_embeds
        return found

    def embed_with_word(self, texts: Sequence[str], word: Tensor | None = None) -> Tensor:
        """Return embeddings (N, D) of texts, differentiable in `word`.

        word  (W,) replaces the token embedding of the first `WORD` of every text; None changes
              nothing
        """
        ids, mask = self._tokens(texts)
        if word is None:
            return self._embedded(ids, mask)
        places = ids == self._tokenizer([WORD])["input_ids"][0][1]
        first = (places & (places.cumsum(1) == 1))[..., None]
        return self._embedded(
            ids, mask, lambda words: torch.where(first, word.to(words.dtype), words)
        )


def load_prompts(encoder: str, text_hash: str) -> ClipPrompts:
    """Load the text tower of a LANG bank from its last known location.

    Raises DataError if it is missing or has changed.
    """
    from omnivat.encoders.clip_text import load_text_encoder
    from omnivat.encoders.hub import recall

    clip = load_text_encoder(encoder, weights=recall(text_hash), download="no")
    if clip.weights_hash != text_hash:
        raise DataError(
            f"The text tower of {encoder} found on this machine ({clip.weights_hash}) is not that"
            f" of the LANG bank ({text_hash}); make the bank again with the images' checkpoint."
        )
    return ClipPrompts(clip.network, clip.tokenizer)
