"""The eight SDG-VTL settings: one seen domain, its unseen targets, parts and classes."""

from collections.abc import Sequence
from dataclasses import dataclass

from omnivat.data.domains import DOMAINS, paper_name
from omnivat.data.store import Embeddings
from omnivat.errors import DataError
from omnivat.tables import suggestion

SAME_SENSOR = frozenset({"OF 2.0 A", "OF 2.0 B"})  # both Taxim: never source and target


@dataclass(frozen=True, slots=True, kw_only=True)
class Side:
    """A domain by the paper's name, and the part that is used ("" is all)."""

    domain: str
    part: str = ""

    def __str__(self) -> str:
        return f"{self.domain} ({self.part})" if self.part else self.domain


@dataclass(frozen=True, slots=True, kw_only=True)
class Setting:
    """One row of the paper's table of settings. `ceramic`: True if that class is used."""

    source: Side
    targets: tuple[Side, ...]
    ceramic: bool


def _setting(source: str) -> Setting:
    """Build one row: TacQuad sensors train on one part and are tested on the other."""
    domain = DOMAINS[source]
    tacquad = bool(domain.series)
    learn = ("outdoor" if "outdoor" in domain.series else "indoor") if tacquad else ""
    tested_part = ("indoor" if learn == "outdoor" else "outdoor") if tacquad else ""
    targets = []
    for name, other in DOMAINS.items():
        if name == source or {name, source} == SAME_SENSOR:
            continue
        targets.append(Side(domain=name, part=tested_part if other.series else ""))
    return Setting(source=Side(domain=source, part=learn), targets=tuple(targets), ceramic=domain.ceramic)


SETTINGS = {name: _setting(name) for name in DOMAINS}


@dataclass(frozen=True, slots=True, kw_only=True)
class Task:
    """A setting on a set of embeddings: training pairs and test pairs."""

    setting: Setting
    classes: tuple[str, ...]
    train: Embeddings
    source_test: Embeddings  # test pairs of the source; may be empty
    targets: dict[str, Embeddings]  # by the name in the data
    missing: tuple[str, ...]  # targets of the paper that are not in the data


def available(embeddings: Embeddings) -> tuple[str, ...]:
    """Return the sources in the embeddings: the paper's, by its names and in its order.

    Without any of them: every domain with two or more classes, by its own name.
    """
    present = {paper_name(name) for name in embeddings.header.domains}
    return tuple(name for name in SETTINGS if name in present) or embeddings.learnable


def own_setting(source: str, domains: Sequence[str]) -> Setting:
    """Return the setting of a domain that is not in the paper: all others are its targets."""
    sides = tuple(Side(domain=paper_name(name)) for name in domains if name != source)
    return Setting(source=Side(domain=paper_name(source)), targets=sides, ceramic=True)


def task(embeddings: Embeddings, source: str) -> Task:
    """Return the task of one source on these embeddings.

    source  the paper's name, that of its simulated domain, or any domain of the embeddings

    Raises DataError if the source is unknown or has no training pairs.
    """
    setting = SETTINGS.get(paper_name(source))
    if setting is None:
        domains = embeddings.header.domains
        if source not in domains:
            hint = suggestion(paper_name(source), [*SETTINGS, *domains])
            raise DataError(f"'{source}' is not one of the paper's domains, nor of these embeddings.{hint}")
        setting = own_setting(source, domains)
    names = {paper_name(name): name for name in embeddings.header.domains}
    if setting.source.domain not in names:
        raise DataError(
            f"The embeddings have no domain '{setting.source.domain}'; there are "
            f"{', '.join(embeddings.header.domains)}."
        )
    own = names[setting.source.domain]
    dropped = () if setting.ceramic else ("ceramic",)
    train = _without(embeddings.in_domain(own, split="train", part=setting.source.part), dropped)
    if not len(train):
        raise DataError(f"'{own}' has no pairs of {setting.source} to train on.")
    test = embeddings.in_domain(own, split="test", part=setting.source.part)
    present = set(train.label.tolist())
    targets = {
        names[side.domain]: _without(embeddings.in_domain(names[side.domain], split="test", part=side.part), dropped)
        for side in setting.targets
        if side.domain in names
    }
    return Task(
        setting=setting,
        classes=tuple(name for index, name in enumerate(embeddings.header.classes) if index in present),
        train=train,
        source_test=_without(test, dropped) if any(test.rows["split"]) else test.select(test.label < 0),
        targets={name: pairs for name, pairs in targets.items() if _shares_classes(pairs, present)},
        missing=tuple(
            str(side)
            for side in setting.targets
            if side.domain not in names or not _shares_classes(targets[names[side.domain]], present)
        ),
    )


def _shares_classes(pairs: Embeddings, classes: set[int]) -> bool:
    """True if any pair has a class that was learned."""
    return not classes.isdisjoint(pairs.label.tolist())


def _without(pairs: Embeddings, classes: tuple[str, ...]) -> Embeddings:
    """Return the pairs of other classes than these."""
    index = [i for i, name in enumerate(pairs.header.classes) if name in classes]
    keep = ~(pairs.label[:, None] == index).any(1) if index else pairs.label >= 0
    return pairs.select(keep)
