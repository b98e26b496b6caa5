"""Methods to compare the head with, over the same cached embeddings: one method a file.

`BASELINES` points to fit functions: fit(Source) -> Fitted (see contract.py). `LABELS` says what each
is called in a table; a method that stands in for a published one that cannot run on pooled
embeddings carries a suffix in its label and says in its note what is missing.
Nothing is imported before `omnivat.tables.load` asks for it.
"""

from typing import NamedTuple

BASELINES = {
    "nearest_mean": "omnivat.baselines.nearest_mean:fit",
    "linear_probe": "omnivat.baselines.linear_probe:fit",
    "linear_probe_concat": "omnivat.baselines.linear_probe:fit_concatenated",
    "erm_mlp": "omnivat.baselines.erm_mlp:fit",
    "baseline": "omnivat.baselines.baseline:fit",
    "promptstyler": "omnivat.baselines.promptstyler:fit",
    "zero_shot": "omnivat.baselines.zero_shot:fit",
    "vt_cmc_head": "omnivat.baselines.vt_cmc_head:fit",
    "ldc_icd": "omnivat.baselines.ldc_icd:fit",
    "robust_vish": "omnivat.baselines.robust_vish:fit",
}


class Label(NamedTuple):
    """How a method is shown: its name in tables, and one line on what it is not."""

    name: str
    note: str = ""


LABELS = {
    "nearest_mean": Label("Nearest class mean"),
    "linear_probe": Label("Linear probe"),
    "linear_probe_concat": Label("Linear probe (concatenated)"),
    "erm_mlp": Label("ERM-MLP"),
    "baseline": Label(
        "Baseline (styles + linear)",
        "the paper's Baseline as far as it is described; text of another encoder than the images' "
        "passes one linear map more",
    ),
    "promptstyler": Label("PromptStyler (source-free)"),
    "zero_shot": Label("CLIP zero-shot"),
    "vt_cmc_head": Label(
        "VT CMC-head", "contrastive head and probe only: the encoders are not pre-trained on touch"
    ),
    "ldc_icd": Label(
        "LDC-ICD",
        "logit de-confusion only: the adapters of inner image tokens need the live encoder; base "
        "logits come from source class means where no text of the image encoder is at hand",
    ),
    "robust_vish": Label(
        "RobustVisH-2", "two branches: the kinaesthetic one has no counterpart in these data"
    ),
}
