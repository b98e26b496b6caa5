"""Try a pair: the head's predictions for one pair, and their reliability."""

import base64
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from app.shared.familiar import familiar, looked_at, predict_one, readings_of
from app.shared.map_place import journey
from app.shared.messages import without_places
from app.shared.pair_input import lamps_in, pair_request, reader_of, rounded, within
from app.shared.requests import FILES
from app.shared.resources import Resources
from app.shared.state import ForgottenError, InTwo, Question, Reply
from omnivat.data.domains import is_simulated
from omnivat.kit.errors import DataError
from omnivat.kit.progress import checkpoint
from omnivat.kit.stages import STOPS

if TYPE_CHECKING:
    import numpy as np
    import torch

    from omnivat.head.checkpoint import Head
    from omnivat.head.head import OmniVaT
    from omnivat.head.output import HeadOutput

TITLE = "Try a pair"
READINGS = ("fused", "vis", "tac")  # both, photo only, touch only
MOST_AT_ONCE = 25  # pairs of one request; a page with more sends several
Work = Callable[[Resources, Question], Reply]
COLUMNS = 256  # columns of the spectrum; each shows the maximum of its entries


def gallery(resources: Resources) -> list[Reply]:
    """Return the examples to choose from."""
    return [
        {"name": name, "domain": domain, "class": material, "simulated": is_simulated(domain)}
        for name in resources.examples()
        for domain, material, _ in [name.split("/")]
    ]


def answered(resources: Resources, question: Question) -> Reply | InTwo:
    """Return the prediction of one pair; and then, `with` names of PARTS, what else the page shows
    of it, or the `problem` of a part.
    """
    wanted = question.get("with") or []
    if not isinstance(wanted, list) or any(str(name) not in PARTS for name in wanted):
        raise DataError(f"with has to be a list of {', '.join(PARTS)}.")
    reply = predicted(resources, question)
    names = [name for name in PARTS if name in wanted and (name != "moving" or reply["linear"])]
    if not names:
        return reply
    later = {**question, FILES: []}  # they are read, and need not wait for it
    return InTwo(reply, lambda: {name: _quietly(PARTS[name], resources, later) for name in names})


def _quietly(work: Callable[..., Reply], *given: Any) -> Reply:
    """Return what some work gives, or its `problem`."""
    checkpoint()
    try:
        return work(*given)
    except ForgottenError:
        raise
    except DataError as error:
        return {"problem": without_places(str(error))}


def predicted(resources: Resources, question: Question) -> Reply:
    """Predict one pair at the learned order, and at every stop with the same weights.

    question  {"vis": reference or None, "tac": reference or None, "order": p or None,
              "head": name of a comparison head, the first one if left out,
              "lessons": the visitor's labelled pairs, to predict by a head taught from them}
    return    classes, the learned order and the `span` of orders the head was trained for;
              `linear`: whether linear maps decide, in which p has no part; `touch`: how an own
              touch is read, "" in colours;
              `exact`: class probabilities of each reading at that order; `stops`: the same at
              each of STOPS, without branches; spectra; `images`: the familiarity of each image,
              as `app.shared.familiar.looked_at` has it
    """
    import torch

    from omnivat.kit.threads import one_thread

    named = pair_request(resources, question)
    head = named.head
    exact = head.model.order if named.order is None else named.order
    with torch.inference_mode(), one_thread():  # a second one waits more than it works
        out = at_orders(head.model, named.pair, (*STOPS, exact))
        readings = {name: values.numpy() for name, values in out.readings.items()}
        magnitudes = {name: torch.hypot(*values)[:-1].numpy() for name, values in out.frft.items()}
    return {
        "classes": list(head.settings.classes),
        "learned": head.model.order,
        "span": trained_span(head),
        "linear": head.settings.maps,
        "touch": touch_words(resources, question),
        "stops": {name: rounded(readings[name][:-1]) for name in READINGS if name in readings},
        "exact": {
            "order": exact,
            "readings": {name: rounded(values[-1:])[0] for name, values in readings.items()},
        },
        "spectra": {name: spectrum(values) for name, values in magnitudes.items()},
        "images": looked_at(named),
    }


def touch_words(resources: Resources, question: Question) -> str:
    """Return how a visitor's own touch is read, and by whose lamps; "" in colours."""
    from omnivat.data.relief.files import TOUCH, reading_of

    own = str(question.get("tac") or "").startswith("image:")
    if not own or resources.touch == TOUCH[0]:
        return ""
    return reading_of(resources.touch, lamps_in(resources, question), " of your profile")


def many(resources: Resources, question: Question) -> Reply:
    """Return the head's predictions for several pairs, at its learned order if none is named.

    question  {"pairs": [{"vis", "tac": references}, …], at most MOST_AT_ONCE; "lessons"}
    return    classes; `pairs`: `readings` and `images` of each, as
              `app.shared.familiar.predict_one` has them, or its `problem`

    Raises DataError for another number of pairs, ForgottenError for a profile that is not kept.
    """
    given = question.get("pairs")
    if not isinstance(given, list) or not all(isinstance(request, dict) for request in given):
        raise DataError("pairs has to be a list of pairs with a photo, a touch or both.")
    if not 0 < len(given) <= MOST_AT_ONCE:
        raise DataError(f"{len(given)} pairs were sent; send 1 to {MOST_AT_ONCE} at a time.")
    head, _ = reader_of(resources, question)

    def read(request: Question) -> Reply:
        return predict_one(pair_request(resources, within(question, request)))

    found = [_quietly(read, request) for request in given]
    return {"classes": list(head.settings.classes), "pairs": found}


def rivals(resources: Resources, question: Question) -> dict[str, Reply]:
    """Predict one pair by every comparison head, each at its learned order.

    question  {"vis", "tac": references}
    return    name of the head -> its `classes` and `exact`, as `predicted` has them, or the
              `problem` of a head that cannot read the pair
    """

    def read(name: str) -> Reply:
        named = pair_request(resources, {**question, "head": name})
        exact = {"order": named.head.model.order, "readings": readings_of(named)}
        return {"classes": list(named.head.settings.classes), "exact": exact}

    return {name: _quietly(read, name) for name in resources.folders if name}


def by_chapters(part: Work) -> Work:
    """Return a part of the reply by the head of the chapters, as it was trained."""
    plain = {"head": "", "lessons": None, "taught": ""}
    return lambda resources, question: part(resources, {**question, **plain})


PARTS: dict[str, Work] = {
    "familiar": familiar,
    "rivals": by_chapters(rivals),
    "journey": by_chapters(journey),
    "moving": by_chapters(predicted),  # where p has no part in the prediction
}


def trained_span(head: "Head") -> list[float]:
    """Return the orders [low, high] that the head was trained for: the learned one twice if p
    was not drawn.
    """
    if not head.provenance.get("train", {}).get("order_draw"):
        return [head.model.order, head.model.order]
    from omnivat.training.settings import DRAWN

    return list(DRAWN)


def at_orders(
    model: "OmniVaT",
    pair: "Mapping[str, torch.Tensor | None]",
    orders: Sequence[float],
    *,
    attention: bool = False,
) -> "HeadOutput":
    """Return the head's output for one pair at P orders, in one batch."""
    import torch

    kept = model.coefficients(pair["vis"], pair["tac"])
    many = kept[torch.zeros(len(orders), dtype=torch.long)]
    return model.from_coefficients(many, torch.tensor(orders), attention=attention)


def attention(resources: Resources, question: Question) -> Reply:
    """Return FrATT's attention at every stop: the weights of each query over the tokens.

    question  as for `predicted`
    return    `count`: modality -> the number T of its tokens; `off`: modality -> bytes
              (P, T, T) in base64, how far a weight lies from 1/T: 127 stands for `scale`, and
              bytes above 127 for negative values, as a signed byte has it

    Raises DataError for a head without MFFA.
    """
    import torch

    named = pair_request(resources, question)
    head = named.head
    if not head.settings.mffa:
        raise DataError("This head has no MFFA, so there is no attention to show.")
    with torch.inference_mode():
        found = at_orders(head.model, named.pair, STOPS, attention=True).attention
    weights = torch.stack(list(found.values()))
    count = weights.shape[-1]
    coded, scale = from_even(weights, 1 / count)
    off = {n: base64.b64encode(part.numpy()).decode() for n, part in zip(found, coded, strict=True)}
    return {"count": dict.fromkeys(found, count), "off": off, "scale": float(scale)}


def from_even(weights: "torch.Tensor", even: "float | torch.Tensor") -> "tuple[torch.Tensor, ...]":
    """Return how far weights lie from `even`, as signed bytes, and the distance that 127 is."""
    import torch

    off = weights - even
    scale = off.abs().max()
    scale = torch.where(scale > 0, scale, 1)
    return (off / scale * 127).round().to(torch.int8), scale


def spectrum(magnitudes: "np.ndarray[Any, Any]") -> Reply:
    """Return |F_p| (P, D) as a picture of bytes, row by row, with what 255 stands for.

    If D exceeds the picture's width, neighbouring entries are reduced to their maximum.
    """
    import numpy as np

    stops, width = magnitudes.shape
    columns = min(width, COLUMNS)
    edges = np.arange(columns) * width // columns
    joined = np.maximum.reduceat(magnitudes, edges, axis=1)
    top = float(joined.max()) or 1.0
    pixels = np.rint(joined / top * 255).astype(np.uint8)
    return {
        "rows": stops,
        "columns": columns,
        "width": width,
        "top": top,
        "pixels": base64.b64encode(pixels.tobytes()).decode(),
    }
