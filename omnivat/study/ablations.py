"""The paper's ablations as plain data: the settings changed by each row of a table or figure.

A row overrides settings of the head and of training in the base settings of a run. The row "full"
changes nothing and runs once for all tables.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from omnivat.data.domains import DOMAINS
from omnivat.kit.tables import entry

TWO_SOURCES = ("TAG", "OF 2.0 A")  # the sources of the paper's ablations
ALL_SOURCES = tuple(DOMAINS)


@dataclass(frozen=True, slots=True)
class Row:
    """One variant. `base` is the head unless it names a baseline."""

    label: str
    head: Mapping[str, Any] = field(default_factory=dict)
    train: Mapping[str, Any] = field(default_factory=dict)
    modalities: tuple[str, ...] = ("vis", "tac")
    base: str = "omnivat"
    value: float | None = None  # position in a figure


@dataclass(frozen=True, slots=True)
class Ablation:
    """One table or figure of the paper."""

    title: str
    rows: Mapping[str, Row]
    sources: tuple[str, ...] = TWO_SOURCES
    axis: str = ""  # a figure's horizontal axis


FULL = Row("OmniVaT")
BASELINE = Row("Baseline", base="baseline")


def _modalities(lang: bool, names: tuple[str, ...]) -> Row:
    label = "LANG / " * lang + " / ".join(names).upper()
    return Row(label, train={"lang": lang, "modalities": "+".join(names)}, modalities=names)


def _along(axis: str, places: Sequence[float], row: Callable[[Any], Row]) -> dict[str, Row]:
    """Return the rows of a figure: one at each place of its axis."""
    return {f"{axis} {place:g}": replace(row(place), value=place) for place in places}


def _fixed(p: float) -> Row:
    return Row(f"p = {p:g} (fixed)", head={"order": p, "learn_order": False}, value=p)


ONLY_MFFA = {"generation": "none"}
ONLY_DTG = {"mffa": False}

ABLATIONS = {
    "components": Ablation(
        "Key components",
        rows={
            "baseline": BASELINE,
            "mffa without MMA": Row(
                "+ MFFA (without L_MMA)", head=ONLY_MFFA, train={"mma_weight": 0.0}
            ),
            "mffa": Row("+ MFFA", head=ONLY_MFFA),
            "dtg without NOD": Row(
                "+ DTG (without L_NOD)", head=ONLY_DTG, train={"nod_weight": 0.0}
            ),
            "dtg": Row("+ DTG", head=ONLY_DTG),
            "full": FULL,
        },
    ),
    "generation": Ablation(
        "Feature generation, seven nodes each",
        rows={
            "baseline": BASELINE,
            "interpolation": Row(
                "OmniVaT (linear interpolation)", head={"generation": "interpolation"}
            ),
            "series": Row("OmniVaT (series)", head={"generation": "series"}),
            "parallel": Row("OmniVaT (parallel)", head={"generation": "parallel"}),
            "full": FULL,
        },
    ),
    "class_token": Ablation(
        "Global class token",
        rows={
            "baseline": BASELINE,
            "without class token": Row(
                "OmniVaT (without class token)", head={"class_token": False}
            ),
            "full": FULL,
        },
    ),
    "modalities": Ablation(
        "Modalities in training and prediction",
        sources=("TAG",),
        rows={
            "vis": _modalities(False, ("vis",)),
            "tac": _modalities(False, ("tac",)),
            "vis+tac": _modalities(False, ("vis", "tac")),
            "lang, vis": _modalities(True, ("vis",)),
            "lang, tac": _modalities(True, ("tac",)),
            "full": FULL,
        },
    ),
    "order": Ablation(
        "Fractional order p: fixed at 0 and 1, learnable from elsewhere",
        sources=("TAG",),
        axis="p",
        rows={
            "p 0": _fixed(0.0),
            **_along(
                "p", (0.1, 0.3, 0.5, 0.7, 0.9), lambda p: Row(f"p = {p:g}", head={"order": p})
            ),
            "p 1": _fixed(1.0),
            "p 0.5 fixed": replace(_fixed(0.5), value=None),
            "p per modality": Row(
                "p = 0.5, one for each modality", head={"order_per_modality": True}
            ),
        },
    ),
    "fixed_order": Ablation(
        "Fractional order p: a head trained anew at each fixed value",
        axis="p, fixed",
        rows={
            **{f"p {tenth / 10:g} fixed": _fixed(tenth / 10) for tenth in range(11)},
            "full": Row("OmniVaT, p learned from 0.5"),
        },
    ),
    "projection": Ablation(
        "Projection to the head's width (ours): one map for VIS and TAC, or one each",
        sources=ALL_SOURCES,
        rows={
            "shared projection": Row(
                "OmniVaT (one map for VIS and TAC)", head={"shared_projection": True}
            ),
            "full": FULL,
        },
    ),
    "details": Ablation(
        "Details that the paper leaves open (ours)",
        rows={
            "theta ones": Row("θ_e all ones at the start", head={"theta_init": "ones"}),
            "guide added": Row("guide added only (Eq. 5)", head={"guide": "added"}),
            "guide query": Row("guide as query only (Eq. 6)", head={"guide": "query"}),
            "guide unit": Row("guide of length 1 in place of √D", head={"guide_length": "unit"}),
            "bank all": Row(
                "class tokens of guided pairs in the bank, too", train={"bank_from": "all"}
            ),
            "mma guided": Row("L_MMA on pairs guided by LANG only", train={"mma_on": "guided"}),
            "full": FULL,
        },
    ),
    "levels": Ablation(
        "Depth R of the tree",
        sources=("TAG",),
        axis="R",
        rows=_along(
            "R",
            (1, 2, 3, 4, 5),
            lambda n: Row(f"R = {n}, {2**n - 1} node{'s' * (n > 1)}", head={"levels": n}),
        ),
    ),
    "expansion": Ablation(
        "Expansion E",
        sources=("TAG",),
        axis="E",
        rows=_along("E", (1, 2, 3, 4, 6, 8), lambda n: Row(f"E = {n}", head={"expansion": n})),
    ),
    "balance": Ablation(
        "Balance weight λ of L_MMA",
        sources=("TAG",),
        axis="λ",
        rows=_along(
            "λ", (0.0, 0.1, 1.0, 10.0, 100.0), lambda x: Row(f"λ = {x:g}", train={"mma_weight": x})
        ),
    ),
}


def chosen(names: tuple[str, ...]) -> dict[str, Ablation]:
    """Return ablations by name; without names, all. Raises MissingNameError with the nearest
    name.
    """
    return {name: entry(ABLATIONS, name, kind="ablation") for name in names or ABLATIONS}


def method_name(row: str) -> str:
    """Return the name of a row's runs in the records, so that tables share them."""
    return f"ablation: {row}"
