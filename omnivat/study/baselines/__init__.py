"""Comparison methods over the same cached embeddings: one method in each file.

`BASELINES` maps names to fit functions: fit(Source) -> Fitted (see contract.py). `LABELS` has the
name of each method in tables. A surrogate of a published method that cannot run on pooled
embeddings has a suffix in its label and a note on what is missing. `omnivat.kit.tables.load`
imports a method on first use.
"""

from typing import NamedTuple

BASELINES = {
    "nearest_mean": "omnivat.study.baselines.nearest_mean:fit",
    "linear_maps": "omnivat.study.baselines.linear_maps:fit",
    "erm_mlp": "omnivat.study.baselines.erm_mlp:fit",
    "baseline": "omnivat.study.baselines.baseline:fit",
    "promptstyler": "omnivat.study.baselines.text:fit_promptstyler",
    "zero_shot": "omnivat.study.baselines.text:fit_zero_shot",
    "spg": "omnivat.study.baselines.spg:fit",
    "mmrl": "omnivat.study.baselines.mmrl:fit",
    "sitr_supcon": "omnivat.study.baselines.contrastive:fit_sitr",
    "vt_cmc_head": "omnivat.study.baselines.contrastive:fit_vt_cmc",
    "ldc": "omnivat.study.baselines.ldc:fit",
    "ldc_icd": "omnivat.study.baselines.ldc:fit_icd",
    "robust_vish": "omnivat.study.baselines.robust_vish:fit",
}


class Label(NamedTuple):
    """A method in tables: its name, and a note on how it differs from the published method."""

    name: str
    note: str = ""
    optional: bool = False  # not in the default list: slower, or a variant of another row


LABELS = {
    "nearest_mean": Label("Nearest class mean"),
    "linear_maps": Label(
        "Linear maps of photo, touch and both",
        "standardised by the source's profile, averaged; training noise chosen on the source",
    ),
    "erm_mlp": Label("ERM-MLP"),
    "baseline": Label(
        "Baseline (styles + linear)",
        "the paper's Baseline as far as it is described; text of another encoder than the images' "
        "passes one linear map more",
    ),
    "promptstyler": Label(
        "PromptStyler (source-free)",
        "exact: stage 2 with ArcFace at the paper's rate of 0.005, which stays; the LANG bank is"
        " stage 1",
    ),
    "zero_shot": Label(
        "CLIP zero-shot", 'exact: "a photo of a CLASS.", the model\'s own logit scale'
    ),
    "spg": Label(
        "SPG",
        "exact over pooled embeddings but for random crops, with the rate and the clips that its"
        " code has for other sets than PACS; one noise vector for all, so that results repeat",
        optional=True,
    ),
    "mmrl": Label(
        "MMRL",
        "exact but for random crops, through both live towers; VIS and TAC are images alike",
        optional=True,
    ),
    "sitr_supcon": Label(
        "SITR-SupCon",
        "surrogate, touch alone: its contrastive loss over frozen embeddings; no transformer of its"
        " own and no calibration presses",
        optional=True,
    ),
    "vt_cmc_head": Label(
        "VT CMC-head", "contrastive head and probe only: the encoders are not pre-trained on touch"
    ),
    "ldc": Label(
        "LDC",
        "exact but for random crops, its list of prompts and its search of a mix, through the live"
        " image tower; VIS and TAC are images alike",
        optional=True,
    ),
    "ldc_icd": Label(
        "LDC-ICD",
        "surrogate, logit de-confusion only: the adapters of inner image tokens are in `ldc`;"
        " logits and embedding are concatenated, not added, a gate for each class, no BatchNorm,"
        " gradients clipped at 5; base logits come from source class means where no text of the"
        " image encoder is at hand",
    ),
    "robust_vish": Label(
        "RobustVisH-2",
        "two branches: the kinaesthetic one has no counterpart in these data",
        optional=True,
    ),
}
OPTIONAL = tuple(name for name, label in LABELS.items() if label.optional)
