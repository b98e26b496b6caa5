"""Settings of a training, frozen and flat."""

from dataclasses import dataclass
from typing import Annotated

from omnivat.head.losses import MMA_WEIGHT, NOD_WEIGHT
from omnivat.kit.config import OneOf, Within, require_declared
from omnivat.kit.errors import SettingsError

Inputs = Annotated[str, OneOf(("vis+tac", "vis", "tac"))]
Pairs = Annotated[str, OneOf(("unguided", "guided", "all"))]  # by the use of LANG in a step
Share = Annotated[float, Within(0.0, 1.0)]
Amount = Annotated[float, Within(0.0, 100.0)]
Weight = Annotated[float, Within(0.0, 1e6)]
DRAWN = (-0.1, 1.1)  # where p is drawn: a little more than a quarter turn


@dataclass(frozen=True, slots=True, kw_only=True)
class TrainSettings:
    """How a head is trained; docs/method.md gives reasons, docs/order.md those for the order.

    >>> settings = TrainSettings(epochs=5, lang=False)
    >>> settings.epochs, settings.batch, settings.lr, settings.given
    (5, 16, 0.05, ('vis', 'tac'))
    >>> TrainSettings(epochs=0)
    Traceback (most recent call last):
    omnivat.kit.errors.SettingsError: epochs is 0; choose 1 to 100000.
    """

    epochs: Annotated[int, Within(1, 100_000)] = 20
    batch: Annotated[int, Within(1, 65_536)] = 16
    lr: Amount = 0.05
    momentum: Annotated[float, Within(0.0, 0.9999)] = 0.9
    weight_decay: Amount = 5e-4  # not on p and θ_e
    warmup_epochs: Annotated[float, Within(0.0, 100_000)] = 1.0
    clip: Annotated[float, Within(1e-6, 1e6)] = 1.0  # gradient norm of all but p
    order_lr_scale: Annotated[float, Within(0.0, 1000.0)] = 0.01  # p's gradient is far larger
    order_clip: Annotated[float, Within(0.0, 1e12)] = 1.0  # p's gradient, by value
    mma_weight: Weight = MMA_WEIGHT  # λ
    nod_weight: Weight = NOD_WEIGHT
    lang: bool = True
    lang_drop: Share = 0.5  # share of pairs that train without LANG, as in prediction
    class_token_drop: Share = 0.5  # share of pairs with the class-agnostic token
    bank_from: Pairs = "unguided"  # pairs that update the bank of class tokens
    mma_on: Pairs = "all"  # pairs that L_MMA acts on
    modalities: Inputs = "vis+tac"  # input in training, and by default in prediction
    order_search: bool = False  # search for p in closed form, then use the gradient
    order_draw: bool = False  # draw p anew for every pair, from DRAWN: a head for every order
    order_teachers: Annotated[int, Within(0, 100)] = 0  # heads at one order each, to learn from
    noise: Amount = 0.0  # on embeddings, in std of each channel
    shift: Amount = 0.0  # an offset a batch: an imitated sensor

    def __post_init__(self) -> None:
        require_declared(self)
        if self.order_teachers and not self.order_draw:
            raise SettingsError(
                f"order_teachers is {self.order_teachers} and order_draw is false: teachers serve a"
                " head for every order. Set order_draw to true, or order_teachers to 0."
            )
        if self.order_search and self.order_draw:
            raise SettingsError(
                "order_search and order_draw exclude each other: one finds a p, the other trains"
                " for all. Choose one."
            )

    @property
    def given(self) -> tuple[str, ...]:
        """The names of the modalities, VIS first."""
        return tuple(self.modalities.split("+"))
