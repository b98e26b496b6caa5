"""CLIP's text tower, through `transformers`: sentences into the space of the ViT image towers."""

from collections.abc import Sequence
from pathlib import Path

import torch
from torch import Tensor

from omnivat.encoders.checkpoints import find, pick, read_state
from omnivat.encoders.clip_vit import PURPOSE, VIT_B16, VIT_L14, fill, read_config
from omnivat.encoders.running import one_thread, state_hash
from omnivat.errors import DataError, MissingNameError
from omnivat.packages import need
from omnivat.tables import suggestion

CHECKPOINTS = {checkpoint.name: checkpoint for checkpoint in (VIT_B16, VIT_L14)}


class ClipText:
    """The text tower that belongs to a CLIP ViT. `network` and `tokenizer` are open to learners."""

    def __init__(self, name: str, folder: Path, device: torch.device) -> None:
        transformers = need("transformers", purpose=PURPOSE)
        config = read_config(folder, name)
        state = pick(read_state(folder, name), ("text_model.", "text_projection."))
        self.network = transformers.CLIPTextModelWithProjection(config.text_config)
        fill(self.network, state, folder, name)
        self.network.eval().to(device)
        _require_tokenizer(folder, name)
        self.tokenizer = transformers.CLIPTokenizer.from_pretrained(folder)
        self.name = name
        self.width = int(config.projection_dim)
        self.weights_hash = state_hash(self.network.state_dict())
        self._longest = int(config.text_config.max_position_embeddings)
        self._device = device

    def embed_texts(self, texts: Sequence[str]) -> Tensor:
        """Return the projected embeddings (B, D), float32, of B texts; long ones are cut."""
        with torch.inference_mode(), one_thread():
            return torch.cat([self._embed(text) for text in texts])

    def _embed(self, text: str) -> Tensor:
        tokens = self.tokenizer(
            [text], truncation=True, max_length=self._longest, return_tensors="pt"
        ).to(self._device)
        embeds: Tensor = self.network(**tokens).text_embeds
        return embeds.float()


def _require_tokenizer(folder: Path, name: str) -> None:
    """`transformers` makes an empty tokenizer, and says nothing, when its files are missing."""
    choices = (("tokenizer.json",), ("vocab.json", "merges.txt"))
    if not any(all((folder / file).is_file() for file in files) for files in choices):
        raise DataError(
            f"'{folder}' has no tokenizer (tokenizer.json, or vocab.json and merges.txt); "
            f"fetch {name} again."
        )


def load_text_encoder(name: str, *, weights: Path | None = None, device: str = "cpu") -> ClipText:
    """Load the text tower that belongs to the image encoder called `name`.

    Raises MissingNameError for an encoder without one, DataError when a checkpoint is missing.
    """
    if name not in CHECKPOINTS:
        raise MissingNameError(
            f"No text tower belongs to '{name}'; there are {', '.join(CHECKPOINTS)}."
            + suggestion(name, CHECKPOINTS)
        )
    from omnivat.devices import device_from

    return ClipText(name, find(CHECKPOINTS[name], weights), device_from(device))
