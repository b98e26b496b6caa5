"""All measures of features and predictions, by the names of their curves.

A measure computes one or more named values at one order; `omnivat.maps.sweep` evaluates it at every
order. Names: docs/gaps.md.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial

import torch
from jaxtyping import Bool, Float, Int
from torch import Tensor

from omnivat.kit.errors import ShapeError
from omnivat.kit.tables import load
from omnivat.measure.gaps import GAPS
from omnivat.measure.gaps.calibration import ece
from omnivat.measure.gaps.confusion import accuracy, confusion, macro_f1
from omnivat.measure.gaps.domain import pairwise_gaps
from omnivat.measure.gaps.sums import PAIR, Sums

Values = Iterator[tuple[str, Float[Tensor, ""]]]
Features = Mapping[str, Float[Tensor, "N W"]]  # by modality; or probabilities by reading


@dataclass(frozen=True, slots=True, kw_only=True)
class Facts:
    """Facts about N pairs that do not depend on the order.

    class_names and domain_names name the indices; scored: pairs whose class the head has
    """

    labels: Int[Tensor, " N"]
    class_names: tuple[str, ...]
    domains: Int[Tensor, " N"]
    domain_names: tuple[str, ...]
    scored: Bool[Tensor, " N"]

    def parts(self) -> Iterator[tuple[str, Bool[Tensor, " N"]]]:
        """Yield "all" and each domain with pairs, and its mask."""
        yield "all", torch.ones_like(self.scored)
        for index, name in self.named_domains():
            yield name, self.domains == index

    def named_domains(self) -> Iterator[tuple[int, str]]:
        """Yield index and name of each domain with pairs."""
        sizes = torch.bincount(self.domains, minlength=len(self.domain_names))
        yield from ((k, name) for k, name in enumerate(self.domain_names) if sizes[k])

    def sums(self) -> Sums:
        """Return empty sums of these pairs."""
        return Sums(self.labels, self.domains)


def modality_gaps(sums: Sums, facts: Facts) -> Values:
    """Yield the modality gap over all pairs, and in each domain."""
    yield "", sums.centroid_gap()
    for index, name in facts.named_domains():
        yield f"/{name}", sums.centroid_gap(index)


def domain_gaps(sums: Sums, facts: Facts) -> Values:
    """Yield the mean centroid gap between domains: averaged over modalities, and of each."""
    each = {name: sums.domain_gap(name) for name in ("vis", "tac")}
    yield "", torch.stack(list(each.values())).mean()
    for name, value in each.items():
        yield f":{name}", value


def margins(sums: Sums, facts: Facts) -> Values:
    """Yield the margin of the pair's mean direction, of each modality, and across both gaps."""
    yield "", sums.margin(PAIR)
    for name in ("vis", "tac"):
        yield f":{name}", sums.margin(name)
    yield ":cross_domain", sums.cross_domain_margin(PAIR)
    yield ":cross_modal", sums.cross_modal_margin()


def mean_pairwise(features: Features, facts: Facts, *, gap: str) -> Values:
    """Yield a gap of `GAPS`, averaged over all pairs of domains and both modalities.

    features  by modality, unit rows; NaN if no two domains can be compared

    Raises ShapeError, with each domain's size, if one has too few rows for the gap.
    """
    measure = load(GAPS, gap, kind="gap")
    each: list[Tensor] = []
    members = {name: facts.domains == index for index, name in facts.named_domains()}
    for rows in features.values():
        try:
            sets = {name: rows[own] for name, own in members.items()}
            each += pairwise_gaps(sets, measure).values()
        except ShapeError as error:  # the first message names rows a and b; add the domains
            few = ", ".join(f"{name} {int(own.sum())}" for name, own in members.items())
            raise ShapeError(f"{gap}: {error} Pairs of each domain: {few}.") from error
    yield "", torch.stack(each).mean() if each else torch.tensor(float("nan"))


def confusions(probabilities: Features, facts: Facts) -> Values:
    """Yield, for each class, the shares of its pairs by the class predicted from both images."""
    known = probabilities["fused"].shape[1]
    predicted = probabilities["fused"][facts.scored].argmax(1)
    counts = confusion(facts.labels[facts.scored], predicted, known)
    shares = counts / counts.sum(1, keepdim=True)  # NaN for a class without pairs
    for truth, row in zip(facts.class_names, shares, strict=False):
        for predicted_class, share in zip(facts.class_names, row, strict=False):
            yield f"/{truth}>{predicted_class}", share


def scores(
    probabilities: Features, facts: Facts, *, score: Callable[[Tensor, Tensor], Tensor]
) -> Values:
    """Yield a score of the fused prediction (all, by domain) and of each other reading."""
    for name, members in facts.parts():
        kept = members & facts.scored
        yield f"/{name}", score(probabilities["fused"][kept], facts.labels[kept])
    for name in probabilities:
        if name != "fused":
            kept = facts.scored
            yield f":{name}/all", score(probabilities[name][kept], facts.labels[kept])


# Curve names are measure[:variant]/stage[/domain]. Of the sums of a stage, whose rows need not be
# in memory together; `domain_gap` is the centroid gap.
SUM_MEASURES: dict[str, Callable[[Sums, Facts], Values]] = {
    "modality_gap": modality_gaps,
    "domain_gap": domain_gaps,
    "margin": margins,
}
# of the unit rows of a stage
ROW_MEASURES: dict[str, Callable[[Features, Facts], Values]] = {
    name: partial(mean_pairwise, gap=name) for name in GAPS if name != "centroid"
}
STAGE_MEASURES = (*SUM_MEASURES, *ROW_MEASURES)

# of predictions: curve names are measure[:modality]/all or measure/domain; confusion/truth>class
PREDICTION_MEASURES: dict[str, Callable[[Features, Facts], Values]] = {
    "accuracy": partial(scores, score=lambda p, labels: accuracy(labels, p.argmax(1))),
    "macro_f1": partial(scores, score=lambda p, labels: macro_f1(labels, p.argmax(1))),
    "macro_f1_union": partial(
        scores, score=lambda p, labels: macro_f1(labels, p.argmax(1), union=True)
    ),
    "ece": partial(scores, score=ece),
    "confusion": confusions,
}
