"""What the figures of a trial say, in sentences: each pair of a domain, and what to take."""

from collections.abc import Sequence
from typing import Any

import numpy as np

WORDS = {"both": "both", "vis": "photo only", "tac": "touch only"}
PROBE = "linear maps"  # of the same vectors: the yardstick
Record = dict[str, Any]  # of a domain


def probe_of(view: str) -> str:
    """Return the name of the linear maps' reading in the records."""
    return f"{PROBE}, {view}"


def sentence(record: Record) -> str:
    """Return the figures of a record; the interval counts objects, since pairs of one are alike."""
    views = [name for name in WORDS if name in record]
    main = record[views[0]]
    n, objects = record["pairs"], record["objects"]
    text = (
        f"{round(main['share'] * n)} of {n} pairs right, {percent(main['share'])} "
        f"(95 %: {100 * main['low']:.0f} to {100 * main['high']:.0f}, of {objects} objects)"
    )
    if record["uneven"]:
        text += f", balanced over classes {percent(record['balanced'][views[0]])}"
    others = [f"{WORDS[name]} {percent(record[name]['share'])}" for name in views[1:]]
    others.append(f"{PROBE} of the same vectors {percent(record[probe_of(views[0])]['share'])}")
    text += (
        f"; {', '.join(others)}, always its largest class"
        f" {percent(record['always the largest class'])}."
    )
    best = max(views, key=lambda name: record[name]["share"])
    if record[best]["share"] > main["high"]:
        text += f" {WORDS[best].capitalize()} beats both images: one of the two misleads this head."
    return text


def conclusion(records: Sequence[Record], source: str) -> str:
    """Return in one sentence what predicts best: in other domains than the source if there are any.

    A lead counts if it exceeds half the width of the head's interval, and a method if its interval
    is above the share of the largest class.
    """
    away = [record for record in records if record["domain"] != source]
    tested = away or records
    if not tested:
        return "In short: no figure can be had from these pairs."
    views = [name for name in WORDS if name in tested[0]]

    def mean(name: str) -> float:
        return float(np.mean([record[name]["share"] for record in tested]))

    def above(name: str) -> bool:
        return float(np.mean([record[name]["low"] for record in tested])) > always

    always = float(np.mean([record["always the largest class"] for record in tested]))
    width = (
        float(np.mean([record[views[0]]["high"] - record[views[0]]["low"] for record in tested]))
        / 2
    )
    head = max(views, key=mean)
    plain = max(views, key=lambda view: mean(probe_of(view)))
    where = "another sensor" if away else "objects that it did not see"
    lead = mean(head) - mean(probe_of(plain))
    level = f"always naming the largest class ({percent(always)})"
    able = {"the head": above(head), "the linear maps": above(probe_of(plain))}
    if not any(able.values()):
        advice = f"neither is above {level} within the uncertainty, so take neither"
    elif not all(able.values()):
        only = next(name for name, good in able.items() if good)
        advice = f"take {only}: alone above {level} within the uncertainty"
    elif abs(lead) <= width:
        advice = "they are level within the uncertainty, so take the linear maps, which are simpler"
    else:
        advice = f"take {'the head' if lead > 0 else 'the linear maps'}"
    return (
        f"In short: on {where} the head has {percent(mean(head))} ({WORDS[head]}) and linear maps"
        f" {percent(mean(probe_of(plain)))} ({WORDS[plain]}); {advice}."
    )


def percent(share: float) -> str:
    """Return a share as text in whole percent."""
    return f"{100 * share:.0f} %"
