"""Every measure of a set of features or answers, under the name its curve has.

A measure takes what is known at one order and gives one or more named values; `omnivat.sweep`
asks for it at every order and keeps the curves. Names: docs/gaps.md.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial

import torch
from torch import Tensor

from omnivat.errors import ShapeError
from omnivat.gaps import GAPS
from omnivat.gaps.calibration import ece
from omnivat.gaps.confusion import accuracy, confusion, macro_f1
from omnivat.gaps.domain import pairwise_gaps
from omnivat.gaps.sums import PAIR, Sums
from omnivat.tables import load

Values = Iterator[tuple[str, Tensor]]


@dataclass(frozen=True, slots=True, kw_only=True)
class Facts:
    """What is true of N pairs whatever the order.

    labels, domains  (N,) indices; class_names and domain_names name them
    scored           (N,) bool: pairs whose class the head knows, so that an answer can be right
    """

    labels: Tensor
    class_names: tuple[str, ...]
    domains: Tensor
    domain_names: tuple[str, ...]
    scored: Tensor

    def parts(self) -> Iterator[tuple[str, Tensor]]:
        """Give "all" and each domain that has pairs, with a mask (N,)."""
        yield "all", torch.ones_like(self.scored)
        for index, name in self.named_domains():
            yield name, self.domains == index

    def named_domains(self) -> Iterator[tuple[int, str]]:
        """Give the index and the name of each domain that has pairs."""
        sizes = torch.bincount(self.domains, minlength=len(self.domain_names))
        yield from ((k, name) for k, name in enumerate(self.domain_names) if sizes[k])

    def sums(self) -> Sums:
        """Return empty sums; `Sums.add` takes labels and domains as they stand here."""
        return Sums(len(self.class_names), len(self.domain_names))


def modality_gaps(sums: Sums, facts: Facts) -> Values:
    """Give the modality gap over all pairs, and in each domain."""
    yield "", sums.centroid_gap()
    for index, name in facts.named_domains():
        yield f"/{name}", sums.centroid_gap(index)


def domain_gaps(sums: Sums, facts: Facts) -> Values:
    """Give the mean centroid gap of two domains: of both modalities' mean, and of each."""
    each = {name: sums.domain_gap(name) for name in ("vis", "tac")}
    yield "", torch.stack(list(each.values())).mean()
    for name, value in each.items():
        yield f":{name}", value


def margins(sums: Sums, facts: Facts) -> Values:
    """Give the margin of the pair's mean direction, of each modality, and across the gaps."""
    yield "", sums.margin(PAIR)
    for name in ("vis", "tac"):
        yield f":{name}", sums.margin(name)
    yield ":cross_domain", sums.cross_domain_margin(PAIR)
    yield ":cross_modal", sums.cross_modal_margin()


def mean_pairwise(features: Mapping[str, Tensor], facts: Facts, *, gap: str) -> Values:
    """Give the mean over every two domains, and both modalities, of a gap of `GAPS`.

    features  modality -> (N, W) unit rows; NaN where no two domains can be compared

    Raises ShapeError, with each domain's size, where one has too few rows for the gap.
    """
    measure = load(GAPS, gap, kind="gap")
    each: list[Tensor] = []
    sizes = {name: int(members.sum()) for name, members in facts.parts() if name != "all"}
    for rows in features.values():
        sets = {name: rows[members] for name, members in facts.parts() if name != "all"}
        try:
            each += pairwise_gaps(sets, measure).values()
        except ShapeError as error:  # it speaks of rows a and b; a person knows domains
            few = ", ".join(f"{name} {size}" for name, size in sizes.items())
            raise ShapeError(f"{gap}: {error} Pairs of each domain: {few}.") from error
    yield "", torch.stack(each).mean() if each else torch.tensor(float("nan"))


def accuracies(probabilities: Mapping[str, Tensor], facts: Facts) -> Values:
    """Give the accuracy of the fused prediction (over all, by domain) and of each other reading."""
    yield from _scores(probabilities, facts, lambda p, labels: accuracy(labels, p.argmax(1)))


def macro_f1s(
    probabilities: Mapping[str, Tensor], facts: Facts, *, average: str = "present"
) -> Values:
    """Give macro-F1 of the fused prediction (over all, by domain) and of each other reading."""
    yield from _scores(
        probabilities, facts, lambda p, labels: macro_f1(labels, p.argmax(1), average=average)
    )


def calibrations(probabilities: Mapping[str, Tensor], facts: Facts) -> Values:
    """Give the expected calibration error of the fused prediction and of each other reading."""
    yield from _scores(probabilities, facts, ece)


def confusions(probabilities: Mapping[str, Tensor], facts: Facts) -> Values:
    """Give the share of each class's pairs that the fused answer calls each class."""
    known = probabilities["fused"].shape[1]
    answers = probabilities["fused"][facts.scored].argmax(1)
    counts = confusion(facts.labels[facts.scored], answers, known)
    shares = counts / counts.sum(1, keepdim=True)  # NaN for a class without pairs
    for truth, row in zip(facts.class_names, shares, strict=False):
        for answer, share in zip(facts.class_names, row, strict=False):
            yield f"/{truth}>{answer}", share


def _scores(
    probabilities: Mapping[str, Tensor], facts: Facts, score: Callable[[Tensor, Tensor], Tensor]
) -> Values:
    for name, members in facts.parts():
        kept = members & facts.scored
        yield f"/{name}", score(probabilities["fused"][kept], facts.labels[kept])
    for name in probabilities:
        if name != "fused":
            kept = facts.scored
            yield f":{name}/all", score(probabilities[name][kept], facts.labels[kept])


Measure = Callable[[Mapping[str, Tensor], Facts], Values]
SumMeasure = Callable[[Sums, Facts], Values]


def by_sums(features: Mapping[str, Tensor], facts: Facts, *, measure: SumMeasure) -> Values:
    """Give what a measure of the sums has for features (N, W), modality -> rows of any length."""
    sums = facts.sums()
    sums.add(features, facts.labels, facts.domains)
    yield from measure(sums, facts)


# of the sums of a stage: rows need not be in memory together; `domain_gap` is the centroid gap
SUM_MEASURES: dict[str, SumMeasure] = {
    "modality_gap": modality_gaps,
    "domain_gap": domain_gaps,
    "margin": margins,
}

# of the features of a stage: curve names are measure[:variant]/stage[/domain]
STAGE_MEASURES: dict[str, Measure] = {
    **{name: partial(by_sums, measure=measure) for name, measure in SUM_MEASURES.items()},
    **{name: partial(mean_pairwise, gap=name) for name in GAPS if name != "centroid"},
}

# of the answers: curve names are measure[:modality]/all or measure/domain; confusion/truth>answer
ANSWER_MEASURES: dict[str, Measure] = {
    "accuracy": accuracies,
    "macro_f1": macro_f1s,
    "macro_f1_union": partial(macro_f1s, average="union"),
    "ece": calibrations,
    "confusion": confusions,
}
