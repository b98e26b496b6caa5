"""The paper's eight visual-tactile domains, and the names of simulated ones."""

from collections.abc import Sequence
from dataclasses import dataclass

from omnivat.kit.errors import DataError

SIMULATED_SUFFIX = "-sim"
TOTAL = "all"  # name of figures over all domains in tables and curves


@dataclass(frozen=True, slots=True, kw_only=True)
class Domain:
    """One way of collecting pairs: a tactile sensor and a data set (paper, Table of datasets)."""

    name: str  # as the paper writes it
    sensor: str
    series: tuple[str, ...] = ()  # parts of TacQuad: "indoor", "outdoor"
    ceramic: bool = True  # TacQuad has no ceramic objects

    @property
    def title(self) -> str:
        """The sensor, and the data set in brackets."""
        return f"{self.sensor} ({self.name})"


DOMAINS = {
    domain.name: domain
    for domain in (
        Domain(name="TAG", sensor="GelSight"),
        Domain(name="OF Real", sensor="GelSlim"),
        Domain(name="OF 2.0 A", sensor="Taxim GelSight"),
        Domain(name="OF 2.0 B", sensor="Taxim GelSight Mini"),
        Domain(name="TQ-DIGIT", sensor="DIGIT", series=("indoor", "outdoor"), ceramic=False),
        Domain(
            name="TQ-GelMini", sensor="GelSight Mini", series=("indoor", "outdoor"), ceramic=False
        ),
        Domain(name="TQ-DuraGel", sensor="DuraGel", series=("indoor", "outdoor"), ceramic=False),
        Domain(name="TQ-T3D", sensor="Tac3D", series=("indoor",), ceramic=False),
    )
}


def sensor_of(domain: str) -> str:
    """Return the sensor of a domain of the paper, real or simulated; else the domain's own name,
    which may tell it.
    """
    known = DOMAINS.get(paper_name(domain))
    return known.sensor if known else domain


def titled(domain: str) -> str:
    """Return a domain by its sensor and data set; an unknown one keeps its name.

    >>> titled("TAG-sim"), titled("my-sensor")
    ('GelSight (TAG)', 'my-sensor')
    """
    known = DOMAINS.get(name := paper_name(domain))
    return known.title if known else name


def simulated(name: str) -> str:
    """Return the name of the simulated stand-in of a domain: "TAG" gives "TAG-sim"."""
    return name + SIMULATED_SUFFIX


def is_simulated(name: str) -> bool:
    """True if a domain's name marks simulated images."""
    return name.endswith(SIMULATED_SUFFIX)


def paper_name(name: str) -> str:
    """Return the paper's name for a domain, whether real or simulated."""
    return name.removesuffix(SIMULATED_SUFFIX)


def require_domain_names(domains: Sequence[str]) -> None:
    """Raise DataError if a domain has the name of figures over all domains."""
    if TOTAL in domains:
        raise DataError(
            f"A domain is called '{TOTAL}', the name of figures over all domains; rename the"
            " domain."
        )
