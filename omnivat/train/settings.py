"""How a head is trained, frozen and flat."""

from dataclasses import dataclass

from omnivat.errors import SettingsError

SELECTIONS = ("last", "source-val")
MODALITIES = ("vis+tac", "vis", "tac")


@dataclass(frozen=True, slots=True, kw_only=True)
class TrainSettings:
    """How a head is trained; reasons in docs/method.md."""

    epochs: int = 20
    batch: int = 16
    lr: float = 0.05
    momentum: float = 0.9
    weight_decay: float = 5e-4  # not on p and θ_e
    warmup_epochs: float = 1.0
    clip: float = 1.0  # gradient norm of all but p
    order_lr_scale: float = 0.01  # p's gradient is tens of times larger than the rest
    order_clip: float = 1.0  # p's gradient, by value
    mma_weight: float = 10.0  # λ
    nod_weight: float = 1.0
    lang: bool = True
    lang_drop: float = 0.5  # share of pairs that train without LANG, as they are predicted
    class_token_drop: float = 0.5  # share that see no label in their class token
    selection: str = "last"
    val_fraction: float = 0.2  # of the source's objects, for "source-val"
    modalities: str = "vis+tac"  # what the head learns from, and is then asked with

    def __post_init__(self) -> None:
        for name, allowed in (("selection", SELECTIONS), ("modalities", MODALITIES)):
            value = getattr(self, name)
            if value not in allowed:
                raise SettingsError(f"{name} is '{value}'; choose one of {', '.join(allowed)}.")
        for name, low, high in (
            ("epochs", 1, 100_000),
            ("batch", 1, 65_536),
            ("lr", 0.0, 100.0),
            ("mma_weight", 0.0, 1e6),
            ("nod_weight", 0.0, 1e6),
            ("lang_drop", 0.0, 1.0),
            ("class_token_drop", 0.0, 1.0),
            ("val_fraction", 0.0, 0.9),
        ):
            if not low <= getattr(self, name) <= high:
                raise SettingsError(f"{name} is {getattr(self, name)}; choose {low} to {high}.")

    @property
    def given(self) -> tuple[str, ...]:
        """The modalities by name, VIS first."""
        return tuple(self.modalities.split("+"))
