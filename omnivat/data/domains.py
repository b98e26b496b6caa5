"""The eight visual-tactile domains of the paper, and what a simulated one is called."""

from dataclasses import dataclass

SIMULATED_SUFFIX = "-sim"


@dataclass(frozen=True, slots=True, kw_only=True)
class Domain:
    """One way of collecting pairs: a tactile sensor and a data set (paper, Table of datasets)."""

    name: str  # as the paper writes it
    sensor: str
    series: tuple[str, ...] = ()  # parts of TacQuad: "indoor", "outdoor"
    ceramic: bool = True  # TacQuad has no ceramic objects


DOMAINS = {
    domain.name: domain
    for domain in (
        Domain(name="TAG", sensor="GelSight"),
        Domain(name="OF Real", sensor="GelSlim"),
        Domain(name="OF 2.0 A", sensor="Taxim"),
        Domain(name="OF 2.0 B", sensor="Taxim"),
        Domain(name="TQ-DIGIT", sensor="DIGIT", series=("indoor", "outdoor"), ceramic=False),
        Domain(
            name="TQ-GelMini", sensor="GelSight Mini", series=("indoor", "outdoor"), ceramic=False
        ),
        Domain(name="TQ-DuraGel", sensor="DuraGel", series=("indoor", "outdoor"), ceramic=False),
        Domain(name="TQ-T3D", sensor="Tac3D", series=("indoor",), ceramic=False),
    )
}


@dataclass(frozen=True, slots=True)
class Place:
    """A domain, or one part of it: what a head is trained or tested on."""

    domain: str  # the paper's name
    part: str = ""  # "indoor" or "outdoor"; "" is the whole domain


def source_place(name: str) -> Place:
    """Return what a head of this source domain is trained on.

    TacQuad's domains hold the same items, so each is trained on one part and tested on the other:
    trained outdoors, but Tac3D, which was recorded indoors only.
    Raises KeyError for a domain that the paper does not have.
    """
    series = DOMAINS[name].series
    return Place(name, series[-1] if series else "")


def target_places(source: str) -> tuple[Place, ...]:
    """Return what a head of this source domain is tested on (paper, Table of settings).

    Every other domain, but OF 2.0 A and B not on each other, for they share their sensor; and
    other TacQuad domains on the part that the source was not trained on.
    Raises KeyError for a domain that the paper does not have.
    """
    start = DOMAINS[source]
    apart = {"outdoor": "indoor", "indoor": "outdoor"}.get(source_place(source).part, "")
    return tuple(
        Place(name, apart if domain.series else "")
        for name, domain in DOMAINS.items()
        if name != source
        and not (start.sensor == domain.sensor == "Taxim")
        and (not apart or not domain.series or apart in domain.series)
    )


def simulated(name: str) -> str:
    """Return the name of the simulated stand-in of a domain: "TAG" gives "TAG-sim"."""
    return name + SIMULATED_SUFFIX


def is_simulated(name: str) -> bool:
    """Tell whether a domain name says that its images were simulated."""
    return name.endswith(SIMULATED_SUFFIX)


def paper_name(name: str) -> str:
    """Return the paper's name for a domain, whether real or simulated."""
    return name.removesuffix(SIMULATED_SUFFIX)
