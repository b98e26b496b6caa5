"""A sensor's card in words and as JSON."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from omnivat.measure.card.card import SensorCard
from omnivat.measure.card.changes import COLOURS, cost_of

# grain, of 255, and sharpness of the simulated gels (python -m benchmarks.sensor --gel-traits)
GELS = {
    "GelSight": (4.8, 0.78),
    "GelSlim": (3.6, 0.65),
    "DIGIT": (4.4, 0.62),
    "GelSight Mini": (2.4, 0.75),
    "DuraGel": (3.4, 0.70),
}


def record(card: SensorCard) -> Mapping[str, Any]:
    """Return the card as JSON takes it; `changed` lists parts, the likeliest first."""
    lit = card.lamps
    share, _ = card.of("dots")
    found: dict[str, Any] = {
        "pictures": card.pictures,
        "size": list(card.size),
        "lamps": None if lit is None else lit.colours.round(2).tolist(),
        "confidence": None if lit is None else round(lit.confidence, 3),
        "halves": None if card.halves is None else round(card.halves, 3),
        "no_lamps": card.unlit,
        "tint": card.field.mean((0, 1)).round(1).tolist(),
        "uneven": round(card.uneven, 3),
        "dots": round(share, 3),
        "pitch": rounded(card.of("pitch")[0]),
        "strength": rounded(card.of("strength")[0]),
        "sharpness": rounded(card.of("sharpness")[0]),
        "noise": rounded(np.exp(card.of("noise")[0])),
        "missing": card.missing,
    }
    if card.changes is not None:
        found["changed"] = [change.part for change in card.changes]
        found["changes"] = [change._asdict() for change in card.changes]
    return found


def rounded(value: float) -> float | None:
    """Return a number with three decimals, or None for NaN."""
    return None if value != value else round(float(value), 3)


def markdown(card: SensorCard, title: str) -> str:
    """Return the card as Markdown."""
    share, _ = card.of("dots")
    grain, sharp, pitch = (card.of(row)[0] for row in ("noise", "sharpness", "pitch"))
    tint = card.field.mean((0, 1))
    rows = [
        ("pictures", f"{card.pictures} of {card.size[0]} × {card.size[1]} pixels"),
        ("lamps", lamps_in_words(card)),
        ("gel's mean colour", " ".join(f"{n} {v:.0f}" for n, v in zip(COLOURS, tint, strict=True))),
        ("unevenness of its light", f"{100 * card.uneven:.0f} % of its mean"),
        (
            "printed dots",
            f"in {100 * share:.0f} % of the pictures"
            + (f", {100 * pitch:.1f} % of the picture apart" if pitch == pitch else ""),
        ),
        ("grain", f"{np.exp(grain):.1f} of 255 (simulated gels {_gels(0, 1)})"),
        (
            "sharpness",
            f"{np.exp(sharp):.2f} (simulated gels {_gels(1, 2)})"
            if sharp == sharp
            else "grain drowns the edges",
        ),
    ]
    text = [f"# {title}", "", "| what | found |", "| --- | --- |"]
    text += [f"| {name} | {words} |" for name, words in rows]
    text += ["", card.missing] if card.missing else []
    if card.changes is not None:
        text += ["", changes_in_words(card)]
    return "\n".join(text) + "\n"


def _gels(which: int, digits: int) -> str:
    """Return the range of a number over the simulated gels."""
    values = [numbers[which] for numbers in GELS.values()]
    return f"{min(values):.{digits}f} to {max(values):.{digits}f}"


def lamps_in_words(card: SensorCard) -> str:
    """Return from where each colour comes, and how sure that is; or why it is not known."""
    if card.lamps is None:
        return card.unlit
    colours = card.lamps.colours
    angles = np.degrees(np.arctan2(colours[:, 1], -colours[:, 0])) % 360
    words = [f"{name} from {angle:.0f}°" for name, angle in zip(COLOURS, angles, strict=True)]
    halves = "" if card.halves is None else f", halves of the pictures agree at {card.halves:.2f}"
    return (
        f"{', '.join(words)} (0° is the right, 90° the top); confidence"
        f" {card.lamps.confidence:.2f}{halves}"
    )


def changes_in_words(card: SensorCard) -> str:
    """Return what changed as numbered sentences."""
    if not card.changes:
        return "Nothing changed that these pictures show."
    lines = ["What changed, the likeliest first:", ""]
    for number, change in enumerate(card.changes, 1):
        sentences = (change.evidence, cost_of(change.part), change.remedy)
        lines.append(f"{number}. **{change.part}**: {' '.join(filter(None, sentences))}")
    return "\n".join(lines)
