"""What training and prediction share: projections, MFFA, the tree and the classifier."""

import math
from collections.abc import Mapping

import torch
from jaxtyping import Float
from torch import Tensor, nn
from torch.nn.functional import linear, normalize

from omnivat.data.profile import Profile, floor_of, scale_of
from omnivat.head.dtg import DTG
from omnivat.head.fusion import UNFITTED, Temperatures
from omnivat.head.mffa import MFFA
from omnivat.head.output import Lessons
from omnivat.head.settings import HeadSettings
from omnivat.kit.errors import DataError, ShapeError
from omnivat.kit.shapes import floating, require_finite, unit
from omnivat.kit.stages import IMAGES, MODALITIES


class Body(nn.Module):
    """The modules of a head, and the steps at both ends: embeddings in, logits out."""

    input_mean: Float[Tensor, "2 W"]  # of VIS and TAC, if the head standardizes
    input_scale: Float[Tensor, "2 W"]
    map_rows: Float[Tensor, "2 K W"]
    map_bias: Float[Tensor, " K"]
    map_alone_rows: Float[Tensor, "2 K W"]
    map_alone_bias: Float[Tensor, "2 K"]
    taught_rows: Float[Tensor, "N 2 K W"]
    taught_bias: Float[Tensor, "N K"]
    taught_share: Float[Tensor, " N"]

    def __init__(self, settings: HeadSettings) -> None:
        super().__init__()
        self.settings = settings
        width = settings.width
        raw, shapes = settings.input_width, dict[str, tuple[int, ...]]()
        if settings.standardize:  # the source's profile; training sets it
            shapes |= {"input_mean": (2, raw), "input_scale": (2, raw)}
        if settings.maps:
            known = settings.known
            shapes |= {"map_rows": (2, known, raw), "map_bias": (known,)}
            shapes |= {"map_alone_rows": (2, known, raw), "map_alone_bias": (2, known)}
        if settings.taught:
            times, classes = len(settings.taught), len(settings.classes)
            shapes |= {"taught_rows": (times, 2, classes, raw), "taught_bias": (times, classes)}
            shapes |= {"taught_share": (times,)}
        for name, shape in shapes.items():
            self.register_buffer(name, torch.full(shape, float(name == "input_scale")))
        self.project_image: nn.Module = nn.Identity()
        if settings.projects:
            self.project_image = nn.Linear(raw, width)
        if settings.projects_apart:
            self.project_tac = nn.Linear(raw, width)
        self.project_lang: nn.Module = nn.Identity()
        if settings.project or settings.lang_width != width:
            self.project_lang = nn.Linear(settings.lang_width, width)
        self.mffa = MFFA(settings)
        self.dtg = DTG(width, settings.edges, settings.generation)
        self.classifier = nn.Parameter(torch.empty(len(settings.classes), width))
        if not self.classifier.is_meta:  # there, torch would load its compiler for this: 0.9 s
            nn.init.normal_(self.classifier, std=width**-0.5)
        self.temperatures: Temperatures = UNFITTED  # see omnivat.head.calibration

    @property
    def order(self) -> float:
        """The learned fractional order p, in quarter turns; the mean of VIS and TAC if each has
        one.
        """
        return float(self.mffa.orders(IMAGES).detach().mean())

    @property
    def orders(self) -> dict[str, float]:
        """The learned order of each modality, LANG included."""
        orders = self.mffa.order.detach().expand(len(MODALITIES))
        return dict(zip(MODALITIES, orders.tolist(), strict=True))

    @property
    def dtype(self) -> torch.dtype:
        """The precision of the head."""
        return self.classifier.dtype

    def classify(
        self, features: Float[Tensor, "*any D"], directions: Float[Tensor, "K D"] | None = None
    ) -> Float[Tensor, "*any K"]:
        """Return logits of features such as F-hat or tree nodes; `directions` are computed if
        None.
        """
        if self.settings.feature_scale == "literal":
            return linear(features, self.classifier)
        directions = self.directions() if directions is None else directions
        lengths = torch.linalg.vector_norm(features, dim=-1, keepdim=True)
        logits: Tensor = linear(features, directions) / lengths.clamp_min(1e-12)
        return logits

    def directions(self) -> Float[Tensor, "K D"]:
        """Return the class directions; their length is the logit scale."""
        return self.settings.logit_scale * normalize(self.classifier, dim=-1)

    @property
    def length(self) -> float:
        """Length of an embedding before the transform: √D, so that entries are near 1."""
        return 1.0 if self.settings.feature_scale == "literal" else float(self.settings.width**0.5)

    def embedded(self, images: Mapping[str, Float[Tensor, "B _"]]) -> Float[Tensor, "M B D"]:
        """Return embeddings for the transform: projected, of length √D, if not "literal".

        images  VIS and TAC of input_width, or LANG alone of lang_width, from the encoders

        Raises DataError if none is given and for values that are not finite,
        ShapeError for wrong widths or unequal numbers of pairs.
        """
        if not images:
            raise DataError("Neither VIS nor TAC was given; give one of them or both.")
        lang = "lang" in images
        width = self.settings.lang_width if lang else self.settings.input_width
        images = {name: floating(name, raw).to(self.dtype) for name, raw in images.items()}
        for name, raw in images.items():
            if raw.ndim != 2 or raw.shape[1] != width:
                raise ShapeError(
                    f"{name} has shape {tuple(raw.shape)}; this head needs (B, {width}). "
                    "Use embeddings of the encoder that the head was trained with."
                )
            require_finite(name, raw)
        first, *others = images.values()
        if any(raw.shape[0] != first.shape[0] for raw in others):
            raise ShapeError(
                "vis and tac have different numbers of pairs; give one of each for every pair."
            )
        raw = torch.stack([self.standardised(*image) for image in images.items()])
        projected: Tensor
        if self.settings.projects_apart and not lang:
            maps = {"vis": self.project_image, "tac": self.project_tac}
            projected = torch.stack([maps[n](r) for n, r in zip(images, raw, strict=True)])
        else:
            projected = (self.project_lang if lang else self.project_image)(raw)
        literal = self.settings.feature_scale == "literal"
        return projected if literal else self.length * unit(projected)

    def standardize_by(self, profile: Profile) -> None:
        """Take over the channel statistics of the source's training pairs."""
        for name, channels in profile.channels.items():
            row = IMAGES.index(name)
            scale = scale_of(channels, floor_of(channels))
            self.input_mean[row] = torch.from_numpy(channels.mean).to(self.input_mean)
            self.input_scale[row] = torch.from_numpy(scale).to(self.input_scale)

    def standardised(self, name: str, raw: Float[Tensor, "B W"]) -> Float[Tensor, "B W"]:
        """Return bounded, standardised rows of length √W / 2 (data/profile.py)."""
        if not self.settings.standardize or name not in IMAGES:
            return raw
        row = IMAGES.index(name)
        rows = torch.tanh((raw - self.input_mean[row]) / self.input_scale[row])
        return 0.5 * math.sqrt(self.settings.input_width) * unit(rows)

    def standing(self, name: str, raw: Float[Tensor, "B W"]) -> Float[Tensor, "B W"]:
        """Return a modality's standardised rows of length √½, for teaching: side by side, length
        1.
        """
        return math.sqrt(0.5) * unit(self.standardised(name, raw.to(self.dtype)))

    def map_logits(
        self, images: Mapping[str, Float[Tensor, "B W"]]
    ) -> dict[str, Float[Tensor, "B K"]]:
        """Return logits of the linear maps: "fused", and "vis", "tac" of one image alone.

        A pair has the mean of the probabilities of three maps. {} for a head without maps.
        """
        if not self.settings.maps:
            return {}
        scores, both = {}, []
        for name, raw in images.items():
            rows, place = self.standing(name, raw), IMAGES.index(name)
            scores[name] = linear(rows, self.map_alone_rows[place], self.map_alone_bias[place])
            both.append(linear(rows, self.map_rows[place]))
        if len(both) == 1:
            return scores | {"fused": scores[name]}
        each = [*scores.values(), torch.stack(both).sum(0) + self.map_bias]
        scores["fused"] = torch.stack([x.softmax(-1) for x in each]).mean(0).log()
        return scores

    def lessons(self, images: Mapping[str, Float[Tensor, "B W"]]) -> Lessons | None:
        """Return what teaching adds to the predictions; None if the head was not taught."""
        if not self.settings.taught:
            return None
        rows = {name: self.standing(name, raw) for name, raw in images.items()}
        return Lessons.of(
            rows, self.taught_rows, self.taught_bias, self.taught_share, self.settings.taught
        )
