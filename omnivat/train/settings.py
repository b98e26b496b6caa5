"""Settings of a training, frozen and flat."""

from dataclasses import dataclass

from omnivat.errors import SettingsError
from omnivat.orders import LIMIT

SELECTIONS = ("last", "source-val")
INPUTS = ("vis+tac", "vis", "tac")
PAIRS = ("unguided", "guided", "all")  # by the use of LANG in a step
ORDER_DRAWS = ("none", "batch", "row")
# the range of every number in TrainSettings; NaN is outside
RANGES: dict[str, tuple[float, float]] = {
    "epochs": (1, 100_000),
    "batch": (1, 65_536),
    "lr": (0.0, 100.0),
    "momentum": (0.0, 0.9999),
    "weight_decay": (0.0, 100.0),
    "warmup_epochs": (0.0, 100_000),
    "clip": (1e-6, 1e6),
    "order_lr_scale": (0.0, 1000.0),
    "order_clip": (0.0, 1e12),
    "mma_weight": (0.0, 1e6),
    "nod_weight": (0.0, 1e6),
    "lang_drop": (0.0, 1.0),
    "class_token_drop": (0.0, 1.0),
    "val_fraction": (0.0, 0.9),
    "order_stops": (2, 1001),
    "order_low": (-LIMIT, LIMIT),
    "order_high": (-LIMIT, LIMIT),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class TrainSettings:
    """How a head is trained; docs/method.md gives reasons, docs/order.md those for the order."""

    epochs: int = 20
    batch: int = 16
    lr: float = 0.05
    momentum: float = 0.9
    weight_decay: float = 5e-4  # not on p and θ_e
    warmup_epochs: float = 1.0
    clip: float = 1.0  # gradient norm of all but p
    order_lr_scale: float = 0.01  # p's gradient is tens of times larger than the others
    order_clip: float = 1.0  # p's gradient, by value
    mma_weight: float = 10.0  # λ
    nod_weight: float = 1.0
    lang: bool = True
    lang_drop: float = 0.5  # share of pairs that train without LANG, as in prediction
    class_token_drop: float = 0.5  # share of pairs with the class-agnostic token
    bank_from: str = "unguided"  # pairs that update the bank of class tokens
    mma_on: str = "all"  # pairs that L_MMA acts on
    selection: str = "last"
    val_fraction: float = 0.2  # of the source's objects, for "source-val"
    modalities: str = "vis+tac"  # input in training, and by default in prediction
    order_search: bool = False  # search for p by short trainings, then use the gradient
    order_stops: int = 21  # of that grid, from 0 to 1
    order_draw: str = "none"  # draw p at random for each "batch" or each "row"
    order_low: float = 0.0  # range of the draw
    order_high: float = 1.0

    def __post_init__(self) -> None:
        for name, allowed in (
            ("selection", SELECTIONS),
            ("modalities", INPUTS),
            ("bank_from", PAIRS),
            ("mma_on", PAIRS),
            ("order_draw", ORDER_DRAWS),
        ):
            value = getattr(self, name)
            if value not in allowed:
                raise SettingsError(f"{name} is '{value}'; choose one of {', '.join(allowed)}.")
        for name, (low, high) in RANGES.items():
            if not low <= getattr(self, name) <= high:
                raise SettingsError(f"{name} is {getattr(self, name)}; choose {low:g} to {high:g}.")
        if self.order_low > self.order_high:
            raise SettingsError(
                f"order_low is {self.order_low} and order_high {self.order_high}; "
                "give the smaller one first."
            )
        if self.order_search and self.order_draw != "none":
            raise SettingsError(
                "order_search and order_draw exclude each other: one finds a p, "
                "the other trains for all. Choose one."
            )

    @property
    def given(self) -> tuple[str, ...]:
        """The names of the modalities, VIS first."""
        return tuple(self.modalities.split("+"))
