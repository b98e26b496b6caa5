"""What is compared: the head with its settings, or a baseline by name."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from omnivat.baselines import BASELINES, LABELS
from omnivat.errors import MissingNameError, SettingsError
from omnivat.tables import suggestion

HEAD = "omnivat"
DEFAULT_METHODS = (HEAD, *(name for name in BASELINES if name != "robust_vish"))


@dataclass(frozen=True, slots=True, kw_only=True)
class Method:
    """A row of a table.

    name        unique; a file's records are grouped by it
    base        "omnivat" or a name in BASELINES
    head        settings of the head that differ from the defaults
    train       settings of training that differ from the defaults
    modalities  what is given when predicting
    """

    name: str
    base: str = HEAD
    head: Mapping[str, Any] = field(default_factory=dict)
    train: Mapping[str, Any] = field(default_factory=dict)
    modalities: tuple[str, ...] = ("vis", "tac")
    label: str = ""
    note: str = ""

    def __post_init__(self) -> None:
        if self.base != HEAD and self.base not in BASELINES:
            known = ", ".join((HEAD, *BASELINES))
            hint = suggestion(self.base, (HEAD, *BASELINES))
            raise MissingNameError(f"No method is called '{self.base}'; there are {known}.{hint}")
        if self.base != HEAD and (self.head or self.train):
            raise SettingsError(
                f"'{self.base}' takes no settings: it tunes itself on the source. Settings are "
                f"for {HEAD}."
            )


def methods_named(
    names: Sequence[str], head: Mapping[str, Any], train: Mapping[str, Any]
) -> list[Method]:
    """Return the methods; settings go to the head alone.

    Raises MissingNameError, with the nearest name, for a method that is not there.
    """
    if len(set(names)) < len(names):
        raise SettingsError(f"A method is named twice in {', '.join(names)}.")
    return [
        Method(name=name, head=head, train=train, label="OmniVaT")
        if name == HEAD
        else Method(
            name=name,
            base=name,
            label=LABELS[name].name if name in LABELS else name,
            note=LABELS[name].note if name in LABELS else "",
        )
        for name in names
    ]
