"""Everything that shapes the head, frozen and flat."""

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
    """How an OmniVaT head is built. Letters are the paper's; defaults are docs/method.md's."""

    classes: tuple[str, ...]
    input_width: int  # of the image encoder
    lang_width: int = 384  # of the LANG bank
    width: int = 512  # D
    project: bool = False  # learn input projections even where widths agree
    shared_projection: bool = False  # one map for VIS and TAC (docs/decisions/0004)
    expansion: int = 4  # E, tokens a modality is expanded to
    levels: int = 3  # R, tree levels with the root
    order: float = 0.5  # p at the start, in quarter turns
    learn_order: bool = True
    ffn_ratio: int = 4
    class_token: bool = True  # F_g
    tree_at_inference: bool = True  # off is the paper's Alg. 2 to the letter
    attention_scale: str = "inside"  # of the softmax; "outside" is Eq. 4 as printed
    feature_scale: str = "unit"  # "literal" uses embeddings and features as they come
    theta_init: str = "spread"  # equal numbers would stay equal: E tokens would be one
    tree_init: str = "orthogonal"
    logit_scale: float = 10.0  # of the cosine classifier
    generation: str = "tree"  # of nodes; series and parallel hold as many matrices, the rest none
    mffa: bool = True  # off: the tree grows from the embeddings themselves
    complex_to_real: str = "tokens"  # Re and Im as tokens, |F|, Re alone, or complex attention
    order_per_modality: bool = False  # a p each for LANG, VIS and TAC
    guide: str = "both"  # F-bar of LANG in training: added to embeddings (Eq. 5), query (Eq. 6)
    guide_length: str = "embedding"  # of that F-bar: √D as embeddings have it, or 1 as printed
    fusion: str = "mean"  # of the VIS and TAC branches when predicting (model/fusion.py)

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
        """Whether LANG guides as the closed form of training has it."""
        return self.guide == "both" and self.guide_length == "embedding"

    @property
    def edges(self) -> int:
        """How many matrices grow nodes: 2^R - 2, or none."""
        return 2**self.levels - 2 if self.generation in ("tree", "series", "parallel") else 0

    @property
    def projects(self) -> bool:
        """Whether embeddings pass a learned linear map to width D first."""
        return self.project or self.input_width != self.width

    @property
    def projects_apart(self) -> bool:
        """Whether VIS and TAC pass a map each."""
        return self.projects and not self.shared_projection


def literal(settings: HeadSettings) -> HeadSettings:
    """Return the settings that follow the printed equations where ours differ.

    Known not to train: features stay so small that biases and NOD swamp the classes.
    """
    return replace(
        settings, attention_scale="outside", feature_scale="literal", tree_at_inference=False
    )
