"""What a set of chirps is made of, frozen and flat."""

from dataclasses import dataclass

from omnivat.data.domains import SIMULATED_SUFFIX
from omnivat.errors import SettingsError

MOST_DOMAINS = 8
CLEARANCE = 0.25  # least distance between p* and the order of any interference


@dataclass(frozen=True, slots=True, kw_only=True)
class ChirpSettings:
    """A set of chirps; docs/order.md has the recipe.

    The defaults make the shipped set.
    """

    width: int = 64  # D, samples of a signal
    order: float = 0.35  # p*, where the signal of a class is a single spike, in [0, 1]
    strength: float = 2.0  # norm of the interference over that of the signal
    noise: float = 0.05  # standard deviation of white noise on every sample
    shift: float = 1.0  # 0: interference of every domain has the source's orders; 1: its own
    spikes: int = 3  # of interference, each at a random place
    domains: int = 4  # the first is meant as the source
    classes: int = 5
    pairs_per_class: int = 40  # of each domain
    test_share: float = 0.5  # of each class of each domain, rounded
    seed: int = 0

    def __post_init__(self) -> None:
        for name, low, high in (
            ("width", 8, 8192),
            ("order", 0.0, 1.0),
            ("strength", 0.0, 1000.0),
            ("noise", 0.0, 1000.0),
            ("shift", 0.0, 1.0),
            ("spikes", 1, 64),
            ("domains", 1, MOST_DOMAINS),
            ("classes", 2, 16),
            ("pairs_per_class", 2, 100_000),
            ("test_share", 0.0, 0.9),
        ):
            value = getattr(self, name)
            if not low <= value <= high:
                raise SettingsError(f"{name} is {value}; choose {low} to {high}.")
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
