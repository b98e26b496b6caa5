"""The choices of a training, and their check."""

from typing import TYPE_CHECKING, Any

from app.shared.resources import Resources
from app.shared.state import Question, one_of
from omnivat.data.domains import titled
from omnivat.kit.errors import DataError

if TYPE_CHECKING:
    from omnivat.data.store import Embeddings
    from omnivat.training import TrainingPlan

WIDTHS = (16, 32, 64, 128)
ORDERS = {  # what p does, in words
    "gradient": "learn p by gradient",
    "fixed": "keep p fixed",
    "search": "search for p",
    "every": "train for every p",
}
# name -> words, least, most, at first: those of the default head; whole numbers or not
NUMBERS: dict[str, tuple[str, float, float, float]] = {
    "p": ("initial p", 0.0, 1.0, 0.5),
    "mma": ("λ, weight of MMA", 0.0, 50.0, 10.0),
    "levels": ("R, tree levels", 1, 5, 3),
    "expansion": ("E, tokens", 1, 8, 4),
    "noise": ("noise on embeddings, std", 0.0, 5.0, 4.0),  # of each channel
    "shift": ("imitated sensors, std", 0.0, 2.0, 1.0),  # of a batch along the source's covariance
    "epochs": ("epochs", 5, 150, 120),
    "seed": ("seed", 0, 999, 0),
}


def offered(resources: Resources) -> tuple[list[str], str, bool]:
    """Return the domains to learn from, the one at first, and whether LANG can guide: its bank has
    each class of the set.

    Raises DataError for a set in which no domain has pairs of two classes.
    """
    from omnivat.data.materials import NO_CLASS
    from omnivat.encoders.lang.bank import DEFAULT_BANK, load_bank

    embeddings, source = resources.embeddings(), resources.head().source
    domains = list(embeddings.learnable)
    if not domains:
        raise DataError(
            "No domain has pairs of two classes, so there is nothing to train a head on."
        )
    wanted = set(embeddings.header.classes) - {NO_CLASS}
    lang = wanted <= set(load_bank(DEFAULT_BANK).classes)
    return domains, source if source in domains else domains[0], lang


def plan_from(question: Question, embeddings: "Embeddings") -> "TrainingPlan":
    """Return the training that a request names; missing settings have their defaults. Raises
    DataError for a wrong one, or for a source without pairs of two classes.

    question  {"source": domain, "width", "order": what p does, "p": initial value, "mma": λ,
              "levels": R, "expansion": E, "noise", "shift", "lang": true to use LANG, "epochs",
              "seed"}
    """
    from omnivat.training import TrainSettings, plan_training

    source = one_of("source", question.get("source"), embeddings.header.domains)
    order = one_of("order", question.get("order", "gradient"), ORDERS)
    number: dict[str, Any] = {name: _number(name, question.get(name)) for name in NUMBERS}
    training = TrainSettings(
        epochs=number["epochs"],
        mma_weight=number["mma"],
        lang=question.get("lang", True) is True,
        order_search=order == "search",
        order_draw=order == "every",
        noise=number["noise"],
        shift=number["shift"],
    )
    head = {
        "width": one_of("width", question.get("width", 64), WIDTHS),
        "expansion": number["expansion"],
        "levels": number["levels"],
        "order": number["p"],
        "learn_order": order in ("gradient", "search"),
    }
    return plan_training(embeddings, source, head=head, training=training, seed=number["seed"])


def in_words(plan: "TrainingPlan", question: Question) -> str:
    """Return the settings of a plan that a request named, in one line."""
    numbers = [
        f"{words.split(',')[0]} = {_number(name, question.get(name)):g}"
        for name, (words, *_) in NUMBERS.items()
    ]
    order = ORDERS[question.get("order", "gradient")]
    lang = "LANG" if plan.training.lang else "no LANG"
    return ", ".join([titled(plan.source), f"D = {plan.settings.width}", order, *numbers, lang])


def _number(name: str, value: Any) -> int | float:
    _, low, high, first = NUMBERS[name]
    if value is None:
        return first
    whole = isinstance(first, int)
    fits = isinstance(value, int if whole else int | float) and not isinstance(value, bool)
    if not fits or not low <= value <= high:
        kind = "a whole number" if whole else "a number"
        raise DataError(f"{name} is {value!r:.40}; give {kind} from {low:g} to {high:g}.")
    return value if whole else float(value)
