"""Compared methods: the head with its settings, a part of it, or a baseline by name."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from omnivat.kit.errors import MissingNameError, SettingsError
from omnivat.kit.tables import unknown
from omnivat.study.baselines import BASELINES, LABELS, OPTIONAL, Label

HEAD = "omnivat"
NOISY = ("noise", "epochs")  # settings of training that baselines take, too
# Parts of the head as separate rows: changed settings, label and note.
Part = tuple[str, dict[str, Any], dict[str, Any]]
VARIANTS: dict[str, Part] = {
    "mffa_alone": ("MFFA alone", {"generation": "none"}, {}),
    "dtg_alone": ("DTG alone", {"mffa": False}, {}),
    "cosine_head": (
        "Cosine head, neither MFFA nor tree",
        {"mffa": False, "generation": "none"},
        {"nod_weight": 0.0},
    ),
}
# The head with one part switched off: shown in the tables, excluded from the lead.
ABLATED: dict[str, Part] = {
    "omnivat_no_lang": ("OmniVaT without LANG", {}, {"lang": False}),
    "omnivat_no_mma": ("OmniVaT without L_MMA", {}, {"mma_weight": 0.0}),
    "omnivat_no_nod": ("OmniVaT without L_NOD", {}, {"nod_weight": 0.0}),
    "omnivat_no_token": ("OmniVaT without class token", {"class_token": False}, {}),
    "omnivat_p0": (
        "OmniVaT, p = 0 fixed",
        {"order": 0.0, "learn_order": False},
        {"order_search": False},
    ),
}
DEFAULT_METHODS = (HEAD, *VARIANTS, *(name for name in BASELINES if name not in OPTIONAL))


@dataclass(frozen=True, slots=True, kw_only=True)
class Method:
    """A row of a table."""

    name: str  # unique; a file's records are grouped by it
    base: str = HEAD  # or a name in BASELINES
    head: Mapping[str, Any] = field(default_factory=dict)  # settings that differ from the defaults
    train: Mapping[str, Any] = field(default_factory=dict)  # the same, of training
    modalities: tuple[str, ...] = ("vis", "tac")  # input in prediction
    label: str = ""
    note: str = ""
    ablated: bool = False  # the head with one part switched off; excluded from the lead

    def __post_init__(self) -> None:
        if self.base != HEAD and self.base not in BASELINES:
            known = (HEAD, *VARIANTS, *ABLATED, *BASELINES)
            raise MissingNameError(unknown(self.base, known, kind="method"))


def methods_named(
    names: Sequence[str], head: Mapping[str, Any], train: Mapping[str, Any]
) -> list[Method]:
    """Return the methods; settings go to the head and its variants.

    With noise, the baselines get it too, and methods of gradient steps as many epochs.
    Raises MissingNameError, with the nearest name, for an unknown method.
    """
    if len(set(names)) < len(names):
        raise SettingsError(f"A method is named twice in {', '.join(names)}.")
    heads: dict[str, Part] = {HEAD: ("OmniVaT", {}, {}), **VARIANTS, **ABLATED}
    own = {key: train[key] for key in NOISY if key in train and train.get("noise")}
    found = []
    for name in names:
        if name in heads:
            label, of_head, of_train = heads[name]
            settings: dict[str, Any] = {"head": {**head, **of_head}, "train": {**train, **of_train}}
            ablated = name in ABLATED
            found.append(Method(name=name, label=label, ablated=ablated, **settings))
        else:
            label, note, _ = LABELS.get(name, Label(name))
            found.append(Method(name=name, base=name, train=own, label=label, note=note))
    return found
