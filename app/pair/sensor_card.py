"""My sensor: the card of a visitor's touches, and what changed against another folder."""

from typing import TYPE_CHECKING

from app.pair.pictures import decoded, files_in, preview
from app.shared.mend import FILL
from app.shared.resources import Resources
from app.shared.state import Question, Reply
from omnivat.kit.progress import checkpoint

if TYPE_CHECKING:
    from collections.abc import Iterator

    from omnivat.measure.card.card import SensorCard
    from omnivat.measure.card.traits import Array

MOST_TOUCHES = 50  # of a card's request: 25 of each folder
FILLS = "The head that reads the pictures fills printed dots, so there is nothing to do."


def card(resources: Resources, question: Question) -> Reply:
    """Return the cards of one or two folders of touches, and what changed between them.

    question  the touches of the new folder came with it, then those of the old one; {"new": how
              many are of the new folder}
    return    `cards`, of each folder; `changes`, the likeliest first, null for one folder: each
              with its evidence, cost and remedy, and what undoes it here, `mend` or a `profile`;
              `gels`: grain and sharpness of simulated ones

    Raises DataError for fewer than five touches or too many.
    """
    import numpy as np

    from omnivat.data.dots import dots_of
    from omnivat.measure.card.card import card_of
    from omnivat.measure.card.changes import changes_between, cost_of
    from omnivat.measure.card.report import GELS

    touches = []
    for k, part in enumerate(files_in(question, MOST_TOUCHES, "touch"), 1):
        touches.append(np.asarray(decoded(resources, part, {"name": f"touch {k}"})))
    count = question.get("new")
    new = count if isinstance(count, int) and count > 0 else len(touches)
    cards: list[SensorCard] = []
    for folder in (touches[:new], touches[new:]):
        if folder or not cards:
            cards.append(card_of(_checked(folder)))
    fills = dots_of(resources.head().encoder["preprocessing"]) == "fill"
    changes = None
    if len(cards) == 2:
        changes = [
            {
                "part": change.part,
                "evidence": change.evidence,
                "cost": cost_of(change.part),
                "mend": change.way or (FILL if change.part == "dots" and not fills else ""),
                "profile": not change.way and change.part not in ("dots", "scale"),
                "remedy": FILLS if change.part == "dots" and fills else change.remedy,
            }
            for change in changes_between(cards[1], cards[0])
        ]
    return {"cards": [_drawn(one) for one in cards], "changes": changes, "gels": GELS}


def _checked(touches: "list[Array]") -> "Iterator[Array]":
    """Yield touches; a cancelled request ends there."""
    for touch in touches:
        checkpoint()
        yield touch


def _drawn(card: "SensorCard") -> Reply:
    """Return a card's numbers, its gel's light as a picture, and its lamps' directions (3, 2)."""
    import numpy as np
    from PIL import Image

    from omnivat.measure.card.report import record

    light = Image.fromarray(np.clip(card.field, 0, 255).round().astype(np.uint8))
    return {**record(card), "background": preview(light.resize((112, 112)))}
