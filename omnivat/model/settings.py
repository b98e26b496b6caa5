"""Settings of the head, frozen and flat."""

from dataclasses import dataclass, replace

from omnivat.errors import SettingsError
from omnivat.model.fusion import FUSIONS
from omnivat.orders import checked_order

ATTENTION_SCALES = ("inside", "outside")
FEATURE_SCALES = ("unit", "literal")
THETA_INITS = ("spread", "ones", "signed", "normal")
GUIDES = ("both", "added", "query")
GUIDE_LENGTHS = ("embedding", "unit")
TREE_INITS = ("orthogonal", "default", "identity")
GENERATIONS = ("tree", "series", "parallel", "interpolation", "none")
COMPLEX_TO_REAL = ("tokens", "hermitian", "magnitude", "real")


@dataclass(frozen=True, slots=True, kw_only=True)
class HeadSettings:
    """How an OmniVaT head is built. Letters as in the paper; docs/method.md explains the
    defaults."""

    classes: tuple[str, ...]
    input_width: int  # of the image encoder
    lang_width: int = 384  # of the LANG bank
    width: int = 512  # D
    project: bool = False  # learn input projections even if widths agree
    shared_projection: bool = False  # one map for VIS and TAC (docs/decisions/0004)
    expansion: int = 4  # E, tokens for each channel
    levels: int = 3  # R, tree levels, root included
    order: float = 0.5  # initial p, in quarter turns
    learn_order: bool = True
    ffn_ratio: int = 4
    class_token: bool = True  # F_g
    tree_at_inference: bool = True  # off: Alg. 2 of the paper as printed
    attention_scale: str = "inside"  # of the softmax; "outside" is Eq. 4 as printed
    feature_scale: str = "unit"  # "literal" does not normalize embeddings and features
    theta_init: str = "spread"  # equal numbers would stay equal
    tree_init: str = "orthogonal"
    logit_scale: float = 10.0  # of the cosine classifier
    generation: str = "tree"  # of nodes; series and parallel have as many matrices, the rest none
    mffa: bool = True  # off: the tree grows from the embeddings
    complex_to_real: str = "tokens"  # Re and Im as tokens, |F|, Re alone, or complex attention
    order_per_modality: bool = False  # separate p for LANG, VIS and TAC
    guide: str = "both"  # F-bar of LANG in training: added to embeddings (Eq. 5), query (Eq. 6)
    guide_length: str = "embedding"  # of that F-bar: √D like embeddings, or 1 as printed
    fusion: str = "mean"  # late fusion of VIS and TAC in prediction (model/fusion.py)

    def __post_init__(self) -> None:
        for name, low, high in (
            ("input_width", 1, 65536),
            ("lang_width", 1, 65536),
            ("width", 2, 8192),
            ("expansion", 1, 64),
            ("levels", 1, 6),
            ("ffn_ratio", 1, 16),
        ):
            value = getattr(self, name)
            if not low <= value <= high:
                raise SettingsError(f"{name} is {value}; choose {low} to {high}.")
        for name, allowed in (
            ("attention_scale", ATTENTION_SCALES),
            ("feature_scale", FEATURE_SCALES),
            ("theta_init", THETA_INITS),
            ("tree_init", TREE_INITS),
            ("generation", GENERATIONS),
            ("complex_to_real", COMPLEX_TO_REAL),
            ("fusion", FUSIONS),
            ("guide", GUIDES),
            ("guide_length", GUIDE_LENGTHS),
        ):
            value = getattr(self, name)
            if value not in allowed:
                raise SettingsError(f"{name} is '{value}'; choose one of {', '.join(allowed)}.")
        if len(self.classes) < 2 or len(set(self.classes)) < len(self.classes):
            raise SettingsError(f"classes are {self.classes}; give two or more different names.")
        checked_order(self.order)

    @property
    def guides_by_default(self) -> bool:
        """True if LANG guides in the default way, which the closed form covers."""
        return self.guide == "both" and self.guide_length == "embedding"

    @property
    def edges(self) -> int:
        """The number of matrices that grow nodes: 2^R - 2, or none."""
        return 2**self.levels - 2 if self.generation in ("tree", "series", "parallel") else 0

    @property
    def projects(self) -> bool:
        """True if a learned linear map projects embeddings to width D."""
        return self.project or self.input_width != self.width

    @property
    def projects_apart(self) -> bool:
        """True if VIS and TAC have separate maps."""
        return self.projects and not self.shared_projection


def literal(settings: HeadSettings) -> HeadSettings:
    """Return the settings that follow the printed equations.

    Such a head does not train: its features are so small that biases and NOD dominate.
    """
    return replace(
        settings, attention_scale="outside", feature_scale="literal", tree_at_inference=False
    )
