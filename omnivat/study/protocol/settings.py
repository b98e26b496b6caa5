"""The eight SDG-VTL settings: one seen domain, its unseen targets, parts and classes."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from omnivat.data.domains import DOMAINS, paper_name
from omnivat.data.store import Embeddings
from omnivat.kit.errors import DataError
from omnivat.kit.tables import suggestion

SAME_SENSOR = frozenset({"OF 2.0 A", "OF 2.0 B"})  # both Taxim: never source and target


@dataclass(frozen=True, slots=True, kw_only=True)
class Setting:
    """One row of the paper's table of settings, by its names.

    part     of the source that is used ("" is all)
    targets  domain -> its part
    ceramic  True if that class is used
    """

    domain: str
    part: str = ""
    targets: Mapping[str, str]
    ceramic: bool = True


def _setting(source: str) -> Setting:
    """Build one row: TacQuad sensors train on one part and are tested on the other."""
    domain = DOMAINS[source]
    learn, tested = ("outdoor", "indoor") if "outdoor" in domain.series else ("indoor", "outdoor")
    if not domain.series:
        learn = tested = ""
    targets = {
        name: tested if other.series else ""
        for name, other in DOMAINS.items()
        if name != source and {name, source} != SAME_SENSOR
    }
    return Setting(domain=source, part=learn, targets=targets, ceramic=domain.ceramic)


SETTINGS = {name: _setting(name) for name in DOMAINS}


@dataclass(frozen=True, slots=True, kw_only=True)
class Task:
    """A setting on a set of embeddings: training pairs and test pairs."""

    setting: Setting
    classes: tuple[str, ...]
    train: Embeddings
    source_test: Embeddings  # test pairs of the source; may be empty
    targets: dict[str, Embeddings]  # by the name in the data, those with a class that was learned
    missing: tuple[str, ...]  # the other targets of the paper


def available(embeddings: Embeddings) -> tuple[str, ...]:
    """Return the sources in the embeddings: the paper's, by its names and in its order.

    Without any of them: every domain with two or more classes, by its own name.
    """
    present = {paper_name(name) for name in embeddings.header.domains}
    return tuple(name for name in SETTINGS if name in present) or embeddings.learnable


def task(embeddings: Embeddings, source: str) -> Task:
    """Return the task of one source on these embeddings.

    source  the paper's name, that of its simulated domain, or any domain of the embeddings, whose
            targets are all others
    Raises DataError if the source is unknown or has no training pairs.
    """
    setting = SETTINGS.get(paper_name(source))
    if setting is None:
        domains = embeddings.header.domains
        if source not in domains:
            hint = suggestion(paper_name(source), [*SETTINGS, *domains])
            raise DataError(
                f"'{source}' is not one of the paper's domains, nor of these embeddings.{hint}"
            )
        others = {paper_name(name): "" for name in domains if name != source}
        setting = Setting(domain=paper_name(source), targets=others)
    names = {paper_name(name): name for name in embeddings.header.domains}
    if setting.domain not in names:
        raise DataError(
            f"The embeddings have no domain '{setting.domain}'; there are "
            f"{', '.join(embeddings.header.domains)}."
        )
    dropped = () if setting.ceramic else ("ceramic",)

    def pairs_of(domain: str, split: str, part: str) -> Embeddings:
        pairs = embeddings.in_domain(names[domain], split=split, part=part)
        index = [i for i, name in enumerate(pairs.header.classes) if name in dropped]
        return pairs.select(~np.isin(pairs.label, index))

    train = pairs_of(setting.domain, "train", setting.part)
    if not len(train):
        part = f" of its part '{setting.part}'" if setting.part else ""
        raise DataError(f"'{names[setting.domain]}' has no pairs{part} to train on.")
    test = pairs_of(setting.domain, "test", setting.part)
    present = set(train.label.tolist())
    targets, missing = {}, []
    for domain, part in setting.targets.items():
        pairs = pairs_of(domain, "test", part) if domain in names else None
        if pairs is None or present.isdisjoint(pairs.label.tolist()):
            missing.append(f"{domain} ({part})" if part else domain)
        else:
            targets[names[domain]] = pairs
    return Task(
        setting=setting,
        classes=tuple(
            name for index, name in enumerate(embeddings.header.classes) if index in present
        ),
        train=train,
        source_test=test if any(test.rows["split"]) else test.select(test.label < 0),
        targets=targets,
        missing=tuple(missing),
    )
