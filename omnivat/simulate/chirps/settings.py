"""Settings of a set of chirps, frozen and flat."""

from dataclasses import dataclass
from typing import Annotated

from omnivat.config import Within, require_declared
from omnivat.data.domains import SIMULATED_SUFFIX
from omnivat.errors import SettingsError

MOST_DOMAINS = 8
CLEARANCE = 0.25  # least distance between p* and the order of any interference
Share = Annotated[float, Within(0.0, 1.0)]
Size = Annotated[float, Within(0.0, 1000.0)]


@dataclass(frozen=True, slots=True, kw_only=True)
class ChirpSettings:
    """A set of chirps; docs/order.md has the recipe.

    The defaults give the shipped set.
    """

    width: Annotated[int, Within(8, 8192)] = 64  # D, samples of a signal
    order: Share = 0.35  # p*, where the signal of a class is a single spike, in [0, 1]
    strength: Size = 2.0  # norm of the interference over that of the signal
    noise: Size = 0.05  # standard deviation of white noise on every sample
    shift: Share = 1.0  # 0: all domains share the source's interference orders; 1: each has its own
    spikes: Annotated[int, Within(1, 64)] = 3  # of interference, at random positions
    domains: Annotated[int, Within(1, MOST_DOMAINS)] = 4  # the first is the source
    classes: Annotated[int, Within(2, 16)] = 5
    pairs_per_class: Annotated[int, Within(2, 100_000)] = 40  # of each domain
    test_share: Annotated[float, Within(0.0, 0.9)] = 0.5  # of each class of each domain, rounded
    seed: int = 0

    def __post_init__(self) -> None:
        require_declared(self)
        if self.classes > self.width // 2 - 1:
            raise SettingsError(
                f"{self.classes} classes need a width of {2 * self.classes + 2} or more, "
                f"got {self.width}."
            )

    @property
    def class_names(self) -> tuple[str, ...]:
        """The classes, "chirp 1" first."""
        return tuple(f"chirp {number + 1}" for number in range(self.classes))

    @property
    def domain_names(self) -> tuple[str, ...]:
        """The domains, "Chirps A-sim" first."""
        return tuple(f"Chirps {chr(65 + k)}{SIMULATED_SUFFIX}" for k in range(self.domains))
