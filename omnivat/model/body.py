"""What training and prediction share: projections, MFFA, the tree and the classifier."""

from collections.abc import Mapping

import torch
from torch import Tensor, nn
from torch.nn.functional import linear, normalize

from omnivat.errors import DataError, ShapeError
from omnivat.lengths import unit
from omnivat.modalities import IMAGES, MODALITIES
from omnivat.model.dtg import DTG
from omnivat.model.fusion import Calibration
from omnivat.model.mffa import MFFA
from omnivat.model.settings import HeadSettings


class Body(nn.Module):
    """The modules of a head, and the steps at both ends: embeddings in, logits out."""

    def __init__(self, settings: HeadSettings) -> None:
        super().__init__()
        self.settings = settings
        width = settings.width
        if settings.projects:
            self.project_image: nn.Module = nn.Linear(settings.input_width, width)
        else:
            self.project_image = nn.Identity()
        if settings.projects_apart:
            self.project_tac = nn.Linear(settings.input_width, width)
        if settings.project or settings.lang_width != width:
            self.project_lang: nn.Module = nn.Linear(settings.lang_width, width)
        else:
            self.project_lang = nn.Identity()
        self.mffa = MFFA(settings)
        self.dtg = DTG.from_settings(settings)
        self.classifier = nn.Parameter(torch.empty(len(settings.classes), width))
        if not self.classifier.is_meta:  # there, torch would load its compiler for this: 0.9 s
            nn.init.normal_(self.classifier, std=width**-0.5)
        self.calibration = Calibration()  # see omnivat.calibration

    @property
    def order(self) -> float:
        """The learned fractional order p, in quarter turns; the mean of VIS and TAC if each has one."""
        return float(self.mffa.orders(IMAGES).detach().mean())

    @property
    def orders(self) -> dict[str, float]:
        """The learned order of each modality, LANG included."""
        own = self.mffa.order.detach().expand(len(MODALITIES)).tolist()
        return dict(zip(MODALITIES, own, strict=True))

    @property
    def dtype(self) -> torch.dtype:
        """The precision of the head."""
        return self.classifier.dtype

    def classify(self, features: Tensor, directions: Tensor | None = None) -> Tensor:
        """Return logits (..., K) of features (..., D), such as F-hat or tree nodes.

        directions  the class directions (K, D) of `directions`; computed if None
        """
        if self.settings.feature_scale == "literal":
            return linear(features, self.classifier)
        directions = self.directions() if directions is None else directions
        lengths = torch.linalg.vector_norm(features, dim=-1, keepdim=True)
        logits: Tensor = linear(features, directions) / lengths.clamp_min(1e-12)
        return logits

    def directions(self) -> Tensor:
        """Return the class directions (K, D); their length is the logit scale."""
        return self.settings.logit_scale * normalize(self.classifier, dim=-1)

    @property
    def length(self) -> float:
        """Length of an embedding before the transform: √D, so that entries are near 1."""
        return 1.0 if self.settings.feature_scale == "literal" else float(self.settings.width**0.5)

    def embedded(self, given: Mapping[str, Tensor]) -> Tensor:
        """Return embeddings (M, B, D) for the transform: projected, of length √D.

        given  VIS and TAC (B, input_width), or LANG alone (B, lang_width), from the encoders

        Raises DataError if none is given, ShapeError for wrong widths or unequal numbers of pairs.
        """
        if not given:
            raise DataError("Neither VIS nor TAC was given; give one of them or both.")
        lang = "lang" in given
        width = self.settings.lang_width if lang else self.settings.input_width
        for name, raw in given.items():
            if raw.ndim != 2 or raw.shape[1] != width:
                raise ShapeError(
                    f"{name} has shape {tuple(raw.shape)}; this head needs (B, {width}). "
                    "Use embeddings of the encoder that the head was trained with."
                )
        if len({len(raw) for raw in given.values()}) > 1:
            raise ShapeError(
                "vis and tac have different numbers of pairs; give one of each for every pair."
            )
        raw = torch.stack([raw.to(self.dtype) for raw in given.values()])
        projected: Tensor
        if self.settings.projects_apart and not lang:
            projected = torch.stack(
                [self._projection(n)(r) for n, r in zip(given, raw, strict=True)]
            )
        else:
            projected = (self.project_lang if lang else self.project_image)(raw)
        if self.settings.feature_scale == "literal":
            return projected
        return self.length * unit(projected)

    def _projection(self, name: str) -> nn.Module:
        return self.project_tac if name == "tac" else self.project_image
