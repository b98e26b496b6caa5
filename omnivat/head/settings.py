"""Settings of the head, frozen and flat."""

from dataclasses import dataclass
from typing import Annotated

from omnivat.head.fusion import FUSIONS
from omnivat.kit.config import OneOf, Within, require_declared
from omnivat.kit.errors import SettingsError
from omnivat.kit.stages import LIMIT, checked_order

Width = Annotated[int, Within(1, 65536)]
AttentionScale = Annotated[str, OneOf(("inside", "outside"))]
FeatureScale = Annotated[str, OneOf(("unit", "literal"))]
ThetaInit = Annotated[str, OneOf(("spread", "ones", "signed", "normal"))]
Guide = Annotated[str, OneOf(("both", "added", "query"))]
GuideLength = Annotated[str, OneOf(("embedding", "unit"))]
Generation = Annotated[str, OneOf(("tree", "series", "parallel", "interpolation", "none"))]
ComplexToReal = Annotated[str, OneOf(("tokens", "magnitude", "real"))]
Fusion = Annotated[str, OneOf(FUSIONS)]


@dataclass(frozen=True, slots=True, kw_only=True)
class HeadSettings:
    """How an OmniVaT head is built; docs/method.md explains letters and defaults.

    >>> settings = HeadSettings(classes=("wood", "steel"), input_width=1280)
    >>> settings.width, settings.order, settings.edges
    (512, 0.5, 6)
    >>> HeadSettings(classes=("wood", "steel"), input_width=1280, levels=9)
    Traceback (most recent call last):
    omnivat.kit.errors.SettingsError: levels is 9; choose 1 to 6.
    """

    classes: tuple[str, ...]
    input_width: Width  # of the image encoder
    lang_width: Width = 384  # of the LANG bank
    width: Annotated[int, Within(2, 8192)] = 512  # D
    project: bool = False  # learn input projections even if widths agree
    shared_projection: bool = False  # one map for VIS and TAC (docs/decisions/0004)
    maps: bool = False  # linear maps of photo, touch and both decide (omnivat/study/pooled.py)
    # classes before each teaching, by which later ones are added (omnivat/head/teach.py)
    taught: tuple[int, ...] = ()
    standardize: bool = True  # each channel by the source's profile (omnivat/data/profile.py)
    expansion: Annotated[int, Within(1, 64)] = 4  # E, tokens for each channel
    levels: Annotated[int, Within(1, 6)] = 3  # R, tree levels, root included
    order: Annotated[float, Within(-LIMIT, LIMIT)] = 0.5  # initial p, in quarter turns
    learn_order: bool = True
    class_token: bool = True  # F_g
    tree_at_inference: bool = True  # off: Alg. 2 of the paper as printed
    attention_scale: AttentionScale = "inside"  # of the softmax; "outside" is Eq. 4 as printed
    feature_scale: FeatureScale = "unit"  # "literal" does not normalize, and does not train
    theta_init: ThetaInit = "spread"  # equal numbers would stay equal
    logit_scale: Annotated[float, Within(1e-3, 1e4)] = 10.0  # of the cosine classifier
    generation: Generation = "tree"  # of nodes; series and parallel have as many matrices
    mffa: bool = True  # off: the tree grows from the embeddings
    complex_to_real: ComplexToReal = "tokens"  # Re and Im, |F| or Re alone
    order_per_modality: bool = False  # separate p for LANG, VIS and TAC
    guide: Guide = "both"  # F-bar of LANG in training: added to embeddings (Eq. 5), query (Eq. 6)
    guide_length: GuideLength = "embedding"  # of that F-bar: √D like embeddings, or 1 as printed
    fusion: Fusion = "mean"  # late fusion of VIS and TAC in prediction (`omnivat.head.fusion`)

    def __post_init__(self) -> None:
        checked_order(self.order)
        require_declared(self)
        if len(self.classes) < 2 or len(set(self.classes)) < len(self.classes):
            raise SettingsError(
                f"The classes are {self.classes}; give two or more different names."
            )
        counts = (2, *self.taught, len(self.classes))
        if self.taught and list(counts) != sorted(counts):
            raise SettingsError(
                f"taught is {self.taught}; give the numbers of classes before each teaching, from"
                f" 2 to {len(self.classes)}, in rising order."
            )

    @property
    def known(self) -> int:
        """The number of classes that the head has not learned by teaching."""
        return self.taught[0] if self.taught else len(self.classes)

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
